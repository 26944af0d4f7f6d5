//! Moves an arm or a leg to a goal, frame by frame.

use glam::{Quat, Vec3};
use mocap_figure::axes::{angle_about, bend_axis};
use mocap_figure::body::Body;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::ik::{hinge_rotations, plane_normal, seen_hinge};
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};
use serde::{Deserialize, Serialize};

use super::frames::Frames;
use super::inertia::ease;
use super::target::node_named;

/// A limb, by its end.
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

    /// Its name.
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

    /// The upper bone, the lower bone and the end, and the bones of the trunk that may carry the limb, the nearest
    /// first.
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
    /// middle joint. Both are in the frame of the T-pose, for the left side. An arm in front of the body has its elbow
    /// below and a little outside. A standing leg has its knee in front.
    fn natural(self) -> [Vec3; 2] {
        match self.is_arm() {
            true => [Vec3::new(0.3, -0.4, 1.0), Vec3::new(0.4, -1.0, 0.0)],
            false => [Vec3::NEG_Y, Vec3::Z],
        }
    }
}

/// Two angles between the old and new direction of a limb, in radians. Up to the first, the plane of the limb follows
/// by the shortest rotation. At the second angle or more, the plane is [`Limb::natural`], because the shortest rotation
/// is undefined near 180 degrees.
const CARRIED: [f32; 2] = [1.0, 2.0];

/// The displacement of a limb, as a fraction of its length, at or above which the plane keeps none of its motion from
/// frame to frame.
const FAR: f32 = 0.3;

/// The length of the hinge axis of the T-pose, as `HINGE_AT_REST` of the knee. It is small beside the axes of bends,
/// whose length is the sine of their angle.
const HINGE_OF_T_POSE: f32 = 0.05;

/// The joints of a limb, and the axes about which it bends.
pub(super) struct LimbChain {
    is_arm: bool,
    pub(super) start: NodeId,
    middle: NodeId,
    end: NodeId,
    /// The node that moves to the goal: the end of the limb, or a node below.
    pub(super) tip: NodeId,
    /// The axis about which the limb bends, in the frame of its first joint.
    hinge: Vec3,
    /// The joint of the trunk that carries the limb, and the rotation from the frame of the T-pose to this joint.
    trunk: (NodeId, Quat),
    /// The direction of [`Limb::natural`], and the normal of its plane.
    natural: [Vec3; 2],
}

impl LimbChain {
    /// `tip` names the node that moves to the goal.
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

    /// Takes the hinge from the axis about which the limb bends in the motion.
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

    /// The positions of a limb in a pose, and its goal. A hand moves with its forearm as one, so the lower bone ends at
    /// the tip. A foot keeps its rotation, so the goal of the ankle is the place from which the tip reaches its goal.
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

    /// The vector from the first joint to the goal of the tip.
    pub(super) fn to_goal(&self, pose: &Pose, goal: Vec3) -> Vec3 {
        goal - self.reach(pose).0
    }

    /// The most natural bend towards a direction, for this rotation of the trunk.
    pub(super) fn natural(&self, trunk: Quat, towards: Vec3) -> NaturalBend {
        NaturalBend {
            towards,
            normal: trunk * (arc(self.natural[0], trunk.inverse() * towards) * self.natural[1]),
        }
    }

    /// A ball around all goals that the tip can reach in a pose: its centre and radius.
    pub(super) fn reach(&self, pose: &Pose) -> (Vec3, f32) {
        let last = if self.is_arm { self.tip } else { self.end };
        let joints = [self.start, self.middle, last].map(|node| pose.position(node));
        let carried = pose.position(self.tip) - joints[2];
        let radius = joints[0].distance(joints[1]) + joints[1].distance(joints[2]);
        (joints[0] + carried, radius)
    }

    /// The rotation of the trunk that carries the limb, from the frame of the T-pose to the world.
    pub(super) fn trunk(&self, pose: &Pose) -> Quat {
        let (joint, frame_to_joint) = self.trunk;
        (rotation_of(&pose.node_to_world[joint.index()]) * frame_to_joint.inverse()).normalize()
    }

    /// The angle between the plane of the limb and the most natural plane, about the line to the goal. The plane
    /// follows the limb by the shortest rotation.
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

    /// Rotates the limb of `pose` so that its tip comes to `goal`, in the world. Its plane is rotated by `swivel` from
    /// the most natural plane. Returns the remaining distance. A hand rotates with its forearm, a foot keeps its
    /// rotation.
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

/// The most natural bend of a limb towards a direction, in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct NaturalBend {
    towards: Vec3,
    /// The normal of the limb's plane.
    normal: Vec3,
}

/// The positions of a limb in a pose, and its goal.
struct Aim {
    joints: [Vec3; 3],
    /// The goal of the last of these joints.
    goal: Vec3,
    /// The direction from the first joint to the goal.
    along: Option<Vec3>,
    /// The normal of the plane in which the limb bends.
    normal: Vec3,
    /// The normal of the most natural plane at the goal.
    natural: Vec3,
}

/// The rotation of a limb's plane about the line to its goal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swivel {
    /// The angle from the most natural plane, in radians.
    pub(super) angle: f32,
    /// How well the angle is known, from 0 to 1.
    pub(super) known: f32,
    /// The fraction of the plane's own motion from frame to frame that is kept, from 0 to 1. A limb that is moved far
    /// keeps none.
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
