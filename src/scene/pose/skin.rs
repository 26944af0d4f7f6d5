//! Computes the vertices of a skin in a pose, by linear blend skinning.

use glam::Vec3;

use super::Pose;
use crate::scene::Mesh;

impl Pose {
    /// The world positions of the vertices of `mesh`, by linear blend skinning (N. Magnenat-Thalmann, R. Laperriere and
    /// D. Thalmann, 1988). For each bone, the product of node to world and [offset
    /// matrix](crate::scene::Bone::offset_matrix) moves the vertex. The result is the mean of these positions, by the
    /// weights. A vertex without weights stays at its position in the mesh.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::{Importer, Pose};
    ///
    /// let scene = Importer::new().gltf_meshes(true).import("fixtures/characters/human_default.glb")?;
    /// let pose = Pose::rest(&scene);
    /// let heights = scene.meshes.iter().flat_map(|mesh| pose.skin(mesh)).map(|vertex| vertex.y);
    /// let highest = heights.fold(f32::MIN, f32::max);
    /// assert!((1.5..2.0).contains(&highest), "{highest} m");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Panics
    /// If a bone refers to a node that the pose lacks.
    pub fn skin(&self, mesh: &Mesh) -> Vec<Vec3> {
        let mut sums = vec![(Vec3::ZERO, 0.0); mesh.vertices.len()];
        for bone in &mesh.bones {
            let to_world = self.node_to_world[bone.node.index()] * bone.offset_matrix;
            for weight in &bone.weights {
                let vertex = weight.vertex_id as usize;
                if let (Some(sum), Some(at_rest)) = (sums.get_mut(vertex), mesh.vertices.get(vertex)) {
                    sum.0 += weight.weight * to_world.transform_point3(*at_rest);
                    sum.1 += weight.weight;
                }
            }
        }
        let averages = sums.into_iter().zip(&mesh.vertices);
        averages
            .map(|((sum, weight), at_rest)| if weight > 0.0 { sum / weight } else { *at_rest })
            .collect()
    }
}
