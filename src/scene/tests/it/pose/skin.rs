//! Tests that vertices follow their bones.

use std::f32::consts::FRAC_PI_2;

use mocap::glam::{Mat4, Vec3};
use mocap::scene::{Bone, Mesh, Node, NodeId, VertexWeight};
use mocap::{Pose, Scene};

/// An arm along X with two bones of length 1. One vertex is on each bone, one is between them, and one has no weight.
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
