//! Reads the faces of a mesh: the corners of triangles, and their normals and texture coordinates.

use std::collections::HashMap;

use glam::Vec3;
use mocap_scene::limits::is_plausible;

use super::index::Index;
use crate::usd::parse::Prim;

/// The faces with one material: the index of its prim, and the indices of the faces.
type Part = (Option<usize>, Vec<usize>);

/// The faces of a mesh by material: the faces of each subset, and the faces without a subset.
pub(super) fn parts(index: &Index<'_>, mesh: usize, faces: &Faces) -> Vec<Part> {
    let mut is_free = vec![true; faces.faces.len()];
    let mut parts: Vec<Part> = Vec::new();
    for subset in index.subsets.get(&mesh).map(Vec::as_slice).unwrap_or_default() {
        let Some(material) = subset.texts("material:binding").first() else {
            continue;
        };
        let material = index.find(material, mesh);
        let mut own = Vec::new();
        for face in subset.numbers("indices").iter().copied().filter_map(whole) {
            if let Some(is_free) = is_free.get_mut(face).filter(|is_free| **is_free) {
                *is_free = false;
                own.push(face);
            }
        }
        parts.push((material, own));
    }
    let others = (0..is_free.len()).filter(|face| is_free[*face]);
    parts.push((index.materials[mesh].flatten(), others.collect()));
    parts.retain(|(_, faces)| !faces.is_empty());
    parts
}

/// A corner of a face: its point, and the positions of its normal and texture coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Corner {
    pub(super) point: u32,
    pub(super) normal: usize,
    pub(super) coords: usize,
}

/// The points of a mesh, and its faces.
pub(super) struct Faces {
    pub(super) points: Vec<Vec3>,
    /// The point of each corner.
    corners: Vec<u32>,
    /// The first corner of each face, and its number of corners; 0 for a hole.
    faces: Vec<(usize, usize)>,
    is_left_handed: bool,
}

impl Faces {
    /// The faces of a prim, or a sentence about the error.
    pub(super) fn of(prim: &Prim) -> Result<Self, &'static str> {
        let (points, _) = prim.numbers("points").as_chunks::<3>();
        if !points.iter().flatten().all(|number| is_plausible(*number)) {
            return Err("a point is not finite, or too large to compute with");
        }
        let points = points.iter().map(|point| Vec3::from(point.map(|number| number as f32)));
        let points: Vec<Vec3> = points.collect();
        let corners = prim.numbers("faceVertexIndices");
        if corners
            .iter()
            .any(|point| whole(*point).is_none_or(|point| point >= points.len()))
        {
            return Err("a face has a point that does not exist");
        }
        let mut faces = Vec::new();
        let mut begin = 0_usize;
        for count in prim.numbers("faceVertexCounts") {
            let end = whole(*count).and_then(|count| begin.checked_add(count));
            let Some(end) = end.filter(|end| *end <= corners.len()) else {
                return Err("its faces need more corners than faceVertexIndices has");
            };
            faces.push((begin, end - begin));
            begin = end;
        }
        for hole in prim.numbers("holeIndices").iter().copied().filter_map(whole) {
            if let Some((_, count)) = faces.get_mut(hole) {
                *count = 0;
            }
        }
        Ok(Self {
            points,
            corners: corners.iter().map(|corner| *corner as u32).collect(),
            faces,
            is_left_handed: prim.texts("orientation").iter().any(|side| side == "leftHanded"),
        })
    }

    /// The positions of the corners of a face's triangles, in the orientation of its front.
    fn triangles(&self, face: usize) -> impl Iterator<Item = [usize; 3]> {
        let (begin, count) = self.faces[face];
        let is_left_handed = self.is_left_handed;
        (2..count).map(move |last| match is_left_handed {
            false => [begin, begin + last - 1, begin + last],
            true => [begin, begin + last, begin + last - 1],
        })
    }

    /// The corners of the triangles of faces without duplicates, and three indices of corners for each triangle. A
    /// whole mesh with one normal and one texture coordinate per point keeps its points, in their order.
    pub(super) fn corners(
        &self,
        faces: &[usize],
        normals: &Normals<'_>,
        coords: Option<&Numbers<'_>>,
    ) -> (Vec<Corner>, Vec<u32>) {
        let corner = |face: usize, at: usize, point: u32| Corner {
            point,
            normal: (normals.stated.as_ref()).map_or(point as usize, |stated| stated.index(face, at, point)),
            coords: coords.map_or(0, |coords| coords.index(face, at, point)),
        };
        let is_by_point = |numbers: &Numbers<'_>| matches!(numbers.place, Place::Point | Place::Whole);
        let keeps_points = faces.len() == self.faces.len()
            && normals.stated.as_ref().is_none_or(is_by_point)
            && coords.is_none_or(is_by_point);
        let places = || {
            faces
                .iter()
                .flat_map(|face| self.triangles(*face).map(move |corners| (*face, corners)))
        };
        let places = places().flat_map(|(face, corners)| corners.map(|at| (face, at)));
        if keeps_points {
            let found = (0..self.points.len() as u32).map(|point| corner(0, 0, point));
            return (found.collect(), places.map(|(_, at)| self.corners[at]).collect());
        }
        let mut found: Vec<Corner> = Vec::new();
        let mut known: HashMap<Corner, u32> = HashMap::new();
        let mut id = |(face, at): (usize, usize)| {
            let corner = corner(face, at, self.corners[at]);
            *known.entry(corner).or_insert_with(|| {
                found.push(corner);
                found.len() as u32 - 1
            })
        };
        let indices = places.map(&mut id).collect();
        (found, indices)
    }
}

/// A whole number of at least 0.
fn whole(number: f64) -> Option<usize> {
    Some(number as usize).filter(|index| *index as f64 == number)
}

/// The kind of elements to which the values of an attribute belong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    Point,
    Corner,
    Face,
    Whole,
}

/// The values of a mesh attribute.
pub(super) struct Numbers<'a> {
    numbers: &'a [f64],
    columns: usize,
    /// The value index of each element; empty if each element has its own value.
    indices: Vec<usize>,
    place: Place,
}

impl<'a> Numbers<'a> {
    /// The values of the attribute `name`; `None` if there are fewer values than elements.
    pub(super) fn of(prim: &'a Prim, name: &str, columns: usize, faces: &Faces) -> Option<Self> {
        let attribute = prim.attributes.get(name)?;
        let numbers = prim.numbers(name);
        let indices = prim.numbers(&format!("{name}:indices")).iter().copied().map(whole);
        let indices: Vec<usize> = indices.collect::<Option<_>>()?;
        let values = numbers.len() / columns;
        let count = if indices.is_empty() { values } else { indices.len() };
        let place = match attribute.interpolation() {
            Some("constant") => Place::Whole,
            Some("uniform") => Place::Face,
            Some("faceVarying") => Place::Corner,
            Some(_) => Place::Point,
            // The number of values determines the kind of element.
            None if count == faces.corners.len() && count != faces.points.len() => Place::Corner,
            None => Place::Point,
        };
        let needed = match place {
            Place::Point => faces.points.len(),
            Place::Corner => faces.corners.len(),
            Place::Face => faces.faces.len(),
            Place::Whole => 1,
        };
        let is_whole = count >= needed && values > 0 && indices.iter().all(|index| *index < values);
        is_whole.then_some(Self {
            numbers,
            columns,
            indices,
            place,
        })
    }

    /// The index of a corner's value, from its face, its position among all corners, and its point.
    fn index(&self, face: usize, corner: usize, point: u32) -> usize {
        let place = match self.place {
            Place::Point => point as usize,
            Place::Corner => corner,
            Place::Face => face,
            Place::Whole => 0,
        };
        self.indices.get(place).copied().unwrap_or(place)
    }

    pub(super) fn at(&self, index: usize) -> &[f64] {
        &self.numbers[index * self.columns..][..self.columns]
    }
}

/// The normals of a mesh.
pub(super) struct Normals<'a> {
    stated: Option<Numbers<'a>>,
    /// A normal for each point, if the file states none.
    computed: Vec<Vec3>,
}

impl<'a> Normals<'a> {
    pub(super) fn of(prim: &'a Prim, faces: &Faces) -> Self {
        let of = |name: &str| Numbers::of(prim, name, 3, faces);
        let stated = of("primvars:normals").or_else(|| of("normals"));
        let mut computed = Vec::new();
        if stated.is_none() {
            computed.resize(faces.points.len(), Vec3::ZERO);
            for triangle in (0..faces.faces.len()).flat_map(|face| faces.triangles(face)) {
                let points = triangle.map(|corner| faces.corners[corner] as usize);
                let [a, b, c] = points.map(|point| faces.points[point]);
                // The length of the normal is twice the area, so that large faces weigh more.
                let normal = (b - a).cross(c - a);
                points.into_iter().for_each(|point| computed[point] += normal);
            }
        }
        Self { stated, computed }
    }

    /// The normal at an index. A normal of length 0 becomes +Y.
    pub(super) fn at(&self, index: usize) -> Vec3 {
        let normal = match &self.stated {
            Some(stated) => {
                let normal = stated.at(index);
                Vec3::new(normal[0] as f32, normal[1] as f32, normal[2] as f32)
            }
            None => self.computed.get(index).copied().unwrap_or_default(),
        };
        normal.normalize_or(Vec3::Y)
    }
}
