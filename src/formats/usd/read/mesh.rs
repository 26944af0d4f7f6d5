//! Reads the meshes of a layer that are bound to joints of the skeleton, with their materials and blend shapes.
//!
//! Points keep their coordinates before `geomBindTransform`, which becomes part of each bone's offset matrix. A point
//! whose faces have several normals or texture coordinates becomes several vertices. A mesh with material subsets
//! becomes one mesh for each subset.

use std::collections::{BTreeMap, HashMap};

use glam::{DMat4, Vec2};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{Assumption, Bone, Mesh, NodeId, Scene, Topic, VertexWeight};

use super::above::transform;
use super::blend_shapes::Shapes;
use super::faces::{Corner, Faces, Normals, Numbers, parts};
use super::index::Index;
use super::material::Materials;
use super::skeleton::Skeleton;
use crate::usd::SKELETON_MESH;
use crate::usd::parse::Prim;
use crate::warnings::Warnings;
use crate::{ReadOptions, Source};

/// The attribute with the joints of each point.
const INDICES: &str = "primvars:skel:jointIndices";

/// The largest number of joints that may move all vertices of a mesh in the same way. One joint moves a rigid mesh.
const MOST_FOR_ALL: usize = 8;

/// Names of texture coordinates if a material states none, the most usual first.
const USUAL_COORDS: [&str; 4] = ["st", "UVMap", "map1", "uv"];

/// Adds the meshes with consistent numbers. Other meshes are skipped with a warning, and counted.
pub(super) fn add(
    index: &Index<'_>,
    skeleton: &Skeleton,
    source: &Source<'_>,
    options: &ReadOptions,
    shapes: &mut Shapes<'_>,
    (scene, warnings): (&mut Scene, &mut Warnings),
) {
    let mut materials = Materials::of(index, source);
    let mut joints = Joints::of(index, skeleton);
    let mut left_out = 0;
    let prims = index.layer.prims.iter().enumerate();
    for (mesh, prim) in prims.filter(|(_, prim)| prim.kind == "Mesh") {
        // The importer draws the skeleton again.
        if prim.attributes.contains_key(SKELETON_MESH) && !options.for_comparison {
            continue;
        }
        let has_skin = prim.attributes.contains_key(INDICES);
        let coords = prim.attributes.values().filter(|attribute| attribute.is_of_texture);
        let coords = coords.count();
        let read = match &mut joints {
            Some(joints) if joints.moves(mesh) => joints.meshes(mesh, &mut materials, shapes),
            _ => Err("no joint of the skeleton moves it"),
        };
        let read = match read {
            Ok(read) => read,
            Err(reason) => {
                left_out += 1;
                scene.lose(DataKind::Meshes, 1);
                scene.lose(DataKind::Skins, usize::from(has_skin));
                scene.lose(DataKind::UvSets, coords);
                // Many files have props in addition to the figure. Such props are only counted.
                if has_skin {
                    let message = format!("the mesh \"{}\" was skipped: {reason}", prim.name);
                    warnings.distinct(Diagnostic::new(Code::IgnoredMesh, message));
                }
                continue;
            }
        };
        scene.lose(DataKind::UvSets, coords.saturating_sub(1));
        for mesh in read {
            scene.nodes[0].meshes.push(scene.meshes.len());
            scene.meshes.push(mesh);
        }
    }
    materials.give(scene, warnings);
    if left_out > 0 {
        scene.metadata.assumptions.push(Assumption {
            topic: Topic::Meshes,
            choice: "skinned".to_owned(),
            reason: format!("mocap did not read meshes that no joint moves ({left_out})"),
            confidence: None,
        });
    }
}

/// The joints of a skeleton, in its order.
struct Joints<'a> {
    index: &'a Index<'a>,
    skeleton: &'a Skeleton,
    /// The node of each joint, and its bind matrix.
    all: Vec<(usize, DMat4)>,
    /// The index in `all` of each joint path.
    places: HashMap<&'a str, usize>,
    /// The joint indices of prims that state their own order.
    orders: HashMap<usize, Vec<Option<usize>>>,
}

impl<'a> Joints<'a> {
    fn of(index: &'a Index<'a>, skeleton: &'a Skeleton) -> Option<Self> {
        let prim = &index.layer.prims[skeleton.prim];
        let (matrices, rest) = prim.numbers("bindTransforms").as_chunks::<16>();
        let names = prim.texts("joints");
        if !rest.is_empty() || matrices.len() != names.len() {
            return None;
        }
        let of_joint = |(path, matrix): (&'a String, &[f64; 16])| {
            let matrix = DMat4::from_cols_array(matrix);
            let is_sound = matrix.is_finite() && matrix.inverse().is_finite();
            Some((*skeleton.joints.get(path)?, matrix)).filter(|_| is_sound)
        };
        let all = std::iter::zip(names, matrices).map(of_joint);
        Some(Self {
            index,
            skeleton,
            all: all.collect::<Option<_>>()?,
            places: (names.iter().enumerate())
                .map(|(place, path)| (path.as_str(), place))
                .collect(),
            orders: HashMap::new(),
        })
    }

    /// Whether a mesh is bound to this skeleton. A mesh that names no skeleton is bound to this one, because the file
    /// has one skeleton.
    fn moves(&self, mesh: usize) -> bool {
        let bound = self.index.skeletons[mesh];
        bound.is_none_or(|prim| prim == Some(self.skeleton.prim))
            && self.index.layer.prims[mesh].attributes.contains_key(INDICES)
    }

    /// A mesh for each material.
    fn meshes(
        &mut self,
        mesh: usize,
        materials: &mut Materials<'_>,
        shapes: &mut Shapes<'_>,
    ) -> Result<Vec<Mesh>, &'static str> {
        let index = self.index;
        let prim = &index.layer.prims[mesh];
        let faces = Faces::of(prim)?;
        let ties = self.ties(mesh, faces.points.len())?;
        let normals = Normals::of(prim, &faces);
        let targets = shapes.of_mesh(mesh, &faces.points);
        let bind = prim.numbers("primvars:skel:geomBindTransform");
        let bind = <[f64; 16]>::try_from(bind).map_or(DMat4::IDENTITY, |columns| DMat4::from_cols_array(&columns));
        let mut meshes = Vec::new();
        for (material, part) in parts(index, mesh, &faces) {
            let material = materials.index_of(material, prim);
            let coords = coords(prim, materials.coords(material));
            let coords = coords.and_then(|name| Numbers::of(prim, name, 2, &faces));
            let (corners, indices) = faces.corners(&part, &normals, coords.as_ref());
            if indices.is_empty() {
                continue;
            }
            let texture = |corner: &Corner| {
                let coords = coords.as_ref()?.at(corner.coords);
                // Texture coordinates start at the lower left corner of an image in USD, and at the upper left in a
                // scene.
                Some(Vec2::new(coords[0] as f32, 1.0 - coords[1] as f32)).filter(|coords| coords.is_finite())
            };
            let texture_coords: Vec<Vec2> = corners.iter().filter_map(texture).collect();
            meshes.push(Mesh {
                name: prim.display_name().unwrap_or(&prim.name).clone(),
                vertices: (corners.iter())
                    .map(|corner| faces.points[corner.point as usize])
                    .collect(),
                normals: corners.iter().map(|corner| normals.at(corner.normal)).collect(),
                texture_coords: match texture_coords.len() == corners.len() {
                    true => texture_coords,
                    false => Vec::new(),
                },
                indices,
                bones: self.bones(&ties, &corners, bind)?,
                morph_targets: shapes.on(&targets, corners.iter().map(|corner| corner.point)),
                material_index: material,
                ..Mesh::default()
            });
        }
        meshes.iter_mut().for_each(Mesh::add_targets_at_rest);
        match meshes.is_empty() {
            true => Err("it has no face"),
            false => Ok(meshes),
        }
    }

    /// The joints of each point, with weights that sum to 1, as indices into `all`.
    fn ties(&mut self, mesh: usize, count: usize) -> Result<Vec<Vec<(usize, f32)>>, &'static str> {
        let index = self.index;
        let prim = &index.layer.prims[mesh];
        let (ties, weights) = (prim.numbers(INDICES), prim.numbers("primvars:skel:jointWeights"));
        if ties.len() != weights.len() || ties.is_empty() || count == 0 {
            return Err("its numbers of weights and joints differ");
        }
        let order = index.orders[mesh].map(|stating| {
            let places = &self.places;
            let place = |path: &String| places.get(path.as_str()).copied();
            let own = || index.layer.prims[stating].texts("skel:joints").iter().map(place);
            &*self.orders.entry(stating).or_insert_with(|| own().collect())
        });
        let known = self.all.len();
        let place = |joint: f64| {
            let joint = Some(joint as usize).filter(|index| *index as f64 == joint)?;
            match order {
                Some(order) => *order.get(joint)?,
                None => Some(joint).filter(|joint| *joint < known),
            }
        };
        // One list of joints for each point, or one list for all points.
        let is_for_all = match prim.attributes[INDICES].interpolation() {
            Some("constant") => true,
            Some(_) => false,
            None => !ties.len().is_multiple_of(count) && ties.len() <= MOST_FOR_ALL,
        };
        if !is_for_all && !ties.len().is_multiple_of(count) {
            return Err("its number of weights does not match its points");
        }
        let each = if is_for_all { ties.len() } else { ties.len() / count };
        let lists = std::iter::zip(ties.chunks_exact(each), weights.chunks_exact(each));
        let list = |(ties, weights): (&[f64], &[f64])| -> Option<Vec<(usize, f32)>> {
            let is_tied = |(_, weight): &(&f64, &f64)| **weight > 0.0 && weight.is_finite();
            let tied = || std::iter::zip(ties, weights).filter(is_tied);
            let sum: f64 = tied().map(|(_, weight)| weight).sum();
            let tie = |(joint, weight): (&f64, &f64)| Some((place(*joint)?, (weight / sum) as f32));
            tied().map(tie).collect()
        };
        let lists: Option<Vec<_>> = lists.map(list).collect();
        let lists = lists.ok_or("it has a joint that the skeleton lacks")?;
        Ok(match is_for_all {
            true => vec![lists[0].clone(); count],
            false => lists,
        })
    }

    fn bones(&self, ties: &[Vec<(usize, f32)>], corners: &[Corner], bind: DMat4) -> Result<Vec<Bone>, &'static str> {
        let mut weights: BTreeMap<usize, Vec<VertexWeight>> = BTreeMap::new();
        for (vertex_id, corner) in (0_u32..).zip(corners) {
            let own = &ties[corner.point as usize];
            // A point without weights follows the first joint.
            let first = own.is_empty().then_some((0, 1.0));
            for (joint, weight) in own.iter().copied().chain(first) {
                let of_joint = weights.entry(joint).or_default();
                match of_joint.last_mut().filter(|last| last.vertex_id == vertex_id) {
                    Some(known) => known.weight += weight,
                    None => of_joint.push(VertexWeight { vertex_id, weight }),
                }
            }
        }
        let bone = |(joint, weights): (usize, Vec<VertexWeight>)| {
            let (node, matrix) = self.all[joint];
            let offset_matrix = transform(matrix.inverse() * bind)?;
            let is_sound = offset_matrix.is_finite() && offset_matrix.inverse().is_finite();
            is_sound.then(|| Bone {
                name: self.skeleton.nodes[node].name.clone(),
                node: NodeId::new(node),
                offset_matrix,
                weights,
            })
        };
        let bones: Option<Vec<Bone>> = weights.into_iter().map(bone).collect();
        bones.ok_or("its bind pose has no inverse")
    }
}

/// The name of a mesh's texture coordinates: the name that the material states, or else a usual name, or else any name.
fn coords<'a>(prim: &'a Prim, stated: Option<&str>) -> Option<&'a String> {
    let of = |name: &str| prim.attributes.get_key_value(&format!("primvars:{name}"));
    let usual = || USUAL_COORDS.into_iter().find_map(of);
    let found = stated.and_then(of).or_else(usual).map(|(name, _)| name);
    let of_texture = || prim.attributes.iter().filter(|(_, attribute)| attribute.is_of_texture);
    found.or_else(|| of_texture().map(|(name, _)| name).min())
}
