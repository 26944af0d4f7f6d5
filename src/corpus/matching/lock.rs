//! Holds a foot in contact in its place.

use glam::Vec3;

use mocap_scene::ik::Goal;
use mocap_scene::math::inertia::fade;
use mocap_scene::pose::{Pose, Trs};
use mocap_scene::scene::NodeId;

/// Frames in which a foot that leaves the ground comes to where the motion has it.
const RELEASE: usize = 12;
/// How far a foot is held from where the motion has it, in metres on the body of the features; beyond that it is let
/// go.
const FARTHEST: f32 = 0.15;

/// The bits of the contacts of a foot, after those of the other foot are shifted out.
const ANKLE: u8 = 1;
const BALL: u8 = 4;

/// The lock of one foot: its shift over the ground from its place in the motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FootLock {
    /// The bit of the point that is held.
    point: Option<u8>,
    /// Where that point is held.
    held: Vec3,
    moved: Vec3,
    /// The move when the foot was let go, and the frames since.
    from: Vec3,
    since: usize,
    /// Whether it was let go in this contact because it was too far away.
    gave_way: bool,
}

impl FootLock {
    /// Moves the foot of a pose to where it is held. `knee` is the hinge of the limb, `contacts` are those of the foot.
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
                    // It is held where it is shown, which may not be where the motion has it.
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

    /// The remainder of the shift since the foot was released.
    fn left(&self) -> Vec3 {
        fade(self.from, Vec3::ZERO, self.since, RELEASE)
    }
}
