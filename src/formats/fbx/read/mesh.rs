//! Reads skinned meshes: vertices, faces, and the bones that move them.
//!
//! An FBX cluster binds vertices to a bone, and has the matrix from geometry to bone in the bind pose. All clusters of
//! a mesh should give the same geometry-to-world matrix. The scene stores the mesh in world space, so that the mesh
//! needs no node transform. A bone's offset matrix maps from the world to the bone.

use std::collections::HashMap;

use glam::{DAffine3, DMat4, DVec3, Mat4, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{is_plausible, limit_exceeded};
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{Bone, Mesh, NodeId, Scene, VertexWeight};

use super::blend_shapes::BlendShapes;
use super::material::{self, Materials, Read};
use super::{KeptNode, Stack};
use crate::fbx::matrix::matrix;
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions, Source};

/// Adds the skinned meshes of `file` to the first node of `scene`, one mesh for each material. Returns the skipped
/// data, as pairs of choice and reason.
pub(super) fn read(
    origin: &Source<'_>,
    file: &ufbx::Scene,
    (nodes, stacks): (&[KeptNode<'_>], &[Stack<'_>]),
    options: &ReadOptions,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<Vec<(&'static str, String)>, Failure> {
    let ids: HashMap<u32, NodeId> = (nodes.iter().enumerate())
        .map(|(index, node)| (node.source.element.element_id, NodeId::new(index)))
        .collect();
    // Positions, normals, texture coordinates and corners.
    let values = |mesh: &ufbx::Mesh| 8 * mesh.num_indices as u64 + 3 * mesh.num_triangles as u64;
    let total: u64 = file.meshes.iter().map(|mesh| values(mesh)).sum();
    if total > options.limits.max_values {
        return Err(Box::new(limit_exceeded(
            format!("at most {} values", options.limits.max_values),
            format!("meshes of {total}"),
        )));
    }
    let mut materials = Materials::new(origin, file);
    let mut shapes = BlendShapes::new(origin, options, stacks);
    let (mut rigid, mut colored, mut shaped, mut doubled, mut dual) = (0, 0, 0, 0, 0);
    for source in &file.meshes {
        // A mesh may have several skins. Programs show the first skin.
        let Some(skin) = source.skin_deformers.iter().find(|skin| !skin.clusters.is_empty()) else {
            rigid += 1;
            continue;
        };
        colored += usize::from(source.vertex_color.exists);
        shaped += usize::from(!source.blend_deformers.is_empty() && !options.morph_targets);
        doubled += usize::from(source.skin_deformers.len() > 1);
        dual += usize::from(has_dual_quaternions(skin));
        let name = name(source);
        let Some(bound) = Bound::new(source, skin, &ids, nodes) else {
            warnings.distinct(contradiction(&name));
            continue;
        };
        if options.for_comparison && states_two_poses(skin) {
            let message =
                format!("a joint of the mesh \"{name}\" has another bind pose in TransformLink than in Transform");
            warnings.distinct(Diagnostic::new(Code::IgnoredMesh, message));
        }
        for (material, faces) in by_material(source) {
            let material = material
                .and_then(|part| source.materials.get(part))
                .map(|material| &**material);
            let Read { index, coords } = materials.read(material, scene, warnings);
            match bound.mesh(&faces, coords, &mut shapes) {
                Some(mesh) if mesh.indices.is_empty() => {}
                Some(mesh) => {
                    scene.nodes[0].meshes.push(scene.meshes.len());
                    scene.meshes.push(Mesh {
                        name: name.clone(),
                        material_index: *index,
                        ..mesh
                    });
                }
                None => {
                    warnings.distinct(contradiction(&name));
                    break;
                }
            }
        }
    }
    let skinned = || {
        file.meshes
            .iter()
            .map(|mesh| &**mesh)
            .filter(|mesh| !mesh.skin_deformers.is_empty())
    };
    let further_sets = skinned().map(|mesh| mesh.uv_sets.len().saturating_sub(1));
    scene.lose(DataKind::UvSets, further_sets.sum());
    scene.lose(DataKind::Meshes, rigid);
    scene.lose(DataKind::VertexColors, colored);
    scene.lose(DataKind::DualQuaternionSkins, dual);
    let channels = skinned()
        .flat_map(|mesh| &mesh.blend_deformers)
        .flat_map(|blend| &blend.channels);
    let read = usize::from(options.morph_targets);
    // A channel has at least one shape, and may have in-betweens.
    let shapes_left = channels.map(|channel| channel.keyframes.len().max(1) - read);
    scene.lose(DataKind::MorphTargets, shapes_left.sum());
    let mut left_out = Vec::new();
    let mut say = |count: usize, choice: &'static str, what: &str| {
        let meshes = if count == 1 { "mesh" } else { "meshes" };
        if count > 0 {
            left_out.push((choice, format!("mocap did not read {what} of {count} {meshes}")));
        }
    };
    say(doubled, "first skin", "further skins");
    say(dual, "linear skins", "dual quaternions of the skins");
    say(shaped, "without blend shapes", "blend shapes");
    say(colored, "without vertex colours", "vertex colours");
    if shapes.are_too_many {
        left_out.push((
            "without some blend shapes",
            "more blend shapes than the limits allow".to_owned(),
        ));
    }
    if rigid > 0 {
        let meshes = if rigid == 1 { "mesh" } else { "meshes" };
        left_out.push(("skinned", format!("mocap did not read {rigid} {meshes} without a skin")));
    }
    if !materials.left_out.is_empty() {
        let names: Vec<_> = materials.left_out.iter().map(String::as_str).collect();
        left_out.push((
            "base colour",
            format!("mocap did not read the textures of {}", names.join(", ")),
        ));
    }
    Ok(left_out)
}

/// Whether the skin blends dual quaternions, fully or partly. A scene blends matrices.
fn has_dual_quaternions(skin: &ufbx::SkinDeformer) -> bool {
    use ufbx::SkinningMethod::{BlendedDqLinear, DualQuaternion};
    matches!(skin.skinning_method, DualQuaternion | BlendedDqLinear)
}

/// Whether clusters disagree about the matrix from the geometry to the world. A cluster has two matrices, and programs
/// differ in the matrix from which they take the bind pose.
fn states_two_poses(skin: &ufbx::SkinDeformer) -> bool {
    /// The rounding error of matrix products, relative to the farthest joint and to the axes.
    const ROUNDING: f64 = 1e-4;
    let to_bind = |cluster: &ufbx::SkinCluster| matrix(&cluster.bind_to_world) * matrix(&cluster.geometry_to_bone);
    let links = skin
        .clusters
        .iter()
        .map(|cluster| matrix(&cluster.bind_to_world).w_axis);
    let farthest = links.map(|origin| origin.truncate().length()).fold(1.0, f64::max);
    let mut all = skin.clusters.iter().map(|cluster| to_bind(cluster));
    let Some(first) = all.next() else { return false };
    all.any(|other| {
        let axes = [
            (first.x_axis, other.x_axis),
            (first.y_axis, other.y_axis),
            (first.z_axis, other.z_axis),
        ];
        let is_turned = axes.into_iter().any(|(a, b)| a.distance(b) > ROUNDING * a.length());
        is_turned || first.w_axis.distance(other.w_axis) > ROUNDING * farthest
    })
}

fn contradiction(name: &str) -> Diagnostic {
    let message =
        format!("the bones of the mesh \"{name}\" contradict each other about its bind pose; the mesh was skipped");
    Diagnostic::new(Code::IgnoredMesh, message)
}

/// The faces of each material, in the order of first use. Faces without a material have `None`.
fn by_material(source: &ufbx::Mesh) -> Vec<(Option<usize>, Vec<ufbx::Face>)> {
    let mut parts: Vec<(Option<usize>, Vec<ufbx::Face>)> = Vec::new();
    let mut part_of: HashMap<Option<usize>, usize> = HashMap::new();
    for (index, face) in source
        .faces
        .iter()
        .enumerate()
        .filter(|(_, face)| face.num_indices >= 3)
    {
        let material = source.face_material.get(index).map(|material| *material as usize);
        let material = material.filter(|material| *material < source.materials.len());
        let part = *part_of.entry(material).or_insert_with(|| {
            parts.push((material, Vec::new()));
            parts.len() - 1
        });
        parts[part].1.push(*face);
    }
    parts
}

/// The name of the first node that shows the mesh, or the name of the mesh.
fn name(source: &ufbx::Mesh) -> String {
    let shown = source.element.instances.iter().map(|node| &*node.element.name);
    let mut names = shown.chain([&*source.element.name]);
    names.find(|name| !name.is_empty()).unwrap_or("Mesh").to_owned()
}

/// A mesh with its binding to bones.
struct Bound<'a> {
    source: &'a ufbx::Mesh,
    skin: &'a ufbx::SkinDeformer,
    to_bind: DMat4,
    from_bind: DMat4,
    /// The bones, without weights.
    bones: Vec<Bone>,
    bone_of_cluster: Vec<usize>,
}

impl<'a> Bound<'a> {
    /// Returns `None` if bones are unknown or a matrix has no inverse.
    fn new(
        source: &'a ufbx::Mesh,
        skin: &'a ufbx::SkinDeformer,
        ids: &HashMap<u32, NodeId>,
        nodes: &[KeptNode<'_>],
    ) -> Option<Self> {
        let first = skin.clusters.first()?;
        let to_bind = matrix(&first.bind_to_world) * matrix(&first.geometry_to_bone);
        let from_bind = inverse(to_bind)?;
        let mut bones: Vec<Bone> = Vec::with_capacity(skin.clusters.len());
        let mut bone_of_node = HashMap::new();
        let mut bone_of_cluster = Vec::with_capacity(skin.clusters.len());
        for cluster in &skin.clusters {
            let node = *ids.get(&cluster.bone_node.as_ref()?.element.element_id)?;
            let offset_matrix = to_single(matrix(&cluster.geometry_to_bone) * from_bind)?;
            bone_of_cluster.push(*bone_of_node.entry(node).or_insert_with(|| {
                bones.push(Bone {
                    name: nodes[node.index()].name(),
                    node,
                    offset_matrix,
                    weights: Vec::new(),
                });
                bones.len() - 1
            }));
        }
        Some(Self {
            source,
            skin,
            to_bind,
            from_bind,
            bones,
            bone_of_cluster,
        })
    }

    /// Makes a mesh of these faces. Returns `None` if a vertex has no position.
    fn mesh(
        &self,
        faces: &[ufbx::Face],
        (set, to_texture): &(String, DAffine3),
        shapes: &mut BlendShapes<'_>,
    ) -> Option<Mesh> {
        let source = self.source;
        let mut sets = source.uv_sets.iter();
        let named = sets.find(|found| !set.is_empty() && *found.name == **set);
        let coords = named.map_or(&source.vertex_uv, |set| &set.vertex_uv);
        let coords = Some(coords).filter(|coords| coords.exists);
        let (corners, indices) = corners(source, faces, coords);
        let to_bind_normal = self.from_bind.transpose();
        let mut mesh = Mesh {
            indices,
            ..Mesh::default()
        };
        let mut bones = self.bones.clone();
        for (vertex_id, &corner) in corners.iter().enumerate() {
            let position = self
                .to_bind
                .transform_point3(vector(source.vertex_position[corner]))
                .as_vec3();
            let is_placed = position.to_array().into_iter().all(|value| is_plausible(value.into()));
            mesh.vertices.push(is_placed.then_some(position)?);
            let normal = to_bind_normal.transform_vector3(vector(source.vertex_normal[corner]));
            mesh.normals.push(unit(normal));
            if let Some(coords) = coords {
                mesh.texture_coords
                    .push(material::texture_coords(coords[corner], to_texture));
            }
            let vertex = source.vertex_indices[corner] as usize;
            for (bone, weight) in weights(self.skin, vertex, &self.bone_of_cluster) {
                bones[bone].weights.push(VertexWeight {
                    vertex_id: vertex_id as u32,
                    weight,
                });
            }
        }
        mesh.morph_targets = shapes.of(source, &corners, (self.to_bind, to_bind_normal));
        mesh.add_targets_at_rest();
        mesh.bones = bones;
        Some(mesh)
    }
}

/// The corners of these faces, without duplicates of equal position, normal and texture coordinate, and three indices
/// for each triangle.
fn corners(source: &ufbx::Mesh, faces: &[ufbx::Face], coords: Option<&ufbx::VertexVec2>) -> (Vec<usize>, Vec<u32>) {
    let mut corners = Vec::new();
    let mut indices = Vec::new();
    let mut known = HashMap::new();
    let mut triangles = vec![0; 3 * source.max_face_triangles];
    for &face in faces {
        let count = ufbx::triangulate_face(&mut triangles, source, face) as usize;
        for &corner in &triangles[..3 * count] {
            let corner = corner as usize;
            let key = (
                source.vertex_indices[corner],
                source.vertex_normal.indices[corner],
                coords.map(|coords| coords.indices[corner]),
            );
            indices.push(*known.entry(key).or_insert_with(|| {
                corners.push(corner);
                corners.len() as u32 - 1
            }));
        }
    }
    (corners, indices)
}

/// The bones of a vertex without duplicates, with weights that sum to 1. A vertex without weights follows the first
/// bone.
fn weights(skin: &ufbx::SkinDeformer, vertex: usize, bone_of_cluster: &[usize]) -> Vec<(usize, f32)> {
    let mut summed: Vec<(usize, f64)> = Vec::new();
    let ties = skin.vertices.get(vertex).map_or(0..0, |ties| {
        let begin = ties.weight_begin as usize;
        begin..begin + ties.num_weights as usize
    });
    for tie in ties.map(|tie| &skin.weights[tie]) {
        let bone = bone_of_cluster[tie.cluster_index as usize];
        if !(tie.weight > 0.0 && tie.weight.is_finite()) {
            continue;
        }
        match summed.iter_mut().find(|(known, _)| *known == bone) {
            Some((_, total)) => *total += tie.weight,
            None => summed.push((bone, tie.weight)),
        }
    }
    let sum: f64 = summed.iter().map(|(_, total)| total).sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return vec![(0, 1.0)];
    }
    let summed = summed.into_iter().map(|(bone, total)| (bone, (total / sum) as f32));
    summed.collect()
}

fn vector(v: ufbx::Vec3) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

fn inverse(matrix: DMat4) -> Option<DMat4> {
    let inverse = matrix.inverse();
    (matrix.is_finite() && inverse.is_finite()).then_some(inverse)
}

/// The matrix in single precision, if it is invertible. The last row is set exactly, because products of matrices round
/// it.
fn to_single(mut matrix: DMat4) -> Option<Mat4> {
    for (column, last) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        matrix.col_mut(column).w = last;
    }
    let single = matrix.as_mat4();
    (single.is_finite() && single.determinant() != 0.0).then_some(single)
}

/// A normal of length 0 is replaced by +Y.
fn unit(normal: DVec3) -> Vec3 {
    normal.try_normalize().map_or(Vec3::Y, DVec3::as_vec3)
}
