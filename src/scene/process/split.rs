//! Helpers for the steps that split meshes.

use std::collections::HashMap;

use crate::scene::{Bone, Mesh, Node, VertexWeight};

/// Maps old vertex ids to new ones, for the kept vertices.
pub(super) type NewIds = HashMap<u32, u32>;

/// The faces at `faces` of `mesh` as a separate mesh without bones, with the vertices they use, numbered by first use.
/// Also returns the numbering.
pub(super) fn submesh(mesh: &Mesh, faces: &[usize]) -> (Mesh, NewIds) {
    let size = mesh.primitive.indices_per_face();
    let mut new_ids = NewIds::new();
    let mut part = Mesh {
        name: mesh.name.clone(),
        primitive: mesh.primitive,
        material_index: mesh.material_index,
        ..Mesh::default()
    };
    for &face in faces {
        for &old in &mesh.indices[face * size..(face + 1) * size] {
            let id = *new_ids.entry(old).or_insert_with(|| {
                part.vertices.push(mesh.vertices[old as usize]);
                part.normals.push(mesh.normals[old as usize]);
                part.texture_coords.extend(mesh.texture_coords.get(old as usize));
                part.vertices.len() as u32 - 1
            });
            part.indices.push(id);
        }
    }
    let targets = mesh.morph_targets.iter();
    part.morph_targets = targets
        .map(|target| target.renumbered(|old| new_ids.get(&old).copied()))
        .collect();
    (part, new_ids)
}

/// The bones that move at least one kept vertex, with the new ids of their vertices.
pub(super) fn renumbered_bones(bones: &[Bone], new_ids: &NewIds) -> Vec<Bone> {
    let renumbered = bones.iter().map(|bone| {
        let weights = bone.weights.iter().filter_map(|weight| {
            let vertex_id = *new_ids.get(&weight.vertex_id)?;
            Some(VertexWeight { vertex_id, ..*weight })
        });
        Bone {
            name: bone.name.clone(),
            weights: weights.collect(),
            ..*bone
        }
    });
    renumbered.filter(|bone| !bone.weights.is_empty()).collect()
}

/// Replaces mesh `i` of every node by the meshes `replacements[i]`.
pub(super) fn replace_mesh_indices(nodes: &mut [Node], replacements: &[Vec<usize>]) {
    for node in nodes {
        let replaced = node.meshes.iter().flat_map(|&mesh| &replacements[mesh]);
        node.meshes = replaced.copied().collect();
    }
}
