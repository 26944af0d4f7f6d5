//! Skinned meshes: vertices, faces, and the bones that move them.
//!
//! An FBX cluster binds vertices to a bone, and has the matrix from geometry to bone in the bind pose. All clusters of
//! a mesh should give the same geometry-to-world matrix. The mesh is stored in the world, so that it needs no node
//! transform, and a bone's offset matrix maps from the world to the bone.

use std::collections::HashMap;

use glam::{DMat4, DVec3, DVec4, Mat4, Vec3};

use super::Kept;
use crate::error::{Code, Diagnostic};
use crate::format::warnings::Warnings;
use crate::format::{Failure, ReadOptions};
use crate::limits::{is_plausible, limit_exceeded};
use crate::scene::{Bone, Material, Mesh, NodeId, Scene, VertexWeight};

/// Adds the skinned meshes of `file` to the first node of `scene`. Returns the number of other meshes.
pub(super) fn read(
    file: &ufbx::Scene,
    nodes: &[Kept<'_>],
    options: &ReadOptions,
    scene: &mut Scene,
    warnings: &mut Warnings,
) -> Result<usize, Failure> {
    let ids: HashMap<u32, NodeId> = (nodes.iter().enumerate())
        .map(|(index, node)| (node.source.element.element_id, NodeId::new(index)))
        .collect();
    // Positions, normals and corners.
    let values = |mesh: &ufbx::Mesh| 6 * mesh.num_indices as u64 + 3 * mesh.num_triangles as u64;
    let total: u64 = file.meshes.iter().map(|mesh| values(mesh)).sum();
    if total > options.limits.max_values {
        return Err(Box::new(limit_exceeded(
            format!("at most {} values", options.limits.max_values),
            format!("meshes of {total}"),
        )));
    }
    let mut rigid = 0;
    for source in &file.meshes {
        // A mesh may have several skins; programs show the first.
        let Some(skin) = source.skin_deformers.iter().find(|skin| !skin.clusters.is_empty()) else {
            rigid += 1;
            continue;
        };
        let name = name(source);
        match read_mesh(source, skin, &ids, nodes) {
            Some(mesh) if mesh.indices.is_empty() => {}
            Some(mesh) => {
                scene.nodes[0].meshes.push(scene.meshes.len());
                scene.meshes.push(Mesh { name, ..mesh });
            }
            None => warnings.push(Code::IgnoredMesh, || {
                let message = format!(
                    "the bones of the mesh \"{name}\" contradict each other about its bind pose; it was left out"
                );
                Diagnostic::new(Code::IgnoredMesh, message)
            }),
        }
    }
    if !scene.meshes.is_empty() {
        scene.materials.push(Material {
            name: "MeshMaterial".to_owned(),
            two_sided: true,
            surface: None,
        });
    }
    Ok(rigid)
}

/// The name of the first node that shows the mesh, or else of the mesh.
fn name(source: &ufbx::Mesh) -> String {
    let shown = source.element.instances.iter().map(|node| &*node.element.name);
    let mut names = shown.chain([&*source.element.name]);
    names.find(|name| !name.is_empty()).unwrap_or("Mesh").to_owned()
}

/// `None` where the bones are unknown, or a matrix has no inverse.
fn read_mesh(
    source: &ufbx::Mesh,
    skin: &ufbx::SkinDeformer,
    ids: &HashMap<u32, NodeId>,
    nodes: &[Kept<'_>],
) -> Option<Mesh> {
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
    let (corners, indices) = corners(source);
    let to_bind_normal = from_bind.transpose();
    let mut mesh = Mesh {
        indices,
        ..Mesh::default()
    };
    for (vertex_id, &corner) in corners.iter().enumerate() {
        let position = to_bind
            .transform_point3(vector(source.vertex_position[corner]))
            .as_vec3();
        let is_placed = position.to_array().into_iter().all(|value| is_plausible(value.into()));
        mesh.vertices.push(is_placed.then_some(position)?);
        let normal = to_bind_normal.transform_vector3(vector(source.vertex_normal[corner]));
        mesh.normals.push(unit(normal));
        let vertex = source.vertex_indices[corner] as usize;
        for (bone, weight) in weights(skin, vertex, &bone_of_cluster) {
            bones[bone].weights.push(VertexWeight {
                vertex_id: vertex_id as u32,
                weight,
            });
        }
    }
    mesh.bones = bones;
    Some(mesh)
}

/// The corners with different positions or normals, each once, and three indices for each triangle.
fn corners(source: &ufbx::Mesh) -> (Vec<usize>, Vec<u32>) {
    let mut corners = Vec::new();
    let mut indices = Vec::with_capacity(3 * source.num_triangles);
    let mut known = HashMap::new();
    let mut triangles = vec![0; 3 * source.max_face_triangles];
    for &face in source.faces.iter().filter(|face| face.num_indices >= 3) {
        let count = ufbx::triangulate_face(&mut triangles, source, face) as usize;
        for &corner in &triangles[..3 * count] {
            let corner = corner as usize;
            let key = (source.vertex_indices[corner], source.vertex_normal.indices[corner]);
            indices.push(*known.entry(key).or_insert_with(|| {
                corners.push(corner);
                corners.len() as u32 - 1
            }));
        }
    }
    (corners, indices)
}

/// The bones of a vertex, each once, with weights that sum to 1. A vertex without weights follows the first bone.
fn weights(skin: &ufbx::SkinDeformer, vertex: usize, bone_of_cluster: &[usize]) -> Vec<(usize, f32)> {
    let mut shares: Vec<(usize, f64)> = Vec::new();
    let ties = skin.vertices.get(vertex).map_or(0..0, |ties| {
        let begin = ties.weight_begin as usize;
        begin..begin + ties.num_weights as usize
    });
    for tie in ties.map(|tie| &skin.weights[tie]) {
        let bone = bone_of_cluster[tie.cluster_index as usize];
        if !(tie.weight > 0.0 && tie.weight.is_finite()) {
            continue;
        }
        match shares.iter_mut().find(|(known, _)| *known == bone) {
            Some((_, share)) => *share += tie.weight,
            None => shares.push((bone, tie.weight)),
        }
    }
    let sum: f64 = shares.iter().map(|(_, share)| share).sum();
    if !(sum > 0.0 && sum.is_finite()) {
        return vec![(0, 1.0)];
    }
    let shares = shares.into_iter().map(|(bone, share)| (bone, (share / sum) as f32));
    shares.collect()
}

fn vector(v: ufbx::Vec3) -> DVec3 {
    DVec3::new(v.x, v.y, v.z)
}

fn matrix(m: &ufbx::Matrix) -> DMat4 {
    DMat4::from_cols(
        DVec4::new(m.m00, m.m10, m.m20, 0.0),
        DVec4::new(m.m01, m.m11, m.m21, 0.0),
        DVec4::new(m.m02, m.m12, m.m22, 0.0),
        DVec4::new(m.m03, m.m13, m.m23, 1.0),
    )
}

fn inverse(matrix: DMat4) -> Option<DMat4> {
    let inverse = matrix.inverse();
    (matrix.is_finite() && inverse.is_finite()).then_some(inverse)
}

/// The matrix in single precision, if it can be inverted there. The last row is set exactly, because a product's may
/// not be.
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
