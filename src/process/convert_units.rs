//! Converts a scene to metres with +Y up.

use glam::{Quat, Vec3};

use crate::math::up_axis::{self, Z_UP_TO_Y_UP};
use crate::pose::Binding;
use crate::scene::{AppliedStep, Mesh, NodeId, Scene, UpAxis};

/// Scales all lengths by `metres_per_unit`, and rotates the scene so that `up` becomes +Y.
///
/// Only the root is rotated, its rest transform and its keys: every joint keeps its own axes, and rotations below the
/// root do not change. +Z up becomes +Y up by a quarter turn about X: (x, y, z) becomes (x, z, -y).
///
/// The scene then says that it is in metres with +Y up. [`Conversion`](crate::convert::Conversion) finds out what
/// `metres_per_unit` and `up` are, and calls this.
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
            node.transform = up_axis::from_to(up, UpAxis::Y) * node.transform;
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
                *value = up_axis::to_y_up(scaled(*value), turn);
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
    scene.metadata.metres_per_unit = Some(1.0);
    scene.metadata.up = Some(UpAxis::Y);
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
        *vertex = up_axis::to_y_up(scaled(*vertex), up);
    }
    for normal in &mut mesh.normals {
        *normal = up_axis::to_y_up(*normal, up);
    }
    for bone in &mut mesh.bones {
        let translation = scaled(bone.offset_matrix.w_axis.truncate());
        bone.offset_matrix *= up_axis::from_to(UpAxis::Y, up);
        bone.offset_matrix.w_axis = translation.extend(1.0);
    }
}

/// Computed in double precision and rounded once.
fn turned_rotation(rotation: Quat) -> Quat {
    (Z_UP_TO_Y_UP * rotation.as_dquat()).as_quat()
}
