//! The root motion of a clip on a character: removed, or moved to a node above the hips.
//!
//! [`process`](mocap_scene::process) removes or moves the root motion of skeletons whose joints have no rotations at
//! rest and carry no skin. The joints of a character may have any axes at rest. A character gets a new node only if no
//! node is above the hips.

use std::sync::Arc;

use glam::{Mat4, Quat, Vec3};
use mocap_figure::convert::RootMotion;
use mocap_scene::error::Result;
use mocap_scene::pose::{Binding, Pose, Trs};
use mocap_scene::scene::{Animation, Channel, GROUP_OF_ROOTS, Keys, NodeId, NodeKind, Scene};

use super::Target;

/// The sum of squares below which the twist about the up axis is undefined: the figure is upside down.
const NO_HEADING: f32 = 1e-9;

/// The name that readers of FBX give the topmost node. No clip of an FBX file moves this node.
const ROOT_OF_FBX: &str = "RootNode";

/// The target. If its file has no node above the hips, the target gets a node `Root` above them.
///
/// # Errors
/// If the file cannot be changed.
pub(super) fn with_root(target: Target, hips: NodeId) -> Result<Target> {
    if uppermost(&target.scene(), hips).is_some() {
        return Ok(target);
    }
    Ok(match target {
        Target::Character(character) => character.with_root_above(hips)?.into(),
        Target::Skeleton(mut scene) => {
            Arc::make_mut(&mut scene).insert_root_above(hips);
            Target::Skeleton(scene)
        }
        Target::Robot(_) => target,
    })
}

/// For [`RootMotion::InPlace`], keeps the hips above the point on the ground where they start. For
/// [`RootMotion::Extract`], moves their horizontal translation and their heading to the topmost node above them; the
/// world position of each joint stays.
pub(super) fn change(scene: &Scene, hips: NodeId, animation: &mut Animation, root: RootMotion) {
    let above = match root {
        RootMotion::Keep => return,
        RootMotion::InPlace => None,
        RootMotion::Extract => uppermost(scene, hips),
    };
    let rest = Pose::rest(scene);
    let parent = scene.nodes[hips.index()].parent;
    let of_parent = |pose: &Pose, node: Option<NodeId>| match node {
        Some(parent) => pose.node_to_world[parent.index()],
        None => Mat4::IDENTITY,
    };
    let ground = |matrix: &Mat4| Vec3::new(matrix.w_axis.x, 0.0, matrix.w_axis.z);
    let hips_at_rest = rest.node_to_world[hips.index()];
    let from_rest = rotation(&hips_at_rest).inverse();
    let binding = Binding::new(scene, animation);
    let mut pose = rest.clone();
    let mut start = None;
    let mut heading = Quat::IDENTITY;
    let (mut of_hips, mut of_root) = (Vec::new(), Vec::new());
    for frame in 0..animation.frame_count() {
        pose.sample(&binding, animation, frame as f64);
        let now = pose.node_to_world[hips.index()];
        let start = *start.get_or_insert(ground(&now));
        let moved = match above {
            None => Mat4::from_translation(ground(&now) - start),
            Some(_) => {
                let twist = rotation(&now) * from_rest;
                if twist.y * twist.y + twist.w * twist.w > NO_HEADING {
                    heading = Quat::from_xyzw(0.0, twist.y, 0.0, twist.w).normalize();
                }
                Mat4::from_rotation_translation(heading, ground(&now)) * Mat4::from_translation(-ground(&hips_at_rest))
            }
        };
        of_hips.push(Trs::from_matrix((moved * of_parent(&pose, parent)).inverse() * now));
        if let Some(above) = above {
            let top = of_parent(&rest, scene.nodes[above.index()].parent);
            of_root.push(Trs::from_matrix(
                top.inverse() * moved * rest.node_to_world[above.index()],
            ));
        }
    }
    set(scene, animation, hips, &of_hips);
    if let Some(above) = above {
        set(scene, animation, above, &of_root);
    }
}

/// The topmost node above the hips that is in the file and moves the hips.
fn uppermost(scene: &Scene, hips: NodeId) -> Option<NodeId> {
    let parent = |node: &NodeId| scene.nodes[node.index()].parent;
    let is_of_file = |node: &NodeId| {
        let found = &scene.nodes[node.index()];
        let stands_for_all = found.parent.is_none() && found.kind == NodeKind::Group;
        !(stands_for_all && [GROUP_OF_ROOTS, ROOT_OF_FBX].contains(&found.name.as_str()))
    };
    let above = std::iter::successors(parent(&hips), parent);
    above.take_while(is_of_file).last()
}

fn rotation(matrix: &Mat4) -> Quat {
    Trs::from_matrix(*matrix).rotation
}

/// Sets a key at every tick of a node.
fn set(scene: &Scene, animation: &mut Animation, node: NodeId, keys: &[Trs]) {
    let name = &scene.nodes[node.index()].name;
    let known = animation.channels.iter().position(|channel| match channel.node {
        Some(own) => own == node,
        None => channel.node_name == *name,
    });
    let channel = match known {
        Some(index) => &mut animation.channels[index],
        None => {
            let index = animation.channels.partition_point(|channel| channel.node < Some(node));
            let scale = Trs::from_matrix(scene.nodes[node.index()].transform).scale;
            let channel = Channel {
                node_name: name.clone(),
                node: Some(node),
                position_keys: Keys::constant(Vec3::ZERO),
                rotation_keys: Keys::constant(Quat::IDENTITY),
                scaling_keys: Keys::constant(scale),
            };
            animation.channels.insert(index, channel);
            &mut animation.channels[index]
        }
    };
    let ticks = || (0..keys.len()).map(|tick| tick as f64).collect();
    channel.position_keys = Keys::at_ticks(keys.iter().map(|key| key.translation).collect(), ticks());
    let mut before = Quat::IDENTITY;
    let rotations = keys.iter().map(|key| {
        before = if key.rotation.dot(before) < 0.0 {
            -key.rotation
        } else {
            key.rotation
        };
        before
    });
    channel.rotation_keys = Keys::at_ticks(rotations.collect(), ticks());
}
