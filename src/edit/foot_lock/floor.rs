//! Keeps the tips of a foot above the floor.

use glam::{DQuat, Vec3};

use crate::pose::Pose;
use crate::scene::{NodeId, NodeKind, Scene};

/// Whether a node of the foot may be turned: a joint with something below it.
pub(super) fn turns(scene: &Scene, node: NodeId) -> bool {
    let next = scene.nodes.get(node.index() + 1);
    next.is_some_and(|next| next.parent == Some(node)) && scene.nodes[node.index()].kind == NodeKind::Joint
}

/// Turns the joints of `foot`, the ankle first, up so far that nothing on them is below the floor. A rolling foot whose
/// toes do not bend puts their tips there.
pub(super) fn lift_below(scene: &Scene, pose: &mut Pose, foot: &[NodeId], up: Vec3, floor: f32) {
    for &node in foot.iter().skip(1) {
        let Some(parent) = scene.nodes[node.index()].parent else {
            continue;
        };
        let here = pose.position(parent);
        let way = pose.position(node) - here;
        let (height, length) = (way.dot(up), way.length());
        let wanted = floor - here.dot(up);
        if height >= wanted || wanted >= length {
            continue;
        }
        let angle = |height: f32| f64::from(height / length).clamp(-1.0, 1.0).asin();
        if let Some(axis) = way.cross(up).as_dvec3().try_normalize() {
            let rotation = DQuat::from_axis_angle(axis, angle(wanted) - angle(height));
            pose.rotate(parent, rotation.as_quat());
        }
    }
}
