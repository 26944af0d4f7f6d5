//! Scenes to write, and the positions of their nodes.

use std::collections::HashMap;

use mocap::glam::{DMat4, Mat4, Quat, Vec3};
use mocap::scene::{Animation, Bone, Channel, Keys, Material, Mesh, Node, NodeId, NodeKind, Scene, VertexWeight};

use super::read::Read;

/// The node-to-world matrix of every node of `scene` in a frame, from its keys only.
pub(crate) fn world_of_scene(scene: &Scene, frame: usize) -> Vec<DMat4> {
    let mut local: Vec<_> = scene.nodes.iter().map(|node| node.transform.as_dmat4()).collect();
    let mut used = HashMap::new();
    for channel in scene.animations.iter().flat_map(|animation| &animation.channels) {
        let nth = used.entry(&channel.node_name).or_insert(0);
        let same = scene
            .nodes
            .iter()
            .enumerate()
            .filter(|(_, node)| node.name == channel.node_name);
        let (node, _) = same
            .filter(|(_, node)| node.kind != NodeKind::EndSite)
            .nth(*nth)
            .unwrap();
        *nth += 1;
        let translation = channel.position_keys.values[frame.min(channel.position_keys.len() - 1)].as_dvec3();
        let rotation = channel.rotation_keys.values[frame.min(channel.rotation_keys.len() - 1)].as_dquat();
        local[node] = DMat4::from_rotation_translation(rotation.normalize(), translation);
    }
    let mut world: Vec<DMat4> = Vec::new();
    for (node, local) in scene.nodes.iter().zip(local) {
        world.push(node.parent.map_or(DMat4::IDENTITY, |parent| world[parent.index()]) * local);
    }
    world
}

/// Asserts that file and scene have the same pose in each of `frames` frames.
pub(crate) fn assert_same_motion(scene: &Scene, read: &Read, frames: usize, tolerance: f64) {
    let ticks_per_second = scene.animations[0].ticks_per_second;
    for frame in 0..frames {
        let (ours, theirs) = (
            world_of_scene(scene, frame),
            read.world((frame as f64 / ticks_per_second) as f32),
        );
        for (index, node) in scene.nodes.iter().enumerate() {
            let distance = ours[index].w_axis.distance(theirs[index].w_axis);
            assert!(distance <= tolerance, "frame {frame}, node {}: {distance}", node.name);
        }
    }
}

pub(crate) fn node(name: &str, parent: Option<u32>, offset: Vec3) -> Node {
    let transform = Mat4::from_translation(offset);
    Node {
        name: name.into(),
        parent: parent.map(NodeId),
        transform,
        ..Node::default()
    }
}

pub(crate) fn end_site(name: &str, parent: u32, offset: Vec3) -> Node {
    Node {
        kind: NodeKind::EndSite,
        ..node(name, Some(parent), offset)
    }
}

/// Hips that walk and turn, a leg that swings, and a neck that stays bent.
pub(crate) fn walker(frames: usize) -> Scene {
    let nodes = vec![
        node("Hips", None, Vec3::new(0.0, 90.0, 0.0)),
        node("Leg", Some(0), Vec3::new(10.0, -5.0, 0.0)),
        end_site("EndSite_Leg", 1, Vec3::new(0.0, -80.0, 3.0)),
        node("Neck", Some(0), Vec3::new(0.0, 60.0, 0.0)),
        end_site("EndSite_Neck", 3, Vec3::new(0.0, 20.0, 0.0)),
    ];
    let phase = |frame: usize| frame as f32 * 0.31;
    let walk = |frame| Vec3::new(phase(frame), 90.0 + phase(frame).sin(), 4.0 * phase(frame));
    let turn = |frame| Quat::from_rotation_y(phase(frame)) * Quat::from_rotation_x(0.3 * phase(frame).cos());
    let swing = |frame| Quat::from_rotation_x(phase(frame).sin());
    let channel = |name: &str, position_keys, rotation_keys| Channel {
        node_name: name.into(),
        node: None,
        position_keys,
        rotation_keys,
        scaling_keys: Keys::constant(Vec3::ONE),
    };
    let channels = vec![
        channel(
            "Hips",
            Keys::every_tick((0..frames).map(walk).collect()),
            Keys::every_tick((0..frames).map(turn).collect()),
        ),
        channel(
            "Leg",
            Keys::constant(Vec3::new(10.0, -5.0, 0.0)),
            Keys::every_tick((0..frames).map(swing).collect()),
        ),
        channel(
            "Neck",
            Keys::constant(Vec3::new(0.0, 60.0, 0.0)),
            Keys::constant(Quat::from_rotation_z(0.2)),
        ),
    ];
    let duration = frames as f64 - 1.0;
    let animation = Animation {
        name: "Walk".into(),
        ticks_per_second: 120.0,
        duration,
        channels,
    };
    Scene {
        nodes,
        animations: vec![animation],
        ..Scene::default()
    }
}

/// A mesh with a triangle for every node of `scene`, bound to the node in the rest pose. Corners run clockwise from
/// outside, and triangles share no corner, as in skeleton meshes.
pub(crate) fn with_skinned_mesh(mut scene: Scene) -> Scene {
    let mut mesh = Mesh::default();
    for (index, matrix) in world_of_scene(
        &Scene {
            animations: vec![],
            ..scene.clone()
        },
        0,
    )
    .iter()
    .enumerate()
    {
        let first = mesh.vertices.len() as u32;
        for corner in [Vec3::ZERO, Vec3::Y, Vec3::X] {
            mesh.vertices.push(matrix.as_mat4().transform_point3(corner));
            mesh.normals.push(Vec3::Z);
            mesh.indices.push(mesh.indices.len() as u32);
        }
        mesh.bones.push(Bone {
            name: scene.nodes[index].name.clone(),
            node: NodeId::new(index),
            offset_matrix: matrix.as_mat4().inverse(),
            weights: (first..first + 3)
                .map(|vertex_id| VertexWeight { vertex_id, weight: 1.0 })
                .collect(),
        });
    }
    scene.meshes.push(mesh);
    scene.materials.push(Material {
        name: "SkeletonMaterial".into(),
        two_sided: true,
        surface: None,
    });
    scene.nodes[0].meshes.push(0);
    scene
}
