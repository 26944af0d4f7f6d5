//! Bends a leg of an animal, so that its paw comes to a goal.

use glam::{Quat, Vec3};
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::pose::Pose;
use mocap_scene::scene::NodeId;

use crate::report::QuadrupedLeg;

/// A leg is stretched at most to this fraction of the length of the straight leg. Near a straight leg, the knee would
/// jump.
const REACH: f32 = 0.99;

/// The smallest sine of a bend whose plane is known.
const BENT: f32 = 0.02;

/// The joints of a leg that bend: the hip, the knee and the end of the lower leg.
#[derive(Clone, Debug)]
pub struct LegGoal {
    upper: NodeId,
    lower: NodeId,
    end: NodeId,
    paw: NodeId,
    /// The axis about which the knee bends if the leg is straight, in the coordinate frame of the knee.
    hinge: Vec3,
}

impl LegGoal {
    /// `ankle` is the joint of the ankle, if the ankle moves relative to the lower leg.
    pub fn new(standing: &Pose, leg: &QuadrupedLeg, ankle: Option<NodeId>, left: Vec3) -> Self {
        let end = ankle.unwrap_or(leg.paw);
        let knee = rotation_of(&standing.node_to_world[leg.lower.index()]);
        // A straight stifle bends forward, and a straight elbow bends backward.
        let side = if leg.is_fore { left } else { -left };
        let bend = axis(standing, [leg.upper, leg.lower, end]).unwrap_or(side);
        Self {
            upper: leg.upper,
            lower: leg.lower,
            end,
            paw: leg.paw,
            hinge: knee.inverse() * bend,
        }
    }

    /// The joints whose rotation [`Self::reach`] changes.
    pub fn nodes(&self) -> [NodeId; 3] {
        [self.upper, self.lower, self.end]
    }

    /// Moves the paw to `goal`, or as near as the leg reaches. The paw and its ankle keep their rotation.
    pub fn reach(&self, pose: &mut Pose, goal: Vec3) {
        let kept = rotation_of(&pose.node_to_world[self.end.index()]);
        let goal = goal - (pose.position(self.paw) - pose.position(self.end));
        let joints = [self.upper, self.lower, self.end];
        let [hip, knee, end] = joints.map(|node| pose.position(node));
        if !goal.is_finite() || goal == end {
            return;
        }
        let (thigh, shin) = (hip.distance(knee), knee.distance(end));
        let now = hip.distance(end);
        let most = (REACH * (thigh + shin)).max(now);
        let wanted = (goal - hip).length().clamp((thigh - shin).abs() / REACH, most);
        let angle = |distance: f32| {
            let cosine = (thigh * thigh + shin * shin - distance * distance) / (2.0 * thigh * shin);
            cosine.clamp(-1.0, 1.0).acos()
        };
        let axis =
            axis(pose, joints).unwrap_or_else(|| rotation_of(&pose.node_to_world[self.lower.index()]) * self.hinge);
        let bend = angle(wanted) - angle(now);
        if bend.is_finite() {
            pose.rotate(self.lower, Quat::from_axis_angle(axis, bend));
        }
        let end = pose.position(self.end);
        pose.rotate(self.upper, arc(end - hip, goal - hip));
        let turned = rotation_of(&pose.node_to_world[self.end.index()]);
        pose.rotate(self.end, (kept * turned.inverse()).normalize());
    }
}

/// The axis about which a positive rotation of the lower leg opens the knee; `None` if the leg is straight.
fn axis(pose: &Pose, joints: [NodeId; 3]) -> Option<Vec3> {
    let [hip, knee, end] = joints.map(|node| pose.position(node));
    let (thigh, shin) = ((hip - knee).normalize_or_zero(), (end - knee).normalize_or_zero());
    let across = thigh.cross(shin);
    (across.length() > BENT).then(|| across.normalize())
}
