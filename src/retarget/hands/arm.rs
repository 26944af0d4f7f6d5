//! An arm whose palm is moved to a goal.

use std::f32::consts::PI;

use glam::{Quat, Vec3};
use mocap_figure::axes::bend_axis;
use mocap_figure::body::Body;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::ik::Goal;
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::pose::Pose;
use mocap_scene::scene::NodeId;

use super::shape::{LEG, larger};

/// The distance from the wrist to the middle of the palm, in metres, for a body whose leg is [`LEG`] long.
const PALM: f32 = 0.05;

/// The largest fraction of its length to which an arm is stretched, unless the motion stretches it more. Near full
/// length, the elbow moves centimetres while the hand moves millimetres.
const STRETCH: f32 = 0.995;

/// How much farther an arm may stretch if it is already stretched beyond [`STRETCH`], as a fraction of its length. With
/// 0, the path of the hand would have a corner at the limit.
const NO_ROOM: f32 = 1e-3;

/// The exponent of the curve that limits the stretch of an arm. A larger exponent makes the limit begin more sharply.
/// With 6, a goal at half of the remaining length is missed by 0.3 % of this half.
const SHARPNESS: i32 = 6;

/// The sideways offset that the hinge gives to the elbow of a straight arm, as a fraction of the upper arm.
const HINGE: f32 = 0.03;

/// The shift of the hand at which the offset by [`HINGE`] has half the weight, as a fraction of the upper arm.
const FAR: f32 = 0.1;

/// The smallest angle between upper arm and forearm, in radians. An elbow bends by 150 degrees (American Academy of
/// Orthopaedic Surgeons, Joint Motion, 1965).
const FOLDED: f32 = PI / 6.0;

/// The fraction of an arm's length beyond which the trunk leans.
const REACH: f32 = 0.97;

/// The width of the smooth start of leaning, as a fraction of the arm's length.
const CORNER: f32 = 0.01;

/// The squared sine of the angle between arm and trunk below which leaning helps little.
const ALONG: f32 = 0.3;

/// The angle that the lean of the trunk never exceeds, in radians: 20 degrees.
const LEAN: f32 = 0.35;

/// The largest angle between forearm and hand, in radians. A wrist bends by 80 degrees (same source as for the elbow).
const WRIST: f32 = 1.4;

/// The goal of a wrist, in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WristGoal {
    position: Vec3,
    rotation: Quat,
}

/// An arm of a body, or a leg.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arm {
    pub(super) side: Side,
    pub(crate) is_arm: bool,
    /// Upper arm, forearm and hand.
    pub(crate) joints: [NodeId; 3],
    /// The axis about which the elbow bends, in the axes of the upper arm's joint.
    hinge: Vec3,
    /// The vector from the wrist to the palm, in the axes of the hand's joint.
    palm: Vec3,
}

impl Arm {
    pub(crate) fn new(body: &Body, side: Side) -> Option<Self> {
        let outwards = match side {
            Side::Left => Vec3::X,
            Side::Right => Vec3::NEG_X,
        };
        Self::of_bones(
            body,
            side,
            [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
            outwards,
        )
    }

    /// A leg, treated as an arm whose palm is the sole.
    pub(crate) fn leg(body: &Body, side: Side) -> Option<Self> {
        Self::of_bones(
            body,
            side,
            [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot],
            Vec3::NEG_Y,
        )
    }

    fn of_bones(body: &Body, side: Side, bones: [Bone; 3], outwards: Vec3) -> Option<Self> {
        let bones = bones.map(|bone| bone.on(side));
        let joints = [body.joint(bones[0])?, body.joint(bones[1])?, body.joint(bones[2])?];
        let in_joint = |bone: usize| body.frame_to_joint(bones[bone], joints[bone]).inverse();
        Some(Self {
            side,
            is_arm: bones[2].on(Side::Left) == Bone::LeftHand,
            joints,
            hinge: in_joint(0) * bend_axis(bones[0])?,
            palm: in_joint(2) * outwards * (PALM * body.leg / LEG),
        })
    }

    /// The vector from the wrist to the palm, in the world.
    pub(super) fn wrist_to_palm(&self, pose: &Pose) -> Vec3 {
        rotation_of(&pose.node_to_world[self.joints[2].index()]) * self.palm
    }

    /// The middle of the palm in the world.
    pub(super) fn palm(&self, pose: &Pose) -> Vec3 {
        pose.position(self.joints[2]) + self.wrist_to_palm(pose)
    }

    /// The goal of a wrist that is shifted. The hand keeps its rotation in the world.
    pub(crate) fn goal(&self, pose: &Pose, shift: Vec3) -> WristGoal {
        WristGoal {
            position: pose.position(self.joints[2]) + shift,
            rotation: rotation_of(&pose.node_to_world[self.joints[2].index()]),
        }
    }

    /// The rotation of the trunk about `pivot`, as a vector. It brings the shoulder so near to a goal that the arm
    /// reaches the goal.
    pub(super) fn lean(&self, pose: &Pose, pivot: Vec3, goal: WristGoal) -> Vec3 {
        let [start, middle, end] = self.joints.map(|joint| pose.position(joint));
        let length = start.distance(middle) + middle.distance(end);
        let reach = (REACH * length).max(start.distance(end));
        let missing = larger([start.distance(goal.position) - reach, 0.0], CORNER * length);
        let (arm, trunk) = ((goal.position - start).normalize_or_zero(), start - pivot);
        let across = trunk.cross(arm);
        // Leaning does not bring the shoulder nearer along the line of the trunk.
        let squared =
            across.length_squared().max(ALONG * trunk.length_squared()) / trunk.length_squared().max(f32::MIN_POSITIVE);
        let lean = across * missing / (trunk.length_squared() * squared).max(f32::MIN_POSITIVE);
        lean / (1.0 + lean.length_squared() / (LEAN * LEAN)).sqrt()
    }

    /// Moves the hand to the goal, as far as the arm reaches. The hand keeps its rotation in the world, unless the
    /// wrist would bend too far. The plane of the arm rotates by the shortest rotation. A straight arm bends about its
    /// hinge.
    pub(crate) fn bring(&self, pose: &mut Pose, goal: WristGoal) {
        let [start, middle, end] = self.joints.map(|joint| pose.position(joint));
        let shift = goal.position - end;
        let (_, bend_before) = self.wrist(pose);
        let (upper, lower) = (start.distance(middle), middle.distance(end));
        let (line, to_goal) = (end - start, end + shift - start);
        let free = line.length();
        let folded = (upper * upper + lower * lower - 2.0 * upper * lower * FOLDED.cos()).sqrt();
        let room = (STRETCH * (upper + lower) - free).max(NO_ROOM * (upper + lower));
        // Beyond its free length, the arm stretches less and less, without a corner.
        let distance = match (to_goal.length() - free) / room {
            more if more > 0.0 => free + room * more / (1.0 + more.powi(SHARPNESS)).powf(1.0 / SHARPNESS as f32),
            less => (free + room * less).max(folded.min(free)),
        };
        let along = to_goal.normalize_or(line);
        let hinge = rotation_of(&pose.node_to_world[self.joints[0].index()]) * self.hinge;
        let by_hinge = line.cross(hinge).normalize_or_zero() * (HINGE * upper);
        let counts = shift.length_squared() / (shift.length_squared() + (FAR * upper).powi(2));
        let pole = start + arc(line, along) * (middle - start + by_hinge * counts);
        let goal = Goal::at(start + along * distance).with_rotation(goal.rotation);
        pose.bend_limb(self.joints, &goal, Some(pole));
        let (forearm, bend) = self.wrist(pose);
        let most = WRIST.max(bend_before);
        if bend > most {
            let back = arc(self.wrist_to_palm(pose), forearm);
            pose.rotate(self.joints[2], Quat::IDENTITY.slerp(back, 1.0 - most / bend));
        }
    }

    /// The direction of the forearm, and the angle between it and the hand.
    fn wrist(&self, pose: &Pose) -> (Vec3, f32) {
        let forearm = pose.position(self.joints[2]) - pose.position(self.joints[1]);
        (forearm, forearm.angle_between(self.wrist_to_palm(pose)))
    }
}
