//! Converts a scene to metres with +Y up.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, Mat4, Quat, Vec3};

use crate::pose::Binding;
use crate::scene::{AppliedStep, Mesh, NodeId, Scene, UpAxis};

/// Scales all lengths by `metres_per_unit`, and rotates the scene so that `up` becomes +Y.
///
/// Only the root is rotated, its rest transform and its keys: every joint keeps its own axes, and rotations below the
/// root do not change. +Z up becomes +Y up by a quarter turn about X: (x, y, z) becomes (x, z, -y).
///
/// ```
/// use mocap::glam::{Mat4, Vec3};
/// use mocap::process::convert_units;
/// use mocap::scene::{Node, Scene, UpAxis};
///
/// let hips = Node { transform: Mat4::from_translation(Vec3::new(0.0, 0.0, 98.0)), ..Node::default() };
/// let mut scene = Scene { nodes: vec![hips], ..Scene::default() };
/// convert_units(&mut scene, 0.01, UpAxis::Z);
/// assert_eq!(scene.nodes[0].transform.w_axis.truncate(), Vec3::new(0.0, 0.98, 0.0));
/// ```
pub fn convert_units(scene: &mut Scene, metres_per_unit: f64, up: UpAxis) {
    let scaled = |v: Vec3| (v.as_dvec3() * metres_per_unit).as_vec3();
    for node in &mut scene.nodes {
        node.transform.w_axis = scaled(node.transform.w_axis.truncate()).extend(1.0);
        if node.parent.is_none() {
            node.transform = turn_matrix(up) * node.transform;
        }
    }
    for index in 0..scene.animations.len() {
        let root_channel = root_channel(scene, index);
        for (channel_index, channel) in scene.animations[index].channels.iter_mut().enumerate() {
            let turn = if Some(channel_index) == root_channel {
                up
            } else {
                UpAxis::Y
            };
            for value in &mut channel.position_keys.values {
                *value = turned(scaled(*value), turn);
            }
            if turn == UpAxis::Z {
                for value in &mut channel.rotation_keys.values {
                    *value = turned_rotation(*value);
                }
            }
        }
    }
    for mesh in &mut scene.meshes {
        convert_mesh(mesh, scaled, up);
    }
    scene
        .metadata
        .steps
        .push(AppliedStep::ConvertUnits { metres_per_unit, up });
}

/// The channel that drives the first node.
fn root_channel(scene: &Scene, animation: usize) -> Option<usize> {
    let binding = Binding::new(scene, &scene.animations[animation]);
    let driven = binding.driven().find(|(node, _)| *node == NodeId(0));
    driven.map(|(_, channel)| channel)
}

/// A mesh with bones is in the space of the root's parent, so it is rotated; any other is in the space of its node.
fn convert_mesh(mesh: &mut Mesh, scaled: impl Fn(Vec3) -> Vec3, up: UpAxis) {
    let up = if mesh.bones.is_empty() { UpAxis::Y } else { up };
    for vertex in &mut mesh.vertices {
        *vertex = turned(scaled(*vertex), up);
    }
    for normal in &mut mesh.normals {
        *normal = turned(*normal, up);
    }
    for bone in &mut mesh.bones {
        let translation = scaled(bone.offset_matrix.w_axis.truncate());
        bone.offset_matrix *= turn_matrix(up).transpose();
        bone.offset_matrix.w_axis = translation.extend(1.0);
    }
}

fn turned(v: Vec3, up: UpAxis) -> Vec3 {
    match up {
        UpAxis::Y => v,
        // Adding zero turns -0 into 0.
        UpAxis::Z => Vec3::new(v.x, v.z, 0.0 - v.y),
    }
}

fn turn_matrix(up: UpAxis) -> Mat4 {
    let [x, y, z] = Vec3::AXES.map(|axis| turned(axis, up).extend(0.0));
    Mat4::from_cols(x, y, z, glam::Vec4::W)
}

/// -90 degrees about X, then `rotation`'s own; in double precision, rounded once.
fn turned_rotation(rotation: Quat) -> Quat {
    (DQuat::from_xyzw(-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2) * rotation.as_dquat()).as_quat()
}
