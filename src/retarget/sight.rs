//! Compares the visible rotations of a motion on two bodies, in addition to the directions of limbs: the roll of limbs,
//! the trunk, the head and the palms.
//!
//! Of the source, only positions are used: lines of the trunk, planes in which elbows and knees bend, knuckles. The
//! source's rotations only show whether an elbow has a constant axis. The axes of the target's T-pose move with the
//! target's joints. So the comparison detects a wrong T-pose of the source.

use std::fmt;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use mocap_figure::axes::{angle_about, bend_axis};
use mocap_figure::body::Body;
use mocap_figure::t_pose::limb_end;
use mocap_figure::{HumanoidBone as Bone, Side};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::pose::Pose;
use mocap_scene::scene::NodeId;

/// The sine of the smallest bend that shows the plane of a hinge: 20 degrees.
const BENT: f32 = 0.34;

/// The smallest number of frames that show the plane of a hinge.
const FEWEST: usize = 5;

/// The largest mean deviation of an elbow's axis from its mean axis, in the axes of the forearm's joint, in radians: 10
/// degrees. With a larger deviation the axis is not constant, because the forearm is also twisted.
const CONSTANT: f32 = 0.175;

/// The compared aspect of a body.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Aspect {
    /// The roll of a limb: the plane in which its elbow or knee bends.
    Roll,
    /// The lines of the hip joints, of the shoulder joints, and from hips to neck.
    Trunk,
    /// The average direction of the face relative to the chest: 0 is straight ahead.
    Head,
    /// The palms, by the knuckles of index finger and little finger.
    Palm,
}

impl Aspect {
    /// The name of the aspect, as in JSON.
    ///
    /// ```
    /// assert_eq!(mocap::retarget::report::Aspect::Roll.as_str(), "roll");
    /// ```
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Roll => "roll",
            Self::Trunk => "trunk",
            Self::Head => "head",
            Self::Palm => "palm",
        }
    }
}

/// The difference of an aspect between source and target.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct AspectError {
    /// The compared aspect.
    pub aspect: Aspect,
    /// The bone. For the trunk, hips is the line of the hip joints, spine the line from hips to neck, and chest the
    /// line of the shoulder joints.
    pub bone: Bone,
    /// The mean angle in degrees of all frames that show the aspect. For a roll it is the mean of signed angles,
    /// weighted by the square of the sine of the bend, because planes of nearly straight limbs are noisy.
    pub mean_degrees: f64,
    /// The largest angle of a frame, in degrees.
    pub max_degrees: f64,
    /// The tick of the largest angle.
    pub tick: f64,
}

/// The aspect and the bone, as in "roll of leftUpperArm".
impl fmt::Display for AspectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.aspect {
            Aspect::Head => f.write_str(self.aspect.as_str()),
            Aspect::Trunk => write!(f, "trunk at {}", self.bone.as_str()),
            aspect => write!(f, "{} of {}", aspect.as_str(), self.bone.as_str()),
        }
    }
}

/// Angles of one aspect of one bone, in radians, with their ticks.
struct Angles {
    aspect: Aspect,
    bone: Bone,
    all: Vec<(f32, f64)>,
    /// The weight of each angle in the mean angle.
    weights: Vec<f32>,
}

impl Angles {
    fn seen(self) -> Option<AspectError> {
        let enough = if self.aspect == Aspect::Roll { FEWEST } else { 1 };
        if self.all.len() < enough {
            return None;
        }
        let count = self.all.len() as f32;
        let mean = match self.aspect {
            Aspect::Roll => {
                let weighted = |of: fn(f32) -> f32| -> f32 {
                    let all = self.all.iter().zip(&self.weights);
                    all.map(|((angle, _), weight)| weight * of(*angle)).sum()
                };
                weighted(f32::sin).atan2(weighted(f32::cos)).abs()
            }
            _ => self.all.iter().map(|(angle, _)| angle).sum::<f32>() / count,
        };
        let (largest, tick) = self.all.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
        Some(AspectError {
            aspect: self.aspect,
            bone: self.bone,
            mean_degrees: f64::from(mean.to_degrees()),
            max_degrees: f64::from(largest.abs().to_degrees()),
            tick: *tick,
        })
    }
}

/// Compares poses of two bodies, one after another.
pub(super) struct Sight<'a> {
    source: &'a Body,
    target: &'a Body,
    rolls: Vec<(Limb, Angles)>,
    lines: Vec<([Ends; 2], Angles)>,
    palms: Vec<([[NodeId; 3]; 2], Angles)>,
    /// The sum of the face's directions in the axes of the chest, and the number of summed directions.
    face: (Vec3, usize),
}

/// Two ends of a line: each the middle of two joints.
type Ends = [[NodeId; 2]; 2];

/// A bone with a hinge.
struct Limb {
    /// Start, hinge and end of the limb on the source.
    joints: [NodeId; 3],
    /// The start and the end of the bone on the target, and the joint that rotates with the bone at its hinge.
    target: [NodeId; 2],
    turned: NodeId,
    /// The rotation from the axes of the T-pose to the joint that rotates with the bone.
    frame_to_joint: Quat,
    axis: Vec3,
    /// For a forearm: the bending axis of the elbow, in the axes of the source's joint, in each frame that shows the
    /// axis.
    in_forearm: Option<Vec<Vec3>>,
}

impl<'a> Sight<'a> {
    pub(super) fn new(source: &'a Body, target: &'a Body) -> Self {
        let angles = |aspect, bone| Angles {
            aspect,
            bone,
            all: Vec::new(),
            weights: Vec::new(),
        };
        // A standing rest pose shows the roll of limbs, even if an elbow bends in another plane. So these limbs are not
        // compared.
        let limbs = Bone::ALL.iter().filter(|_| !source.stands_at_rest());
        let rolls = limbs.filter_map(|bone| Some((Limb::new(source, target, *bone)?, angles(Aspect::Roll, *bone))));
        let lines = [Bone::Hips, Bone::Chest, Bone::Spine].into_iter().filter_map(|bone| {
            let ends = [line(source, bone)?, line(target, bone)?];
            Some((ends, angles(Aspect::Trunk, bone)))
        });
        let palms = [Bone::LeftHand, Bone::RightHand].into_iter().filter_map(|bone| {
            let joints = [palm(source, bone)?, palm(target, bone)?];
            Some((joints, angles(Aspect::Palm, bone)))
        });
        Self {
            rolls: rolls.collect(),
            lines: lines.collect(),
            palms: palms.collect(),
            face: (Vec3::ZERO, 0),
            source,
            target,
        }
    }

    /// Compares both bodies at a tick.
    pub(super) fn look(&mut self, was: &Pose, is: &Pose, tick: f64) {
        let (to_source, to_target) = (self.source.axes.inverse(), self.target.axes.inverse());
        for (limb, angles) in &mut self.rolls {
            let angle = limb.roll(was, is, to_source, to_target);
            if let Some((angle, bend)) = angle {
                angles.all.push((angle, tick));
                angles.weights.push(bend * bend);
            }
        }
        for ([from, to], angles) in &mut self.lines {
            let (from, to) = (to_source * along(was, from), to_target * along(is, to));
            angles.all.push((angle_between(from, to), tick));
        }
        for ([from, to], angles) in &mut self.palms {
            let (from, to) = (to_source * normal(was, from), to_target * normal(is, to));
            angles.all.push((angle_between(from, to), tick));
        }
        if let Some(face) = self.face_in_chest(is) {
            self.face = (self.face.0 + face, self.face.1 + 1);
        }
    }

    /// The differences, the largest first.
    pub(super) fn found(self, tick: f64) -> Vec<AspectError> {
        let rolls = self.rolls.into_iter().filter(|(limb, _)| limb.has_one_axis());
        let rolls = rolls.map(|(_, angles)| angles);
        let lines = self.lines.into_iter().map(|(_, angles)| angles);
        let palms = self.palms.into_iter().map(|(_, angles)| angles);
        let mut head = Angles {
            aspect: Aspect::Head,
            bone: Bone::Head,
            all: Vec::new(),
            weights: Vec::new(),
        };
        if self.face.1 >= FEWEST {
            head.all.push((angle_between(self.face.0, Vec3::Z), tick));
        }
        let all = rolls.chain(lines).chain(palms).chain([head]);
        let mut all: Vec<AspectError> = all.filter_map(Angles::seen).collect();
        all.sort_by(|a, b| b.mean_degrees.total_cmp(&a.mean_degrees));
        all
    }

    /// The direction of the target's face, in the axes of its chest: left, up, forward.
    fn face_in_chest(&self, is: &Pose) -> Option<Vec3> {
        let head = self.target.joint(Bone::Head)?;
        self.source.joint(Bone::Head)?;
        let left = along(is, &line(self.target, Bone::Chest)?).try_normalize()?;
        let up = along(is, &line(self.target, Bone::Spine)?);
        let up = up.reject_from_normalized(left).try_normalize()?;
        let rotation = rotation_of(&is.node_to_world[head.index()]);
        let face = rotation * self.target.frame_to_joint(Bone::Head, head).inverse() * Vec3::Z;
        Some(Vec3::new(face.dot(left), face.dot(up), face.dot(left.cross(up))))
    }
}

impl Limb {
    fn new(source: &Body, target: &Body, bone: Bone) -> Option<Self> {
        let axis = bend_axis(bone)?;
        let side = bone.side()?;
        let part = bone.on(Side::Left);
        let (upper, is_upper) = match part {
            Bone::LeftUpperLeg | Bone::LeftLowerLeg => (Bone::LeftUpperLeg.on(side), part == Bone::LeftUpperLeg),
            _ => (Bone::LeftUpperArm.on(side), part == Bone::LeftUpperArm),
        };
        let lower = limb_end(upper)?;
        let end = limb_end(lower)?;
        let turned = match is_upper {
            true => *target.segment(bone).last()?,
            false => target.joint(bone)?,
        };
        Some(Self {
            joints: [source.joint(upper)?, source.joint(lower)?, source.joint(end)?],
            target: [target.joint(bone)?, target.joint(limb_end(bone)?)?],
            turned,
            frame_to_joint: target.frame_to_joint(bone, turned),
            axis,
            in_forearm: (part == Bone::LeftLowerArm).then(Vec::new),
        })
    }

    /// Whether the bending axis is constant in the bone. Only some forearms have a variable axis.
    fn has_one_axis(&self) -> bool {
        let Some(axes) = &self.in_forearm else { return true };
        let mean = axes.iter().sum::<Vec3>();
        let off: f32 = axes.iter().map(|axis| angle_between(*axis, mean)).sum();
        off <= CONSTANT * axes.len() as f32
    }

    /// The angle about the bone from the target's bending direction to the source's bending direction, in radians, and
    /// the sine of the bend. `None` for a straight limb.
    fn roll(&mut self, was: &Pose, is: &Pose, to_source: Quat, to_target: Quat) -> Option<(f32, f32)> {
        let at = self.joints.map(|joint| was.position(joint));
        let upper = (at[1] - at[0]).try_normalize()?;
        let lower = (at[2] - at[1]).try_normalize()?;
        let plane = upper.cross(lower);
        (plane.length() > BENT).then_some(())?;
        if let Some(axes) = &mut self.in_forearm {
            let forearm = rotation_of(&was.node_to_world[self.joints[1].index()]);
            axes.push(forearm.inverse() * plane.normalize());
        }
        let along = to_target * (is.position(self.target[1]) - is.position(self.target[0])).try_normalize()?;
        let rotation = rotation_of(&is.node_to_world[self.turned.index()]);
        let carried = to_target * (rotation * self.frame_to_joint.inverse() * self.axis);
        Some((angle_about(along, carried, to_source * plane)?, plane.length()))
    }
}

/// A line of the trunk.
fn line(body: &Body, bone: Bone) -> Option<Ends> {
    let twice = |bone: Bone| body.joint(bone).map(|joint| [joint; 2]);
    match bone {
        Bone::Hips => Some([twice(Bone::RightUpperLeg)?, twice(Bone::LeftUpperLeg)?]),
        Bone::Chest => Some([twice(Bone::RightUpperArm)?, twice(Bone::LeftUpperArm)?]),
        _ => {
            let hips = [body.joint(Bone::LeftUpperLeg)?, body.joint(Bone::RightUpperLeg)?];
            Some([hips, twice(Bone::Neck).or_else(|| twice(Bone::Head))?])
        }
    }
}

/// The joints of hand, index finger and little finger.
fn palm(body: &Body, hand: Bone) -> Option<[NodeId; 3]> {
    let joint = |bone: Bone| body.joint(bone.on(hand.side()?));
    Some([
        body.joint(hand)?,
        joint(Bone::LeftIndexProximal)?,
        joint(Bone::LeftLittleProximal)?,
    ])
}

fn along(pose: &Pose, ends: &Ends) -> Vec3 {
    let [from, to] = ends.map(|[a, b]| 0.5 * (pose.position(a) + pose.position(b)));
    to - from
}

fn normal(pose: &Pose, joints: &[NodeId; 3]) -> Vec3 {
    let [hand, index, little] = joints.map(|joint| pose.position(joint));
    (index - hand).cross(little - hand)
}

/// The angle between two vectors, in radians; 0 if one has no length.
fn angle_between(a: Vec3, b: Vec3) -> f32 {
    a.cross(b).length().atan2(a.dot(b))
}
