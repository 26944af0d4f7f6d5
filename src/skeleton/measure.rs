//! What the bones of a humanoid say about its file: unit, up axis, facing, rest pose.

use glam::Vec3;
use serde::Serialize;

use super::bone::HumanoidBone as Bone;
use super::humanoid::{Humanoid, Sides, rest_positions};
use super::poses::poses;
use super::{Confidence, Guess, Unit};
use crate::scene::{NodeId, Scene};

/// A direction along an axis of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[allow(missing_docs, reason = "each says itself")]
pub enum Axis {
    #[serde(rename = "x")]
    X,
    #[serde(rename = "y")]
    Y,
    #[serde(rename = "z")]
    Z,
    #[serde(rename = "-x")]
    NegX,
    #[serde(rename = "-y")]
    NegY,
    #[serde(rename = "-z")]
    NegZ,
    /// The file does not show it.
    #[serde(rename = "unknown")]
    Unknown,
}

impl Axis {
    /// The axis nearest to a direction, and the cosine between the two.
    fn nearest(way: Vec3) -> (Self, f32) {
        let way = way.normalize_or_zero();
        let all = [
            (Self::X, way.x),
            (Self::Y, way.y),
            (Self::Z, way.z),
            (Self::NegX, -way.x),
            (Self::NegY, -way.y),
            (Self::NegZ, -way.z),
        ];
        all.into_iter()
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((Self::Unknown, 0.0))
    }

    /// The direction of unit length; `None` where it is unknown.
    pub const fn direction(self) -> Option<Vec3> {
        match self {
            Self::X => Some(Vec3::X),
            Self::Y => Some(Vec3::Y),
            Self::Z => Some(Vec3::Z),
            Self::NegX => Some(Vec3::NEG_X),
            Self::NegY => Some(Vec3::NEG_Y),
            Self::NegZ => Some(Vec3::NEG_Z),
            Self::Unknown => None,
        }
    }

    /// Its name, as `-y`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::NegX => "-x",
            Self::NegY => "-y",
            Self::NegZ => "-z",
            Self::Unknown => "unknown",
        }
    }
}

/// The kind of a rest pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RestPose {
    /// Standing, arms sideways.
    TPose,
    /// Standing, arms sideways and down.
    APose,
    /// Standing, arms down.
    IPose,
    /// The bones lie along axes and make no figure.
    Collapsed,
    /// Anything else.
    Other,
}

impl RestPose {
    /// Its name in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::TPose => "t-pose",
            Self::APose => "a-pose",
            Self::IPose => "i-pose",
            Self::Collapsed => "collapsed",
            Self::Other => "other",
        }
    }
}

/// A humanoid with the places of its joints at rest.
pub(super) struct Figure<'a> {
    scene: &'a Scene,
    humanoid: &'a Humanoid,
    rest: Vec<Vec3>,
}

impl<'a> Figure<'a> {
    pub(super) fn new(scene: &'a Scene, humanoid: &'a Humanoid) -> Self {
        Self {
            scene,
            humanoid,
            rest: rest_positions(scene),
        }
    }

    /// The same figure in another pose, given by the places of its nodes.
    pub(super) fn with_places(scene: &'a Scene, humanoid: &'a Humanoid, places: Vec<Vec3>) -> Self {
        Self {
            scene,
            humanoid,
            rest: places,
        }
    }

    fn joint(&self, bone: Bone) -> Option<usize> {
        self.humanoid.joint(bone).map(NodeId::index)
    }

    fn at(&self, bone: Bone) -> Option<Vec3> {
        self.joint(bone).map(|joint| self.rest[joint])
    }

    /// The length of the way between two joints through the tree.
    fn way(&self, from: Bone, to: Bone) -> Option<f64> {
        let above = |node: usize| -> Vec<usize> {
            let parent = |node: &usize| self.scene.nodes[*node].parent.map(NodeId::index);
            std::iter::successors(Some(node), parent).collect()
        };
        let (up, down) = (above(self.joint(from)?), above(self.joint(to)?));
        let meeting = up.iter().position(|node| down.contains(node))?;
        let end = down.iter().position(|node| *node == up[meeting])?;
        let length = |nodes: &[usize]| -> f64 {
            let pairs = nodes.windows(2);
            pairs
                .map(|pair| f64::from(self.rest[pair[0]].distance(self.rest[pair[1]])))
                .sum()
        };
        Some(length(&up[..=meeting]) + length(&down[..=end]))
    }

    /// The length of thigh and shin, the mean of both sides.
    fn leg_length(&self) -> Option<f64> {
        let leg = |upper, lower, foot| Some(self.way(upper, lower)? + self.way(lower, foot)?);
        let left = leg(Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot)?;
        let right = leg(Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot)?;
        let length = 0.5 * (left + right);
        (length.is_finite() && length > 0.0).then_some(length)
    }

    /// The length of bone from ankle to head: shin, thigh, and the trunk from the hips to the joint of the head.
    pub(super) fn bone_length(&self) -> Option<f64> {
        let length = self.leg_length()? + self.way(Bone::Hips, Bone::Head)?;
        length.is_finite().then_some(length)
    }

    /// The unit in which the bones are those of a person.
    pub(super) fn unit(&self) -> Option<Guess<Unit>> {
        let length = self.bone_length()?;
        Some(unit_of(length, self.leg_length()?, family_unit(self.scene)))
    }

    /// Up from the feet to the head at rest, where the rest pose stands.
    fn rest_up(&self) -> Option<Vec3> {
        let middle = |a, b| Some(0.5 * (self.at(a)? + self.at(b)?));
        let hips = middle(Bone::LeftUpperLeg, Bone::RightUpperLeg)?;
        let above = self.at(Bone::Neck).or(self.at(Bone::Head))?;
        let trunk = (above - hips).try_normalize()?;
        let stands = [
            (Bone::LeftUpperLeg, Bone::LeftFoot),
            (Bone::RightUpperLeg, Bone::RightFoot),
        ]
        .into_iter()
        .all(|(upper, foot)| {
            let leg = self.at(upper).zip(self.at(foot)).map(|(upper, foot)| foot - upper);
            leg.is_some_and(|leg| leg.normalize_or_zero().dot(trunk) < -0.75)
        });
        stands.then_some(trunk)
    }

    /// The axis that points up.
    pub(super) fn up(&self) -> Option<Guess<Axis>> {
        let guess = |value, confidence, reason: String| {
            Some(Guess {
                value,
                confidence,
                reason,
            })
        };
        let rest = self.rest_up().map(Axis::nearest).filter(|(_, cosine)| *cosine > 0.8);
        let Some(motion) = self.motion_up() else {
            return match rest {
                Some((axis, _)) => guess(axis, Confidence::Likely, "the rest pose stands along it".to_owned()),
                None => None,
            };
        };
        let way = motion.mean;
        let words = format!(
            "from the feet to the head it is {:.2} {:.2} {:.2} of the way",
            way.x, way.y, way.z
        );
        let (axis, cosine) = Axis::nearest(way);
        let is_vertical = !matches!(axis, Axis::X | Axis::NegX);
        let is_clear = way.length() > 0.85 && cosine > 0.9 && is_vertical && motion.extended > 0.75;
        match rest {
            Some((rest, _)) if rest == axis && cosine > 0.7 => guess(
                axis,
                Confidence::Sure,
                format!("{words}, and the rest pose stands along it"),
            ),
            Some((rest, _)) if is_clear && motion.frames > 1 => {
                // Standing feet come back to one height along the up axis; a lying body lies near 0 along the other.
                let (of_motion, of_rest) = (motion.floor(axis), motion.floor(rest));
                if of_rest.abs() < 0.06 && of_motion.abs() > 0.1 {
                    let reason = format!("the rest pose stands along it, and the body lies on the floor ({words})");
                    guess(rest, Confidence::Likely, reason)
                } else {
                    let reason = format!("{words}, although the rest pose stands along {}", rest.as_str());
                    guess(axis, Confidence::Likely, reason)
                }
            }
            Some((rest, _)) => guess(
                rest,
                Confidence::Likely,
                format!("the rest pose stands along it; in motion {words}"),
            ),
            None if is_clear => guess(axis, Confidence::Sure, words),
            None if is_vertical && cosine > 0.7 => guess(axis, Confidence::Likely, words),
            None => {
                let axis = if way.z.abs() > way.y.abs() { Axis::Z } else { Axis::Y };
                guess(axis, Confidence::Unsure, words)
            }
        }
    }

    fn motion_up(&self) -> Option<Motion> {
        self.scene.animations.first()?;
        let (left, right) = (self.joint(Bone::LeftFoot), self.joint(Bone::RightFoot));
        let feet = left
            .or(self.joint(Bone::LeftLowerLeg))
            .zip(right.or(self.joint(Bone::RightLowerLeg)))?;
        let head = self.joint(Bone::Head).or(self.joint(Bone::Neck))?;
        let length = self.bone_length()? as f32;
        let poses = poses(self.scene);
        let mut motion = Motion {
            mean: Vec3::ZERO,
            extended: 0.0,
            lowest: Vec::new(),
            highest: Vec::new(),
            length,
            frames: self.scene.animations[0].frame_count(),
        };
        let share = 1.0 / poses.len() as f32;
        for pose in &poses {
            let at = |node: usize| pose.position(NodeId::new(node));
            let way = at(head) - 0.5 * (at(feet.0) + at(feet.1));
            motion.mean += share * way.normalize_or_zero();
            motion.extended += share * way.length() / length;
            let places = || self.humanoid.bones.values().map(|joint| pose.position(joint.joint));
            motion.lowest.extend(places().reduce(Vec3::min));
            motion.highest.extend(places().reduce(Vec3::max));
        }
        motion.mean.is_finite().then_some(motion)
    }

    /// Where the figure of the rest pose looks.
    pub(super) fn facing(&self) -> Guess<Axis> {
        let unknown = |reason: &str| Guess {
            value: Axis::Unknown,
            confidence: Confidence::Unsure,
            reason: reason.to_owned(),
        };
        let Some(up) = self.rest_up() else {
            return unknown("the rest pose is not that of a standing figure");
        };
        let across = self.at(Bone::LeftUpperLeg).zip(self.at(Bone::RightUpperLeg));
        let Some(across) = across.and_then(|(left, right)| (left - right).try_normalize()) else {
            return unknown("both hip joints are at one place");
        };
        let by_names = across.cross(up);
        let (forward, confidence, reason) = match self.humanoid.sides {
            Sides::Opposite => (
                -by_names,
                Confidence::Likely,
                "feet and knees point there, although left and right are named the other way",
            ),
            Sides::Agree => (
                by_names,
                Confidence::Sure,
                "left, right and up at rest, and the body agrees with the names of the sides",
            ),
            Sides::Unknown => (by_names, Confidence::Likely, "left, right and up at rest"),
        };
        let (value, cosine) = Axis::nearest(forward);
        Guess {
            value,
            confidence: if cosine > 0.9 { confidence } else { Confidence::Unsure },
            reason: reason.to_owned(),
        }
    }

    /// The kind of the rest pose. `up` is the axis of the world.
    pub(super) fn rest_pose(&self, up: Axis) -> Guess<RestPose> {
        let guess = |value, confidence, reason: String| Guess {
            value,
            confidence,
            reason,
        };
        let Some(trunk) = self.rest_up() else {
            let leg = self
                .at(Bone::LeftUpperLeg)
                .zip(self.at(Bone::LeftFoot))
                .map(|(upper, foot)| upper - foot);
            let hangs = leg.is_some_and(|leg| Axis::nearest(leg).0 == up);
            let (value, reason) = if hangs {
                (
                    RestPose::Other,
                    "the legs hang down, and the trunk does not stand above them",
                )
            } else {
                (
                    RestPose::Collapsed,
                    "the bones lie along axes and make no standing figure",
                )
            };
            return guess(value, Confidence::Likely, reason.to_owned());
        };
        let below = |upper, end| {
            let arm = (self.at(end)? - self.at(upper)?).try_normalize()?;
            Some((-arm.dot(trunk)).asin().to_degrees())
        };
        let arm = |upper, lower, hand| below(upper, hand).or_else(|| below(upper, lower));
        let left = arm(Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand);
        let right = arm(Bone::RightUpperArm, Bone::RightLowerArm, Bone::RightHand);
        let (Some(left), Some(right)) = (left, right) else {
            return guess(
                RestPose::Other,
                Confidence::Likely,
                "it stands, and has no arms".to_owned(),
            );
        };
        let bent_legs = [
            (Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot),
            (Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot),
        ]
        .into_iter()
        .any(|(upper, lower, foot)| {
            let ways = self.at(upper).zip(self.at(lower)).zip(self.at(foot));
            ways.is_some_and(|((upper, lower), foot)| {
                (lower - upper)
                    .normalize_or_zero()
                    .dot((foot - lower).normalize_or_zero())
                    < 0.9
            })
        });
        let words = format!("the arms are {left:.0} and {right:.0} degrees below horizontal");
        let value = match (left.min(right), left.max(right)) {
            _ if bent_legs => RestPose::Other,
            (low, high) if low > -20.0 && high <= 20.0 => RestPose::TPose,
            (low, high) if low > 15.0 && high <= 60.0 => RestPose::APose,
            (low, _) if low > 75.0 => RestPose::IPose,
            _ => RestPose::Other,
        };
        guess(value, Confidence::Sure, words)
    }
}

/// Measurements of a few poses.
struct Motion {
    /// The mean of the directions from the feet to the head.
    mean: Vec3,
    /// The distance from the feet to the head, as a share of the length of bone.
    extended: f32,
    lowest: Vec<Vec3>,
    highest: Vec<Vec3>,
    length: f32,
    frames: usize,
}

impl Motion {
    /// The height of the lowest joint along an axis, in the median, as a share of the figure.
    fn floor(&self, axis: Axis) -> f32 {
        let mut heights: Vec<f32> = std::iter::zip(&self.lowest, &self.highest)
            .map(|(low, high)| match axis {
                Axis::X => low.x,
                Axis::Y => low.y,
                Axis::Z | Axis::Unknown => low.z,
                Axis::NegX => -high.x,
                Axis::NegY => -high.y,
                Axis::NegZ => -high.z,
            })
            .collect();
        heights.sort_by(f32::total_cmp);
        heights
            .get(heights.len() / 2)
            .map_or(0.0, |height| height / self.length)
    }
}

/// Metres of bone from ankle to head that a person has: a grown one, and anybody.
const ADULT: [f64; 2] = [1.18, 1.75];
const ANYBODY: [f64; 2] = [0.72, 2.2];

/// Metres of thigh and shin of a usual person, for a file in no known unit: 0.49 of 1.7 m.
const USUAL_LEG: f64 = 0.833;

/// The unit of a program or a database, by the names that it gives to joints.
fn family_unit(scene: &Scene) -> Option<(Unit, &'static str)> {
    let has = |names: &[&str]| {
        names
            .iter()
            .all(|name| scene.nodes.iter().any(|node| node.name == *name))
    };
    if has(&["HMD", "Left-Hip"]) {
        Some((Unit::Centimetre, "SlimeVR"))
    } else if has(&["spine05", "upperleg01.L"]) || has(&["UpLeg_L", "LoLeg_L", "__UpLeg_L"]) {
        Some((Unit::Decimetre, "MakeHuman"))
    } else if has(&["LHipJoint", "LowerBack"]) || has(&["lhipjoint", "lowerback"]) || has(&["LHipJoint", "lowerback"]) {
        Some((Unit::Cmu, "CMU's database"))
    } else if has(&["figureHair", "lShldr"]) || has(&["mPelvis", "mTorso"]) {
        Some((Unit::Inch, "Second Life"))
    } else {
        None
    }
}

fn unit_of(length: f64, leg: f64, family: Option<(Unit, &'static str)>) -> Guess<Unit> {
    let within = |unit: &Unit, [least, most]: [f64; 2]| (least..=most).contains(&(length * unit.metres()));
    let measured = |unit: Unit| {
        let metres = length * unit.metres();
        format!("from ankle to head there are {length:.4} units of bone, which is {metres:.2} m")
    };
    if let Some((unit, name)) = family.filter(|(unit, _)| within(unit, ANYBODY)) {
        return Guess {
            value: unit,
            confidence: Confidence::Sure,
            reason: format!("{}, and the joints have the names of {name}", measured(unit)),
        };
    }
    let known = [
        Unit::Centimetre,
        Unit::Metre,
        Unit::Millimetre,
        Unit::Inch,
        Unit::Cmu,
        Unit::Decimetre,
    ];
    if let Some(unit) = known.into_iter().find(|unit| within(unit, ADULT)) {
        // Few files are in decimetres or in CMU's unit but those that have its names.
        let is_common = !matches!(unit, Unit::Decimetre | Unit::Cmu | Unit::Inch);
        return Guess {
            value: unit,
            confidence: if is_common {
                Confidence::Sure
            } else {
                Confidence::Likely
            },
            reason: measured(unit),
        };
    }
    // Children and giants, in the units that everybody uses.
    if let Some(unit) = known[..3].iter().copied().find(|unit| within(unit, ANYBODY)) {
        return Guess {
            value: unit,
            confidence: Confidence::Likely,
            reason: format!("{}, a child or a giant", measured(unit)),
        };
    }
    let unit = Unit::measured(USUAL_LEG / leg);
    Guess {
        value: unit,
        confidence: Confidence::Unsure,
        reason: format!("{} if it is a usual person; in no known unit it is one", measured(unit)),
    }
}
