//! Brings an arm or a leg to a goal, frame by frame.

use glam::{Quat, Vec3};
use mocap_figure::axes::{angle_about, bend_axis};
use mocap_figure::body::Body;
use mocap_figure::names::node_named;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::ik::{hinge_rotations, plane_normal, seen_hinge};
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};
use serde::{Deserialize, Serialize};

use super::frames::Frames;
use super::inertia::ease;

/// A limb, which is named by the hand or the foot at its end.
///
/// [`Reach`](crate::Reach) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Limb {
    /// The left arm.
    LeftHand,
    /// The right arm.
    #[default]
    RightHand,
    /// The left leg.
    LeftFoot,
    /// The right leg.
    RightFoot,
}

impl Limb {
    /// The names of all limbs.
    pub(super) const NAMES: &'static [&'static str] = &["left-hand", "right-hand", "left-foot", "right-foot"];

    /// The name of the limb.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::LeftHand => "left-hand",
            Self::RightHand => "right-hand",
            Self::LeftFoot => "left-foot",
            Self::RightFoot => "right-foot",
        }
    }

    fn side(self) -> Side {
        match self {
            Self::LeftHand | Self::LeftFoot => Side::Left,
            Self::RightHand | Self::RightFoot => Side::Right,
        }
    }

    fn is_arm(self) -> bool {
        matches!(self, Self::LeftHand | Self::RightHand)
    }

    /// The upper bone, the lower bone, and the hand or foot, all of the left side. Also the bones of the trunk that may
    /// carry the limb, the nearest first.
    fn bones(self) -> ([Bone; 3], &'static [Bone]) {
        match self.is_arm() {
            true => (
                [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
                &[Bone::UpperChest, Bone::Chest, Bone::Spine, Bone::Hips],
            ),
            false => ([Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot], &[Bone::Hips]),
        }
    }

    /// Two directions of the most natural bend: from the first joint of the limb to its end, and from this line to the
    /// elbow or knee. Both are in the coordinate frame of the T-pose, for the left side. An arm in front of the body
    /// has its elbow below and a little outside. A standing leg has its knee in front.
    fn natural(self) -> [Vec3; 2] {
        match self.is_arm() {
            true => [Vec3::new(0.3, -0.4, 1.0), Vec3::new(0.4, -1.0, 0.0)],
            false => [Vec3::NEG_Y, Vec3::Z],
        }
    }
}

/// Two angles between the old and the new direction of a limb, in radians. Up to the first angle, the plane in which
/// the limb bends turns with the limb, by the shortest rotation. From the second angle on, the limb bends in the plane
/// of [`Limb::natural`], because the shortest rotation is undefined near 180 degrees.
const CARRIED: [f32; 2] = [1.0, 2.0];

/// The displacement of the end of a limb, as a fraction of the limb's length. At or above this displacement, the plane
/// in which the limb bends keeps none of its motion from frame to frame.
const FAR: f32 = 0.3;

/// The length of the hinge axis that the T-pose gives. Each frame of the motion gives an axis whose length is the sine
/// of the bend. The axis of the T-pose is shorter, so that it counts less than the motion.
const HINGE_OF_T_POSE: f32 = 0.05;

/// The joints of a limb, and the axes that determine how it bends.
pub(super) struct LimbChain {
    is_arm: bool,
    pub(super) start: NodeId,
    middle: NodeId,
    end: NodeId,
    /// The node that comes to the goal: the wrist or the ankle, or a node below.
    pub(super) tip: NodeId,
    /// The axis about which the limb bends, in the coordinate frame of its first joint.
    hinge: Vec3,
    /// The joint of the trunk that carries the limb, and the rotation from the coordinate frame of the T-pose to the
    /// coordinate frame of this joint.
    trunk: (NodeId, Quat),
    /// The first direction of [`Limb::natural`], and the normal of the plane of both directions.
    natural: [Vec3; 2],
}

impl LimbChain {
    /// `tip` names the node that comes to the goal; without `tip`, the wrist or the ankle comes to the goal.
    pub(super) fn new(scene: &Scene, body: &Body, limb: Limb, tip: Option<&str>) -> Result<Self> {
        let (bones, trunks) = limb.bones();
        let joint = |bone: Bone| -> Result<NodeId> {
            let bone = bone.on(limb.side());
            let message = || {
                format!(
                    "{} cannot be moved: no joint has the bone {}",
                    limb.as_str(),
                    bone.as_str()
                )
            };
            let missing = || Diagnostic::new(Code::NotHumanoid, message()).into();
            body.joint(bone).ok_or_else(missing)
        };
        let [start, middle, end] = [joint(bones[0])?, joint(bones[1])?, joint(bones[2])?];
        let tip = match tip {
            Some(name) => tip_named(scene, body, name, end)?,
            None => end,
        };
        let trunk = trunks.iter().find_map(|bone| {
            let joint = body.joint(*bone)?;
            body.depends_on(start, joint)
                .then(|| (joint, body.frame_to_joint(*bone, joint)))
        });
        let of_side = |direction: Vec3| match limb.side() {
            Side::Left => direction,
            Side::Right => Vec3::new(-direction.x, direction.y, direction.z),
        };
        let [direction, aside] = limb.natural().map(of_side).map(Vec3::normalize);
        let upper = bones[0].on(limb.side());
        let of_t_pose = body.frame_to_joint(upper, start).inverse() * bend_axis(upper).unwrap_or(Vec3::X);
        Ok(Self {
            is_arm: limb.is_arm(),
            start,
            middle,
            end,
            tip,
            hinge: of_t_pose,
            trunk: trunk.unwrap_or((body.hips, body.frame_to_joint(Bone::Hips, body.hips))),
            natural: [direction, aside.cross(direction).normalize()],
        })
    }

    /// Sets the hinge axis to the mean axis about which the limb bends in `frames`.
    pub(super) fn see_hinge(&mut self, scene: &Scene, frames: &Frames) {
        let mut pose = Pose::rest(scene);
        let mut sum = Vec3::ZERO;
        for frame in 0..frames.len() {
            frames.pose(frame, &mut pose);
            sum += seen_hinge(&pose, self.joints());
        }
        let hinge = sum / frames.len().max(1) as f32 + HINGE_OF_T_POSE * self.hinge;
        self.hinge = hinge.try_normalize().unwrap_or(self.hinge);
    }

    /// The joints that rotate.
    pub(super) fn joints(&self) -> [NodeId; 3] {
        [self.start, self.middle, self.end]
    }

    /// The positions of a limb in a pose, and the goal of its last joint. A hand turns with its forearm, so the lower
    /// bone of an arm ends at the tip. A foot keeps its rotation, so the goal of the ankle is the position at which the
    /// tip is at `goal`.
    fn aim(&self, pose: &Pose, goal: Vec3, natural: NaturalBend) -> Aim {
        let (last, goal) = match self.is_arm {
            true => (self.tip, goal),
            false => (self.end, goal - (pose.position(self.tip) - pose.position(self.end))),
        };
        let joints = [self.start, self.middle, last].map(|node| pose.position(node));
        let hinge = rotation_of(&pose.node_to_world[self.start.index()]) * self.hinge;
        let to_goal = goal - joints[0];
        Aim {
            joints,
            goal,
            along: to_goal.try_normalize(),
            normal: plane_normal(joints, hinge),
            natural: arc(natural.towards, to_goal) * natural.normal,
        }
    }

    /// The vector from the first joint of the limb to the goal.
    pub(super) fn to_goal(&self, pose: &Pose, goal: Vec3) -> Vec3 {
        goal - self.reach(pose).0
    }

    /// The most natural bend if the limb points towards `towards` and the trunk has the rotation `trunk`.
    pub(super) fn natural(&self, trunk: Quat, towards: Vec3) -> NaturalBend {
        NaturalBend {
            towards,
            normal: trunk * (arc(self.natural[0], trunk.inverse() * towards) * self.natural[1]),
        }
    }

    /// The centre and the radius of a ball that contains all points that the tip can reach in a pose.
    pub(super) fn reach(&self, pose: &Pose) -> (Vec3, f32) {
        let last = if self.is_arm { self.tip } else { self.end };
        let joints = [self.start, self.middle, last].map(|node| pose.position(node));
        let carried = pose.position(self.tip) - joints[2];
        let radius = joints[0].distance(joints[1]) + joints[1].distance(joints[2]);
        (joints[0] + carried, radius)
    }

    /// The rotation of the trunk that carries the limb, from the coordinate frame of the T-pose to the world.
    pub(super) fn trunk(&self, pose: &Pose) -> Quat {
        let (joint, frame_to_joint) = self.trunk;
        (rotation_of(&pose.node_to_world[joint.index()]) * frame_to_joint.inverse()).normalize()
    }

    /// The angle from the most natural plane to the plane in which the limb bends, about the line to the goal. For
    /// this, the plane turns with the limb to the direction of the goal, by the shortest rotation.
    pub(super) fn swivel(&self, pose: &Pose, goal: Vec3, natural: NaturalBend) -> Swivel {
        let aim = self.aim(pose, goal, natural);
        let old = aim.joints[2] - aim.joints[0];
        let angle = old.angle_between(aim.goal - aim.joints[0]);
        let length = aim.joints[0].distance(aim.joints[1]) + aim.joints[1].distance(aim.joints[2]);
        let moved = aim.goal.distance(aim.joints[2]) / length;
        let carried = aim
            .along
            .and_then(|along| angle_about(along, aim.natural, arc(old, along) * aim.normal));
        Swivel {
            angle: carried.unwrap_or(0.0),
            known: match carried {
                Some(_) => 1.0 - ease(((angle - CARRIED[0]) / (CARRIED[1] - CARRIED[0])).clamp(0.0, 1.0)),
                None => 0.0,
            },
            detail: 1.0 - ease((moved / FAR).min(1.0)),
        }
    }

    /// Rotates the limb of `pose` so that its tip comes to `goal`, a point of the world. The limb bends in the most
    /// natural plane, rotated by `swivel` about the line to the goal. A hand rotates with its forearm, but a foot keeps
    /// its rotation. Returns the remaining distance.
    pub(super) fn bring(&self, pose: &mut Pose, goal: Vec3, (natural, swivel): (NaturalBend, f32)) -> f32 {
        let end_before = rotation_of(&pose.node_to_world[self.end.index()]);
        let aim = self.aim(pose, goal, natural);
        let along = aim.along.unwrap_or(Vec3::Y);
        let plane = Quat::from_axis_angle(along, swivel) * aim.natural;
        if let Some(found) = hinge_rotations(aim.joints, aim.goal, [aim.normal, plane]) {
            pose.rotate(self.start, found.upper);
            pose.rotate(self.middle, found.lower * found.upper.inverse());
        }
        if !self.is_arm {
            let end = rotation_of(&pose.node_to_world[self.end.index()]);
            pose.rotate(self.end, end_before * end.inverse());
        }
        pose.position(self.tip).distance(goal)
    }
}

/// The most natural bend of a limb that points towards the direction `towards`, in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct NaturalBend {
    towards: Vec3,
    /// The normal of the plane in which the limb bends.
    normal: Vec3,
}

/// What the solver needs to know of a limb in one pose.
struct Aim {
    joints: [Vec3; 3],
    /// The goal of the last joint.
    goal: Vec3,
    /// The direction from the first joint to the goal; `None` if both are at one point.
    along: Option<Vec3>,
    /// The normal of the plane in which the limb bends.
    normal: Vec3,
    /// The normal of the most natural plane for a limb that points at the goal.
    natural: Vec3,
}

/// The rotation of a limb's plane about the line to its goal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swivel {
    /// The angle from the most natural plane to the limb's plane, in radians.
    pub(super) angle: f32,
    /// How certain the angle is: 0 for an arbitrary angle, 1 for a certain one.
    pub(super) known: f32,
    /// The fraction of the plane's own motion from frame to frame that is kept, from 0 to 1. The fraction is 0 if the
    /// limb is moved by [`FAR`] or more.
    pub(super) detail: f32,
}

fn tip_named(scene: &Scene, body: &Body, name: &str, end: NodeId) -> Result<NodeId> {
    let tip = node_named(scene, name, |bone| body.joint(bone))?;
    if tip == end || body.depends_on(tip, end) {
        return Ok(tip);
    }
    let message = format!(
        "tip must be {:?} or a joint below it, got {name:?}",
        scene.nodes[end.index()].name
    );
    Err(Diagnostic::new(Code::InvalidValue, message).into())
}
