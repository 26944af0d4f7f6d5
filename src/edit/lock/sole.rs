//! Keeps the sole of a foot above the floor.

use std::f32::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, Quat, Vec3};
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::{NodeId, NodeKind, Scene};

use super::shift::envelope;

/// A point of a foot that stays above the floor.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct SolePoint {
    /// The node at this point. `None` for a point of the skin on the sole.
    #[doc(hidden)]
    pub node: Option<NodeId>,
    /// The nodes that move the point. Each has its weight, and the position of the point in the node's coordinate
    /// frame.
    #[doc(hidden)]
    pub parts: Vec<(NodeId, f32, Vec3)>,
    /// The height of the point above the floor when the figure stands.
    #[doc(hidden)]
    pub height: f32,
    /// The joint that rotates to raise the point. Without a joint, the whole foot is lifted.
    #[doc(hidden)]
    pub pivot: Option<NodeId>,
    /// The axis across the foot about which `pivot` raises the toes, in the coordinate frame of this joint, if the axis
    /// is known. An axis that is computed in each frame flips if the toes point straight down.
    #[doc(hidden)]
    pub axis: Option<Vec3>,
    /// The largest angle by which the joint rotates for this point, in radians.
    #[doc(hidden)]
    pub most: f32,
}

impl SolePoint {
    /// A node of the foot, which the joint above it raises.
    #[doc(hidden)]
    pub fn at(scene: &Scene, node: NodeId, height: f32) -> Self {
        Self {
            node: Some(node),
            parts: Vec::new(),
            height,
            pivot: scene.nodes[node.index()].parent,
            axis: None,
            most: std::f32::consts::PI,
        }
    }

    pub(super) fn position(&self, pose: &Pose) -> Vec3 {
        if let Some(node) = self.node {
            return pose.position(node);
        }
        let part = |(node, fraction, position): &(NodeId, f32, Vec3)| {
            *fraction * pose.node_to_world[node.index()].transform_point3(*position)
        };
        self.parts.iter().map(part).sum()
    }
}

/// Whether a node of the foot may rotate: it must be a joint with a node below.
pub(super) fn turns(scene: &Scene, node: NodeId) -> bool {
    let next = scene.nodes.get(node.index() + 1);
    next.is_some_and(|next| next.parent == Some(node)) && scene.nodes[node.index()].kind == NodeKind::Joint
}

/// Rotates the joints of a foot up until none of the points is below the floor. Without this, a foot that rolls without
/// bending its toes would put its toe tips below the floor.
pub(super) fn turn_up(pose: &mut Pose, points: &[SolePoint], up: Vec3, floor: f32) {
    for point in points {
        let Some(pivot) = point.pivot else { continue };
        let here = pose.position(pivot);
        let offset = point.position(pose) - here;
        let wanted = floor + point.height - here.dot(up);
        if offset.dot(up) >= wanted || wanted >= offset.length() {
            continue;
        }
        match point.axis {
            Some(axis) => {
                let axis = world_axis(pose, pivot, axis);
                let [angle, steepness] = angle_to_height(axis, offset, up, wanted);
                let angle = angle.clamp(0.0, point.most * (1.0 - steepness));
                pose.rotate(pivot, Quat::from_axis_angle(axis, angle));
            }
            None => turn_to_height(pose, pivot, offset, up, wanted, point.most),
        }
    }
}

/// Transforms an axis from a joint's own space to the world.
pub(super) fn world_axis(pose: &Pose, joint: NodeId, axis: Vec3) -> Vec3 {
    Trs::from_matrix(pose.node_to_world[joint.index()]).rotation * axis
}

/// The sine of the smallest angle below the horizontal at which a foot counts as steep: about 60 degrees.
const STEEP: f32 = 0.87;

/// The angle about `axis` that brings the end of `offset` to a height. `axis` lies across a flat foot, and the angle
/// grows as the toes rise. Also returns the steepness of the foot. The steepness is 1 if the toes point straight down
/// or farther back, so that a rotation no longer raises them.
pub(super) fn angle_to_height(axis: Vec3, offset: Vec3, up: Vec3, height: f32) -> [f32; 2] {
    let along = offset.project_onto_normalized(axis);
    let across = offset - along;
    let [cosine, sine] = [across.dot(up), axis.cross(across).dot(up)];
    let largest = cosine.hypot(sine);
    if largest <= f32::EPSILON * offset.length() {
        return [0.0, 1.0];
    }
    // The angle at which `offset` points straight up: a quarter turn from toes that point forward.
    let top = sine.atan2(cosine);
    let top = if top < -FRAC_PI_2 { top + TAU } else { top };
    let wanted = ((height - along.dot(up)) / largest).clamp(-1.0, 1.0);
    let steepness = match sine > 0.0 {
        true => ((-cosine / largest - STEEP) / (1.0 - STEEP)).clamp(0.0, 1.0),
        false => 1.0,
    };
    [top - wanted.acos(), steepness * steepness * (3.0 - 2.0 * steepness)]
}

/// Rotates a joint so that the end of `offset`, which begins at the joint, comes to a height above the joint. The
/// rotation is at most `largest` radians.
pub(super) fn turn_to_height(pose: &mut Pose, joint: NodeId, offset: Vec3, up: Vec3, height: f32, largest: f32) {
    let length = offset.length();
    let angle = |height: f32| f64::from(height / length).clamp(-1.0, 1.0).asin();
    if let Some(axis) = offset.cross(up).as_dvec3().try_normalize() {
        let largest = f64::from(largest);
        let rotation = (angle(height) - angle(offset.dot(up))).clamp(-largest, largest);
        pose.rotate(joint, DQuat::from_axis_angle(axis, rotation).as_quat());
    }
}

/// The largest angle by which a point is raised smoothly, in radians.
const LARGEST_RAISE: f32 = 2.5;

/// The rotation of a joint of the foot that raises a point. Its axis lies across the foot, so that toes which point
/// straight down move forward.
pub(super) struct Hinge {
    node: NodeId,
    pivot: NodeId,
    ankle: NodeId,
    /// For each frame: the direction up and the offset from the pivot to the point, both in the space of the pivot, and
    /// the height of the pivot.
    seen: Vec<(Vec3, Vec3, f32)>,
    /// The axis in the space of the pivot, summed over all frames.
    axis: Vec3,
    /// The angle of the rotation in each frame.
    angles: Vec<f32>,
}

impl Hinge {
    pub(super) fn new(ankle: NodeId, point: &SolePoint) -> Option<Self> {
        Some(Self {
            node: point.node?,
            pivot: point.pivot?,
            ankle,
            seen: Vec::new(),
            axis: Vec3::ZERO,
            angles: Vec::new(),
        })
    }

    pub(super) fn see(&mut self, pose: &Pose, up: Vec3) {
        let rotation = Trs::from_matrix(pose.node_to_world[self.pivot.index()]).rotation;
        let (here, point) = (pose.position(self.pivot), pose.position(self.node));
        // The axis is more certain if the foot is flatter. Its projection on the ground is then longer, so it gets a
        // larger weight.
        let to_pivot = rotation.inverse();
        self.axis += to_pivot * (point - pose.position(self.ankle)).cross(up);
        self.seen.push((to_pivot * up, to_pivot * (point - here), here.dot(up)));
    }

    /// Computes smooth angles that keep the point above `floor`, a height for each frame.
    pub(super) fn land_softly(&mut self, floor: impl Fn(usize) -> f32, radius: usize) {
        let Some(axis) = self.axis.try_normalize() else { return };
        let needed = |(frame, (up, offset, height)): (usize, &(Vec3, Vec3, f32))| {
            let along = offset.project_onto_normalized(axis);
            let across = offset - along;
            let wanted = floor(frame) - (height + along.dot(*up));
            least_angle([across.dot(*up), axis.cross(across).dot(*up)], wanted)
        };
        let needed: Vec<f32> = self.seen.iter().enumerate().map(needed).collect();
        self.angles = envelope(&needed, radius);
    }

    pub(super) fn turns(&self, frame: usize) -> bool {
        self.angles.get(frame).is_some_and(|angle| *angle > 0.0)
    }

    pub(super) fn turn(&self, frame: usize, pose: &mut Pose) {
        if let Some(axis) = self.axis.try_normalize().filter(|_| self.turns(frame)) {
            let rotation = Trs::from_matrix(pose.node_to_world[self.pivot.index()]).rotation;
            pose.rotate(self.pivot, Quat::from_axis_angle(rotation * axis, self.angles[frame]));
        }
    }
}

/// The smallest angle, at least 0, at which a cos + b sin is `wanted`. If no angle gives `wanted`, the angle at which
/// the sum is largest.
fn least_angle([a, b]: [f32; 2], wanted: f32) -> f32 {
    let largest = a.hypot(b);
    if a >= wanted || largest <= f32::EPSILON {
        return 0.0;
    }
    let top = b.atan2(a).rem_euclid(std::f32::consts::TAU);
    let angle = (top - (wanted / largest).min(1.0).acos()).rem_euclid(std::f32::consts::TAU);
    if angle < LARGEST_RAISE { angle } else { 0.0 }
}
