//! Makes the bind pose of skins the rest pose of an animated skeleton.
//!
//! A node's own transform is what a file shows without animation. In a file with motion, this transform is often a pose
//! of the motion: writers drop constant tracks, and put their values into the nodes. The skeleton's bind pose is in the
//! inverse bind matrices instead: `bind = inverse(matrix)`, up to one transform that all joints of a skin share. A
//! joint whose bind pose differs from its node gets the transform of the bind pose, and its node's values as a constant
//! track. So no pose of the motion changes.

use std::collections::HashMap;

use glam::{Mat4, Vec3};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Channel, Keys, NodeId, Scene};

use super::file::{File, NodePlace, Transform};
use super::json::Skin;

/// The smallest rotation between a node and its bind pose that counts as a difference, in radians. Compressed matrices
/// are rounded.
const ROTATED: f32 = 0.005;

/// The smallest distance between a node and its bind pose that counts as a difference, as a fraction of the node's
/// distance from its parent: the rounding of matrices.
const MOVED: f32 = 0.005;

/// The smallest distance between a node and its bind pose that counts as a difference, in metres. A smaller difference
/// is not visible.
const FAR: f32 = 1e-4;

/// The largest relative difference between the scales of a node and its bind pose. A file whose joints are bound at
/// another size is not supported.
const SCALED: f32 = 0.01;

/// Sets the rest pose of an animated scene's joints to their bind pose.
pub(super) fn to_rest(file: &File<'_>, placed: &HashMap<usize, NodePlace>, scene: &mut Scene) {
    // The T-pose of a VRM file is in its nodes.
    if scene.animations.is_empty() || scene.nodes.iter().any(|node| node.humanoid_bone.is_some()) {
        return;
    }
    let index_of: HashMap<NodeId, usize> = placed.iter().map(|(index, node)| (node.id, *index)).collect();
    let mut is_done = vec![false; scene.nodes.len()];
    for skin in &file.root.skins {
        let Some(bound) = bound(file, skin) else { continue };
        for &joint in &skin.joints {
            let Some(NodePlace { id, transform }) = placed.get(&joint) else {
                continue;
            };
            if std::mem::replace(&mut is_done[id.index()], true) {
                continue;
            }
            let bind = local(scene, placed, &index_of, &bound, *id, file.provenance().is_some());
            if let Some(bind) = bind.filter(|bind| differs(bind, transform)) {
                hold(scene, *id, transform);
                scene.nodes[id.index()].transform =
                    Mat4::from_scale_rotation_translation(transform.scale, bind.rotation, bind.translation);
            }
        }
    }
}

/// The bind transforms of a skin's joints; `None` if they are absent or invalid.
fn bound(file: &File<'_>, skin: &Skin) -> Option<HashMap<usize, Mat4>> {
    let numbers = file.matrices(skin.inverse_bind_matrices?)?;
    let matrices = numbers.chunks_exact(16).map(|numbers| {
        let mut matrix = Mat4::from_cols_slice(numbers);
        for (column, last) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
            matrix.col_mut(column).w = last;
        }
        matrix.inverse()
    });
    let bound: HashMap<usize, Mat4> = skin.joints.iter().copied().zip(matrices).collect();
    let is_sound = bound.len() == skin.joints.len() && bound.values().all(Mat4::is_finite);
    is_sound.then_some(bound)
}

/// A joint's bind transform relative to its parent. Nodes that are not joints keep their transforms. `is_in_world`
/// means that the common transform is the identity.
fn local(
    scene: &Scene,
    placed: &HashMap<usize, NodePlace>,
    index_of: &HashMap<NodeId, usize>,
    bound: &HashMap<usize, Mat4>,
    joint: NodeId,
    is_in_world: bool,
) -> Option<Trs> {
    let mut between = Mat4::IDENTITY;
    let mut above = scene.nodes[joint.index()].parent;
    let of = |node: NodeId| bound.get(index_of.get(&node)?);
    let parent = loop {
        match above {
            None if is_in_world => break Mat4::IDENTITY,
            None => return None,
            Some(node) => {
                if let Some(bound) = of(node) {
                    break *bound;
                }
                let own = index_of.get(&node).and_then(|index| placed.get(index));
                between = own.map_or(Mat4::IDENTITY, |own| own.transform.matrix) * between;
                above = scene.nodes[node.index()].parent;
            }
        }
    };
    let matrix = (parent * between).inverse() * *of(joint)?;
    let trs = Trs::from_matrix(matrix);
    let rebuilt = Mat4::from_scale_rotation_translation(trs.scale, trs.rotation, trs.translation);
    let is_rigid = matrix.is_finite() && rebuilt.abs_diff_eq(matrix, 1e-3 * (1.0 + trs.translation.length()));
    (is_rigid && trs.rotation.is_normalized()).then_some(trs)
}

/// Whether a joint's bind pose differs from its node, at the same scale.
fn differs(bind: &Trs, node: &Transform) -> bool {
    let is_scaled = (bind.scale / node.scale - Vec3::ONE).abs().max_element() > SCALED;
    let turned = bind.rotation.angle_between(node.rotation) > ROTATED;
    let moved = bind.translation.distance(node.translation) > f32::max(MOVED * node.translation.length(), FAR);
    !is_scaled && (turned || moved)
}

/// Keeps the values of a node in every animation that does not move it.
fn hold(scene: &mut Scene, node: NodeId, transform: &Transform) {
    let name = scene.nodes[node.index()].name.clone();
    for animation in &mut scene.animations {
        let channels = &mut animation.channels;
        let index_in_list = channels.partition_point(|channel| channel.node < Some(node));
        if channels
            .get(index_in_list)
            .is_some_and(|channel| channel.node == Some(node))
        {
            continue;
        }
        let channel = Channel {
            node_name: name.clone(),
            node: Some(node),
            position_keys: Keys::constant(transform.translation),
            rotation_keys: Keys::constant(transform.rotation),
            scaling_keys: Keys::constant(transform.scale),
        };
        channels.insert(index_in_list, channel);
    }
}
