//! Locks a foot in place during ground contact.

use glam::Vec3;

use mocap_scene::ik::Goal;
use mocap_scene::math::inertia::fade;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::NodeId;

/// Frames over which a released foot returns to its position in the motion.
const RELEASE: usize = 12;
/// The largest distance of a locked foot from its position in the motion, in metres on a body with legs of the length
/// [`LEG`](super::features::LEG). Beyond this distance the foot is released.
const FARTHEST: f32 = 0.15;

/// The bit of the ankle in the contact bits of one foot, after the bits of the other foot are shifted out.
const ANKLE: u8 = 1;
/// The bit of the ball in the contact bits of one foot.
const BALL: u8 = 4;

/// The lock of one foot. `moved` is the shift of the foot over the ground from its position in the motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FootLock {
    /// The contact bit of the locked point.
    point: Option<u8>,
    /// The position of the locked point.
    held: Vec3,
    moved: Vec3,
    /// The shift at the release of the foot, and the frames since then.
    from: Vec3,
    since: usize,
    /// Whether the foot was released in this contact because it was too far from its position in the motion.
    gave_way: bool,
}

impl FootLock {
    /// Moves the foot of a pose to its locked position. `knee` is the hinge axis of the knee, and `contacts` are the
    /// contact bits of the foot.
    pub(super) fn hold(
        &mut self,
        pose: &mut Pose,
        (limb, knee): ([NodeId; 3], Vec3),
        ball: NodeId,
        contacts: u8,
        scale: f32,
    ) {
        let point = [ANKLE, BALL].into_iter().find(|bit| contacts & bit != 0);
        self.gave_way &= point.is_some();
        let at = pose.position(if point == Some(BALL) { ball } else { limb[2] });
        match point.filter(|_| !self.gave_way) {
            Some(point) => {
                if self.point != Some(point) {
                    // Lock the point at its shown position, which may differ from its position in the motion.
                    (self.point, self.held) = (Some(point), at + self.left());
                }
                self.moved = (self.held - at).with_y(0.0);
                (self.from, self.since) = (self.moved, 0);
                if self.moved.length() > FARTHEST * scale {
                    (self.gave_way, self.point) = (true, None);
                }
            }
            None => {
                self.point = None;
                self.since += 1;
                self.moved = self.left();
            }
        }
        if self.moved.length_squared() > 1e-10 {
            let ankle = pose.position(limb[2]);
            let rotation = Trs::from_matrix(pose.node_to_world[limb[2].index()]).rotation;
            let goal = Goal::at(ankle + self.moved).with_rotation(rotation);
            pose.bend_hinged_limb(limb, &goal, knee);
        }
    }

    /// The part of the shift that remains since the foot was released.
    fn left(&self) -> Vec3 {
        fade(self.from, Vec3::ZERO, self.since, RELEASE)
    }
}
