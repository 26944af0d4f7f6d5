//! The sole of a foot, and how it is kept above the floor.

use glam::{DQuat, Vec3};

use crate::pose::Pose;
use crate::scene::{NodeId, NodeKind, Scene};

/// A point of a foot that stays above the floor.
#[derive(Clone, Debug)]
pub(crate) struct SolePoint {
    /// The node whose place it is; `None` for one on the sole.
    pub(crate) node: Option<NodeId>,
    /// The nodes with which it moves: the share of each, and where the point is in its space.
    pub(crate) parts: Vec<(NodeId, f32, Vec3)>,
    /// How high it is above the floor where the figure stands.
    pub(crate) height: f32,
    /// The joint that turns to bring it up. Without one the whole foot is lifted.
    pub(crate) pivot: Option<NodeId>,
    /// The largest angle by which it turns for this point, in radians.
    pub(crate) most: f32,
}

impl SolePoint {
    /// A node of the foot, which the joint above it turns.
    pub(crate) fn at(scene: &Scene, node: NodeId, height: f32) -> Self {
        Self {
            node: Some(node),
            parts: Vec::new(),
            height,
            pivot: scene.nodes[node.index()].parent,
            most: std::f32::consts::PI,
        }
    }

    pub(super) fn place(&self, pose: &Pose) -> Vec3 {
        if let Some(node) = self.node {
            return pose.position(node);
        }
        let part = |(node, share, place): &(NodeId, f32, Vec3)| {
            *share * pose.node_to_world[node.index()].transform_point3(*place)
        };
        self.parts.iter().map(part).sum()
    }
}

/// Whether a node of the foot may be turned: a joint with something below it.
pub(super) fn turns(scene: &Scene, node: NodeId) -> bool {
    let next = scene.nodes.get(node.index() + 1);
    next.is_some_and(|next| next.parent == Some(node)) && scene.nodes[node.index()].kind == NodeKind::Joint
}

/// Turns the joints of a foot up so far that none of the points is below the floor. A rolling foot whose toes do not bend
/// puts their tips there.
pub(super) fn turn_up(pose: &mut Pose, points: &[SolePoint], up: Vec3, floor: f32) {
    for point in points {
        let Some(pivot) = point.pivot else { continue };
        let here = pose.position(pivot);
        let way = point.place(pose) - here;
        let wanted = floor + point.height - here.dot(up);
        if way.dot(up) < wanted && wanted < way.length() {
            turn_to_height(pose, pivot, way, up, wanted, point.most);
        }
    }
}

/// Turns a joint so that the end of `way`, which begins at the joint, comes to a height above it, or by the angle `most`.
pub(super) fn turn_to_height(pose: &mut Pose, joint: NodeId, way: Vec3, up: Vec3, height: f32, most: f32) {
    let length = way.length();
    let angle = |height: f32| f64::from(height / length).clamp(-1.0, 1.0).asin();
    if let Some(axis) = way.cross(up).as_dvec3().try_normalize() {
        let most = f64::from(most);
        let turn = (angle(height) - angle(way.dot(up))).clamp(-most, most);
        pose.rotate(joint, DQuat::from_axis_angle(axis, turn).as_quat());
    }
}
