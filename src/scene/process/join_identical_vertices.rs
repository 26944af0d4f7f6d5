//! Merges equal vertices.

use std::collections::HashMap;

use glam::Vec3;

use super::split::{NewIds, renumbered_bones};
use crate::scene::{Mesh, Scene};

/// The squared distance of normals below which they count as equal: Assimp's limit.
const NORMAL_TOLERANCE: f32 = 1e-5;

impl Scene {
    /// Merges equal vertices, so that all their faces share one.
    ///
    /// Before: a joint with three children at one position has three equal pointers of 12 vertices each. After: 12
    /// vertices for 12 faces. The first of equal vertices is kept, and the order does not change.
    ///
    /// Two vertices are equal under four conditions:
    ///
    /// - Their positions are equal bit by bit.
    /// - Their normals differ by less than 1e-5.
    /// - Their texture coordinates are equal.
    /// - The same bones move them by equal weights.
    ///
    /// Assimp lacks the last condition, so it moves vertices of one bone to another if two links coincide. A mesh with
    /// morph targets does not change: a target may move coincident vertices apart.
    pub fn join_identical_vertices(&mut self) {
        for mesh in self.meshes.iter_mut().filter(|mesh| mesh.morph_targets.is_empty()) {
            join(mesh);
        }
    }
}

fn join(mesh: &mut Mesh) {
    let mut kept: Vec<usize> = Vec::new();
    let mut kept_at: HashMap<(PositionBits, TextureBits, Ties), Vec<usize>> = HashMap::new();
    let mut new_index = Vec::with_capacity(mesh.vertices.len());
    for (vertex, ties) in ties(mesh).into_iter().enumerate() {
        let normal = mesh.normals[vertex];
        let candidates = kept_at
            .entry((position_bits(mesh.vertices[vertex]), texture_bits(mesh, vertex), ties))
            .or_default();
        let equal = candidates
            .iter()
            .copied()
            .find(|&new| normal.abs_diff_eq(mesh.normals[kept[new]], NORMAL_TOLERANCE));
        new_index.push(equal.unwrap_or_else(|| {
            candidates.push(kept.len());
            kept.push(vertex);
            kept.len() - 1
        }));
    }
    let new_ids: NewIds = (0..).zip(&kept).map(|(new, &old)| (old as u32, new)).collect();
    mesh.bones = renumbered_bones(&mesh.bones, &new_ids);
    mesh.vertices = kept.iter().map(|&vertex| mesh.vertices[vertex]).collect();
    mesh.normals = kept.iter().map(|&vertex| mesh.normals[vertex]).collect();
    if !mesh.texture_coords.is_empty() {
        mesh.texture_coords = kept.iter().map(|&vertex| mesh.texture_coords[vertex]).collect();
    }
    for index in &mut mesh.indices {
        *index = new_index[*index as usize] as u32;
    }
}

/// The bits of a position.
type PositionBits = [u32; 3];

fn position_bits(position: Vec3) -> PositionBits {
    position.to_array().map(f32::to_bits)
}

/// The bits of a texture coordinate.
type TextureBits = Option<[u32; 2]>;

fn texture_bits(mesh: &Mesh, vertex: usize) -> TextureBits {
    let position = mesh.texture_coords.get(vertex)?;
    Some(position.to_array().map(f32::to_bits))
}

/// The bones that move a vertex, and the bits of their weights.
type Ties = Vec<(usize, u32)>;

fn ties(mesh: &Mesh) -> Vec<Ties> {
    let mut ties = vec![Ties::new(); mesh.vertices.len()];
    for (index, bone) in mesh.bones.iter().enumerate() {
        for weight in &bone.weights {
            ties[weight.vertex_id as usize].push((index, weight.weight.to_bits()));
        }
    }
    ties
}
