//! Replaces triangles without extent by points.

use super::split::{renumbered_bones, replace_mesh_indices, submesh};
use crate::scene::{Mesh, Primitive, Scene};

impl Scene {
    /// Replaces triangles whose three corners coincide by points, in a separate mesh.
    ///
    /// Before: mesh 0 has 8 triangles of a knob with radius 0, and 12 others. After: mesh 0 has 8 points with one
    /// vertex each, and mesh 1 has the 12 triangles. The bones stay with the vertices they move. Every node that held
    /// mesh 0 then holds both meshes. [`remove_sizeless_meshes()`](Scene::remove_sizeless_meshes) removes the points if
    /// they all coincide.
    ///
    /// Assimp's steps "find degenerates" and "sort by primitive type" have this effect on a skeleton mesh. A triangle
    /// with two equal corners, which Assimp turns into a line, stays. No skeleton mesh has such a triangle.
    pub fn find_degenerates(&mut self) {
        let mut replacements = Vec::with_capacity(self.meshes.len());
        let mut meshes = Vec::new();
        for mesh in self.meshes.drain(..) {
            let first = meshes.len();
            let (degenerate, sound): (Vec<usize>, Vec<usize>) =
                (0..mesh.faces().len()).partition(|&face| is_point(&mesh, face));
            if degenerate.is_empty() {
                meshes.push(mesh);
            } else {
                meshes.push(points(&mesh, &degenerate));
                if !sound.is_empty() {
                    let (mut triangles, new_ids) = submesh(&mesh, &sound);
                    triangles.bones = renumbered_bones(&mesh.bones, &new_ids);
                    meshes.push(triangles);
                }
            }
            replacements.push((first..meshes.len()).collect());
        }
        self.meshes = meshes;
        replace_mesh_indices(&mut self.nodes, &replacements);
    }
}

fn is_point(mesh: &Mesh, face: usize) -> bool {
    let corner = |index: usize| mesh.vertices[mesh.indices[3 * face + index] as usize];
    mesh.primitive == Primitive::Triangles && corner(0) == corner(1) && corner(0) == corner(2)
}

/// The first corner of each triangle at `faces`.
fn points(mesh: &Mesh, faces: &[usize]) -> Mesh {
    let corners = Mesh {
        primitive: Primitive::Points,
        indices: faces.iter().map(|&face| mesh.indices[3 * face]).collect(),
        ..mesh.clone()
    };
    let all: Vec<usize> = (0..corners.indices.len()).collect();
    let (mut points, new_ids) = submesh(&corners, &all);
    points.bones = renumbered_bones(&mesh.bones, &new_ids);
    points
}
