//! The bind pose of skins as the rest pose of a skeleton that moves.
//!
//! A node's own transform is what a file shows where nothing moves it. In a file with motion it is often a frame of
//! that motion: writers leave out tracks that stay constant, and put their values into the nodes. The bind pose of the
//! mesh belongs to the skeleton, and is in the inverse bind matrices. It is `bind = inverse(matrix)`, up to one
//! transform that all joints of a skin have in common. A joint that is bound otherwise than its node stands gets the
//! transform of the bind pose, and its node's values as a constant track. So no pose of the motion changes.

use std::collections::HashMap;

use glam::{Mat4, Vec3};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Channel, Keys, NodeId, Scene};

use super::file::{File, NodePlace, Transform};
use super::json::Skin;

/// The smallest rotation between a node and its bind pose that counts, in radians. Compressed matrices are rounded.
const ROTATED: f32 = 0.005;

/// The smallest distance between them, as a fraction of the node's own distance from its parent: rounding of matrices.
const MOVED: f32 = 0.005;

/// The smallest distance between them in metres: it is not seen.
const FAR: f32 = 1e-4;

/// The largest difference of a scale between them: a file whose joints are bound in another size is not understood.
const SCALED: f32 = 0.01;

/// Gives the joints of a scene with motion the transforms of their bind pose.
pub(super) fn to_rest(file: &File<'_>, placed: &HashMap<usize, NodePlace>, scene: &mut Scene) {
    // The T-pose of a VRM file is that of its nodes.
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

/// The joints of a skin where they are bound; `None` where it does not say so, or not soundly.
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

/// A joint in its parent in the bind pose. Nodes that are no joints stand as they do. `is_in_world` says that the
/// common transform is the identity.
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

/// Whether a joint is bound elsewhere than its node stands, and in the same size.
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
