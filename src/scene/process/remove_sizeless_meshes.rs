//! Removes meshes without extent.

use super::split::replace_mesh_indices;
use crate::scene::Scene;

impl Scene {
    /// Removes meshes whose vertices all have one position, and meshes without vertices.
    ///
    /// Before: an end site with a zero OFFSET holds a knob of radius 0. After: the end site holds nothing, and the
    /// following meshes have new indices. In Assimp this is part of the step "find invalid data".
    pub fn remove_sizeless_meshes(&mut self) {
        let mut replacements = Vec::with_capacity(self.meshes.len());
        let mut kept = 0;
        self.meshes.retain(|mesh| {
            let has_size = mesh.vertices.iter().any(|&vertex| vertex != mesh.vertices[0]);
            replacements.push(if has_size { vec![kept] } else { Vec::new() });
            kept += usize::from(has_size);
            has_size
        });
        replace_mesh_indices(&mut self.nodes, &replacements);
    }
}
