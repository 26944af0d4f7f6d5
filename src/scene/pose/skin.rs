//! Skins in a pose: linear blend skinning.

use glam::Vec3;

use super::Pose;
use crate::scene::Mesh;

impl Pose {
    /// Where the vertices of `mesh` are in the world: each is moved by its bones, node to world x
    /// [offset matrix](crate::scene::Bone::offset_matrix), and the results are averaged by the weights (linear blend
    /// skinning, N. Magnenat-Thalmann, R. Laperriere and D. Thalmann, 1988). A vertex without a weight stays where the
    /// mesh has it.
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
    /// If a bone is tied to a node that the pose does not have.
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

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use glam::Mat4;

    use super::*;
    use crate::scene::{Bone, Node, NodeId, Scene, VertexWeight};

    /// An arm along X, of two bones of length 1, with a vertex on each, one between, and one without a weight.
    #[test]
    fn vertices_follow_their_bones() {
        let upper = Node::default();
        let lower = Node {
            parent: Some(NodeId(0)),
            transform: Mat4::from_translation(Vec3::X),
            ..Node::default()
        };
        let scene = Scene {
            nodes: vec![upper, lower],
            ..Scene::default()
        };
        let bone = |node, offset: Vec3, weights: &[(u32, f32)]| Bone {
            name: String::new(),
            node: NodeId(node),
            offset_matrix: Mat4::from_translation(offset),
            weights: weights
                .iter()
                .map(|&(vertex_id, weight)| VertexWeight { vertex_id, weight })
                .collect(),
        };
        let mesh = Mesh {
            vertices: [0.5, 1.5, 1.0, 7.0].map(|x| Vec3::X * x).to_vec(),
            bones: vec![
                bone(0, Vec3::ZERO, &[(0, 1.0), (2, 0.5)]),
                bone(1, -Vec3::X, &[(1, 1.0), (2, 0.5), (9, 1.0)]),
            ],
            ..Mesh::default()
        };
        let mut pose = Pose::rest(&scene);
        assert_eq!(pose.skin(&mesh), mesh.vertices);

        pose.node_to_parent[1] *= Mat4::from_rotation_z(FRAC_PI_2);
        pose.node_to_parent[0] = Mat4::from_translation(Vec3::Y);
        pose.update_world();
        let by_hand = [
            Vec3::new(0.5, 1.0, 0.0),
            Vec3::new(1.0, 1.5, 0.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(7.0, 0.0, 0.0),
        ];
        for (found, expected) in pose.skin(&mesh).iter().zip(by_hand) {
            assert!(found.distance(expected) < 1e-6, "{found} is not {expected}");
        }
    }
}
