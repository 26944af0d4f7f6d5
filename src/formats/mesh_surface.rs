//! The triangles of a robot's mesh files, for pictures.
//!
//! Details that a picture does not show are dropped. In a mesh with many triangles, corners within a fiftieth of the
//! longest side of the mesh are merged ([Rossignac and Borrel 1993], vertex clustering). Corners at one position share
//! a normal if the normals of their faces are nearest to the same of the six directions along the axes. A file that
//! cannot be read is skipped with a warning, and its link is drawn without a mesh.

mod collada;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::is_plausible;
use mocap_scene::scene::Mesh;
use mocap_scene::scene::robot::{Robot, ShapeKind};

/// Corners of triangles, three each.
type Corners = Vec<DVec3>;

/// The largest number of triangles of one file. A short COLLADA file may show a mesh many times.
const MOST_TRIANGLES: usize = 1_000_000;

/// A mesh with more triangles than this number is simplified.
const MANY_TRIANGLES: usize = 3_000;

/// The resolution at which corners of a large mesh are distinguished, in parts of its longest side.
const PARTS: f64 = 50.0;

/// Reads the surfaces of a robot's meshes. `open` reads a file.
pub(crate) fn add(robot: &mut Robot, open: &dyn Fn(&Path) -> Result<Vec<u8>>) {
    let mut known: HashMap<(std::path::PathBuf, [u64; 3]), Option<Arc<Mesh>>> = HashMap::new();
    let shapes = robot.links.iter_mut().flat_map(|link| &mut link.shapes);
    for shape in shapes {
        let ShapeKind::Mesh {
            path: Some(path),
            scale,
            surface,
            ..
        } = &mut shape.kind
        else {
            continue;
        };
        let key = (path.clone(), scale.to_array().map(f64::to_bits));
        let read = known.entry(key).or_insert_with(|| {
            let found = open(path)
                .ok()
                .and_then(|bytes| corners(&bytes, path))
                .and_then(|corners| mesh_of(corners, *scale));
            if found.is_none() {
                let message = format!(
                    "the mesh {} cannot be read; its link is drawn without it",
                    path.display()
                );
                robot.warnings.push(Diagnostic::new(Code::IgnoredMesh, message));
            }
            found.map(Arc::new)
        });
        surface.clone_from(read);
    }
}

pub fn corners(bytes: &[u8], path: &Path) -> Option<Corners> {
    let extension = path.extension()?.to_ascii_lowercase();
    let corners = match extension.to_str()? {
        "stl" => binary_stl(bytes).or_else(|| text_stl(bytes)),
        "obj" => obj(bytes),
        "dae" => collada::corners(bytes, 3 * MOST_TRIANGLES),
        _ => None,
    }?;
    let are_placed = corners
        .iter()
        .all(|corner| corner.to_array().into_iter().all(is_plausible));
    (are_placed && corners.len() >= 3 && corners.len() <= 3 * MOST_TRIANGLES).then_some(corners)
}

/// The triangles of a binary STL file. The file has 80 bytes, the number of triangles, then 50 bytes for each triangle.
fn binary_stl(bytes: &[u8]) -> Option<Corners> {
    /// Bytes of a triangle of binary STL: twelve numbers of 32 bits, and an attribute of 16.
    const TRIANGLE: usize = 50;
    let count = u32::from_le_bytes(*bytes.get(80..84)?.first_chunk::<4>()?) as usize;
    let triangles = &bytes[84..];
    if count == 0 || triangles.len() / TRIANGLE < count {
        return None;
    }
    let mut corners = Vec::with_capacity(3 * count);
    for triangle in triangles.chunks_exact(TRIANGLE).take(count) {
        for corner in triangle[12..48].as_chunks::<12>().0 {
            let number = |at: usize| {
                f64::from(f32::from_le_bytes([
                    corner[at],
                    corner[at + 1],
                    corner[at + 2],
                    corner[at + 3],
                ]))
            };
            corners.push(DVec3::new(number(0), number(4), number(8)));
        }
    }
    Some(corners)
}

/// The triangles of a text STL file, from its lines `vertex x y z`, three for each triangle.
fn text_stl(bytes: &[u8]) -> Option<Corners> {
    let text = std::str::from_utf8(bytes).ok()?;
    let vertices = text
        .lines()
        .filter_map(|line| line.trim_start().strip_prefix("vertex "));
    let corners: Option<Corners> = vertices.map(|line| numbers(line.split_ascii_whitespace())).collect();
    corners.filter(|corners| corners.len() % 3 == 0)
}

/// The triangles of an OBJ file. `v x y z` is a vertex. `f` lists vertices, counted from 1, or with negative numbers
/// from the last vertex. Numbers after a `/` belong to other lists.
fn obj(bytes: &[u8]) -> Option<Corners> {
    let text = std::str::from_utf8(bytes).ok()?;
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut corners = Vec::new();
    for line in text.lines() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => vertices.push(numbers(words)?),
            Some("f") => {
                let face: Option<Vec<DVec3>> = words
                    .map(|word| {
                        let index: i64 = word.split('/').next()?.parse().ok()?;
                        let index = if index < 0 {
                            vertices.len() as i64 + index
                        } else {
                            index - 1
                        };
                        vertices.get(usize::try_from(index).ok()?).copied()
                    })
                    .collect();
                push_polygon(&face?, &mut corners);
            }
            _ => {}
        }
    }
    Some(corners)
}

/// The triangles of a polygon, as a fan.
pub fn push_polygon(polygon: &[DVec3], corners: &mut Corners) {
    for pair in polygon.windows(2).skip(1) {
        corners.extend([polygon[0], pair[0], pair[1]]);
    }
}

fn numbers<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let mut number = || words.next()?.parse::<f64>().ok();
    Some(DVec3::new(number()?, number()?, number()?))
}

/// The mesh of these triangles; `None` if no triangle has an area.
pub fn mesh_of(mut corners: Corners, scale: DVec3) -> Option<Mesh> {
    corners.iter_mut().for_each(|corner| *corner *= scale);
    if scale.element_product() < 0.0 {
        corners
            .as_chunks_mut::<3>()
            .0
            .iter_mut()
            .for_each(|triangle| triangle.swap(1, 2));
    }
    if corners.len() > 3 * MANY_TRIANGLES {
        cluster(&mut corners);
    }
    let mut mesh = Mesh::default();
    let mut known: HashMap<([u32; 3], u8), u32> = HashMap::new();
    for [a, b, c] in corners.as_chunks::<3>().0 {
        let area = (*b - *a).cross(*c - *a);
        let Some(direction) = area.try_normalize() else {
            continue;
        };
        let side = side(direction);
        for corner in [a, b, c] {
            let vertex = corner.as_vec3();
            let index = *known
                .entry((vertex.to_array().map(f32::to_bits), side))
                .or_insert_with(|| {
                    mesh.vertices.push(vertex);
                    mesh.normals.push(Vec3::ZERO);
                    mesh.vertices.len() as u32 - 1
                });
            // Larger faces have more weight. The weight is the square root of the area, because areas in square metres
            // are tiny numbers.
            mesh.normals[index as usize] += (direction * area.length().sqrt()).as_vec3();
            mesh.indices.push(index);
        }
    }
    mesh.normals
        .iter_mut()
        .for_each(|normal| *normal = normal.normalize_or(Vec3::Z));
    (!mesh.indices.is_empty()).then_some(mesh)
}

/// The nearest of the six directions along the axes, as an index.
fn side(direction: DVec3) -> u8 {
    let axis = direction.abs().max_position() as u8;
    2 * axis + u8::from(direction[axis as usize] < 0.0)
}

/// Replaces the corners within one grid cell by their mean.
fn cluster(corners: &mut Corners) {
    let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let cell = (high - low).max_element() / PARTS;
    let of = |corner: &DVec3| ((*corner - low) / cell).to_array().map(|at| at as i64);
    let mut sums: HashMap<[i64; 3], (DVec3, f64)> = HashMap::new();
    for corner in &*corners {
        let (sum, count) = sums.entry(of(corner)).or_default();
        (*sum, *count) = (*sum + *corner, *count + 1.0);
    }
    for corner in corners {
        let (sum, count) = sums[&of(corner)];
        *corner = sum / count;
    }
}
