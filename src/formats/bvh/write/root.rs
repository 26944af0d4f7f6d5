//! Where the hierarchy begins.

use glam::{Mat4, Vec3};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Channel, GROUP_OF_ROOTS, NodeId, NodeKind, Scene};

/// How far the scale of an axis may be from another for an even scale, as a fraction.
const EVEN: f32 = 1e-5;

/// The first node that is written. Groups above it that do not move, and below which all joints are below one child,
/// are left out: the skeleton begins with its root. So is the group that a reader puts over several roots.
pub(super) fn first_written(scene: &Scene, channels: &[Option<&Channel>]) -> usize {
    let nodes = &scene.nodes;
    // What is shown and does not move needs no joint.
    let mut is_needed: Vec<bool> = std::iter::zip(nodes, channels)
        .map(|(node, channel)| node.kind != NodeKind::Group || channel.is_some())
        .collect();
    for (index, node) in nodes.iter().enumerate().rev() {
        if let Some(parent) = node.parent {
            is_needed[parent.index()] |= is_needed[index];
        }
    }
    let children = |index: usize| {
        let parent = Some(NodeId::new(index));
        let children = nodes.iter().enumerate().filter(move |(_, node)| node.parent == parent);
        children.map(|(child, _)| child)
    };
    let is_still = |index: usize| nodes[index].kind == NodeKind::Group && channels[index].is_none();
    let is_even = |scale: Vec3| scale.x > 0.0 && scale.abs_diff_eq(Vec3::splat(scale.x), EVEN * scale.x);
    let mut first = 0;
    while first < nodes.len() && is_still(first) && is_even(Trs::from_matrix(nodes[first].transform).scale) {
        let needed: Vec<usize> = children(first).filter(|child| is_needed[*child]).collect();
        let only = match needed[..] {
            [only] => only,
            // Without any joint the groups are all there is.
            [] => match children(first).collect::<Vec<_>>()[..] {
                [only] if nodes[first].transform == Mat4::IDENTITY => only,
                _ => break,
            },
            _ => break,
        };
        first = only;
    }
    let holds_roots = |index: usize| {
        nodes[index].name == GROUP_OF_ROOTS
            && children(index).count() > 1
            && children(index).all(|child| nodes[child].kind != NodeKind::EndSite)
    };
    let is_plain = |index: usize| is_still(index) && nodes[index].transform == Mat4::IDENTITY;
    match first < nodes.len() && is_plain(first) && holds_roots(first) {
        true => first + 1,
        false => first,
    }
}

/// A transform below another, which is scaled evenly.
pub(super) fn placed(above: &Trs, below: &Trs) -> Trs {
    // Bit by bit, also the signs of zeros.
    if *above == Trs::IDENTITY {
        return *below;
    }
    Trs {
        translation: above.translation + above.rotation * (above.scale * below.translation),
        rotation: above.rotation * below.rotation,
        scale: above.scale * below.scale,
    }
}
