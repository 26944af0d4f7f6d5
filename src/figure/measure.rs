//! Infers the unit, the up axis, the facing and the kind of the rest pose from a humanoid's bones.

use std::cell::OnceCell;

use glam::Vec3;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

use super::Confidence;
use super::axis::{Axis, RestPose};
use super::humanoid::{Humanoid, Sides, rest_positions};
use super::poses::poses;
use super::unit::{Unit, family_unit, unit_of};
use mocap_scene::scene::report::Guess;

/// The largest asymmetry of a bind pose, in degrees: the angle between a bone and the mirrored bone of the other side.
/// Bind poses of the fixtures differ by up to 6 degrees, most by 0. A pose with a larger asymmetry is a frame of a
/// motion, with arbitrary roll of the limbs.
const LOPSIDED: f32 = 18.0;

/// If the asymmetry of a rest pose is above this angle in degrees, its hips or shoulders must lie along an axis of the
/// world. The rest poses of the fixtures lie along these axes exactly. A few frames of motions look like a T-pose, with
/// an asymmetry below 18 degrees, but are 6 to 10 degrees from the axes. The hip joints of SMPL's bodies are 7 degrees
/// from level, and their shoulders are level.
const SLANTING: f32 = 6.0;

/// The largest angle in degrees between the line of hips or shoulders and an axis at which the pose lies along the
/// axis: half of `SLANTING`.
const ALONG_AN_AXIS: f32 = 3.0;

/// The largest bend of an elbow in a bind pose, in degrees. The most bent elbows of the fixtures are MakeHuman's, with
/// 46 degrees.
const BENT_ELBOW: f32 = 60.0;

/// A humanoid with the positions of its joints at rest.
pub(super) struct Measures<'a> {
    pub(super) scene: &'a Scene,
    pub(super) humanoid: &'a Humanoid,
    rest: Vec<Vec3>,
    poses: OnceCell<Vec<Pose>>,
}

impl<'a> Measures<'a> {
    pub(super) fn new(scene: &'a Scene, humanoid: &'a Humanoid) -> Self {
        Self {
            scene,
            humanoid,
            rest: rest_positions(scene),
            poses: OnceCell::new(),
        }
    }

    /// The same figure in another pose. `positions` has the positions of its nodes.
    pub(super) fn with_positions(scene: &'a Scene, humanoid: &'a Humanoid, positions: Vec<Vec3>) -> Self {
        Self {
            scene,
            humanoid,
            rest: positions,
            poses: OnceCell::new(),
        }
    }

    /// Some poses of the motion.
    pub(super) fn poses(&self) -> &[Pose] {
        self.poses.get_or_init(|| poses(self.scene))
    }

    pub(super) fn joint(&self, bone: Bone) -> Option<usize> {
        self.humanoid.joint(bone).map(NodeId::index)
    }

    fn at(&self, bone: Bone) -> Option<Vec3> {
        self.joint(bone).map(|joint| self.rest[joint])
    }

    /// The length of the path between two joints through the tree.
    fn distance(&self, from: Bone, to: Bone) -> Option<f64> {
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

    /// The length of thigh plus shin, averaged over both sides.
    fn leg_length(&self) -> Option<f64> {
        let leg = |upper, lower, foot| Some(self.distance(upper, lower)? + self.distance(lower, foot)?);
        let left = leg(Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot)?;
        let right = leg(Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot)?;
        let length = 0.5 * (left + right);
        (length.is_finite() && length > 0.0).then_some(length)
    }

    /// The sum of the lengths of the bones from ankle to head: shin, thigh, and the trunk from the hips to the head
    /// joint.
    pub(super) fn bone_length(&self) -> Option<f64> {
        let length = self.leg_length()? + self.distance(Bone::Hips, Bone::Head)?;
        length.is_finite().then_some(length)
    }

    /// The unit in which the bones have the lengths of a person's bones.
    pub(super) fn unit(&self) -> Option<Guess<Unit>> {
        let leg = self.leg_length()?;
        Some(unit_of(self.bone_length(), leg, family_unit(self.scene)))
    }

    /// The up direction from the feet to the head at rest, if the rest pose stands.
    pub(super) fn rest_up(&self) -> Option<Vec3> {
        let middle = |a, b| Some(0.5 * (self.at(a)? + self.at(b)?));
        let hips = middle(Bone::LeftUpperLeg, Bone::RightUpperLeg)?;
        let above = self.at(Bone::Neck).or(self.at(Bone::Head));
        let above = above.or_else(|| middle(Bone::LeftUpperArm, Bone::RightUpperArm));
        // A body that consists only of hips and legs stands if its legs are parallel.
        let above = above.or_else(|| Some(2.0 * hips - middle(Bone::LeftFoot, Bone::RightFoot)?))?;
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

    /// The reason why the rest pose is a frame of a motion and not a bind pose; `None` if it may be a bind pose.
    fn is_a_moment(&self) -> Option<String> {
        let lopsided = self.lopsided().unwrap_or(0.0).to_degrees();
        if lopsided > LOPSIDED || lopsided > SLANTING && self.off_axes() > Some(ALONG_AN_AXIS) {
            return Some(format!(
                "left and right differ from a mirror image by {lopsided:.0} degrees, as in a frame of a motion"
            ));
        }
        let bend = |side: Side| {
            let at = |bone: Bone| self.at(bone.on(side));
            let elbow = at(Bone::LeftLowerArm)?;
            let bend = (elbow - at(Bone::LeftUpperArm)?).angle_between(at(Bone::LeftHand)? - elbow);
            bend.is_finite().then_some(bend.to_degrees())
        };
        let bends = [Side::Left, Side::Right].into_iter().filter_map(bend);
        let bent = bends.filter(|bend| *bend > BENT_ELBOW).reduce(f32::max)?;
        Some(format!(
            "an elbow is bent by {bent:.0} degrees, as in a frame of a motion"
        ))
    }

    /// The angle in degrees between the line of the hips or shoulders at rest and the nearest world axis: the smaller
    /// of both.
    fn off_axes(&self) -> Option<f32> {
        let off = |bone: Bone| {
            let across = (self.at(bone)? - self.at(bone.on(Side::Right))?).try_normalize()?;
            Some(across.abs().max_element().min(1.0).acos().to_degrees())
        };
        let lines = [Bone::LeftUpperLeg, Bone::LeftUpperArm].into_iter();
        lines.filter_map(off).reduce(f32::min)
    }

    /// The largest angle at rest between a bone of an arm or a leg and the mirrored bone of the other side.
    fn lopsided(&self) -> Option<f32> {
        let line = |bone: Bone| (self.at(bone)? - self.at(bone.on(Side::Right))?).try_normalize();
        let hips = line(Bone::LeftUpperLeg)?;
        let across = (hips + line(Bone::LeftUpperArm).unwrap_or(hips)).try_normalize()?;
        let angle = |(upper, end): (Bone, Bone)| {
            let limb = |side| Some(self.at(end.on(side))? - self.at(upper.on(side))?);
            let right = limb(Side::Right)?;
            let angle = limb(Side::Left)?.angle_between(right - 2.0 * right.project_onto_normalized(across));
            angle.is_finite().then_some(angle)
        };
        let bones = [
            (Bone::LeftUpperArm, Bone::LeftLowerArm),
            (Bone::LeftLowerArm, Bone::LeftHand),
            (Bone::LeftUpperLeg, Bone::LeftLowerLeg),
            (Bone::LeftLowerLeg, Bone::LeftFoot),
        ];
        bones.into_iter().filter_map(angle).reduce(f32::max)
    }

    /// Whether no arm crosses the body. Arms may cross the body if all bones lie along one axis.
    fn has_arms_outwards(&self) -> bool {
        /// The cosine of 107 degrees, the largest angle between an upper arm and the outward line at which the arm does
        /// not cross the body.
        const ACROSS: f32 = -0.3;
        let shoulders = self.at(Bone::LeftUpperArm).zip(self.at(Bone::RightUpperArm));
        let outwards = shoulders.and_then(|(left, right)| (left - right).try_normalize());
        let points_out = |side: Side, outwards: Vec3| {
            let ends = self
                .at(Bone::LeftUpperArm.on(side))
                .zip(self.at(Bone::LeftLowerArm.on(side)));
            ends.is_none_or(|(upper, lower)| (lower - upper).normalize_or_zero().dot(outwards) > ACROSS)
        };
        outwards.is_none_or(|left| points_out(Side::Left, left) && points_out(Side::Right, -left))
    }

    /// Both feet: the ankles, or the knees of a body without ankles.
    pub(super) fn feet(&self) -> Option<[usize; 2]> {
        let left = self.joint(Bone::LeftFoot).or(self.joint(Bone::LeftLowerLeg))?;
        let right = self.joint(Bone::RightFoot).or(self.joint(Bone::RightLowerLeg))?;
        Some([left, right])
    }

    /// The largest relative difference between the lengths of a left and a right bone of arms and legs.
    pub(super) fn asymmetry(&self) -> Option<Guess<f64>> {
        const PAIRS: [(Bone, Bone); 4] = [
            (Bone::LeftUpperArm, Bone::LeftLowerArm),
            (Bone::LeftLowerArm, Bone::LeftHand),
            (Bone::LeftUpperLeg, Bone::LeftLowerLeg),
            (Bone::LeftLowerLeg, Bone::LeftFoot),
        ];
        let difference = |(from, to): (Bone, Bone)| {
            let left = self.distance(from, to)?;
            let right = self.distance(from.on(Side::Right), to.on(Side::Right))?;
            let most = left.max(right);
            (most > 0.0 && most.is_finite()).then(|| ((left - right).abs() / most, from))
        };
        let all = PAIRS.into_iter().filter_map(difference);
        let (value, bone) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let bone = bone.as_str().trim_start_matches("left");
        let reason = if value < 5e-4 {
            "left and right arms and legs have equal lengths".to_owned()
        } else {
            let percent = 100.0 * value;
            format!("the lengths of left and right differ most for {bone}, by {percent:.1} %")
        };
        Some(Guess {
            value,
            confidence: Confidence::Sure,
            reason,
        })
    }

    /// The facing of the figure in the rest pose.
    pub(super) fn facing(&self) -> Guess<Axis> {
        let unknown = |reason: &str| Guess {
            value: Axis::Unknown,
            confidence: Confidence::Unsure,
            reason: reason.to_owned(),
        };
        let Some(up) = self.rest_up() else {
            return unknown("the rest pose is not a standing figure");
        };
        let across = self.at(Bone::LeftUpperLeg).zip(self.at(Bone::RightUpperLeg));
        let Some(across) = across.and_then(|(left, right)| (left - right).try_normalize()) else {
            return unknown("both hip joints are at the same point");
        };
        let by_names = across.cross(up);
        let (forward, confidence, reason) = match self.humanoid.sides {
            Sides::Opposite => (
                -by_names,
                Confidence::Likely,
                "feet and knees point in this direction, although the names exchange left and right",
            ),
            Sides::Agree => (
                by_names,
                Confidence::Sure,
                "this direction follows from left, right and up at rest, and the body agrees with the names of the \
                 sides",
            ),
            Sides::Unknown => (
                by_names,
                Confidence::Likely,
                "this direction follows from left, right and up at rest",
            ),
        };
        let (value, cosine) = Axis::nearest(forward);
        Guess {
            value,
            confidence: if cosine > 0.9 { confidence } else { Confidence::Unsure },
            reason: reason.to_owned(),
        }
    }

    /// The kind of the rest pose. `up` is the up axis of the world.
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
                (RestPose::Other, "the legs hang down, but the trunk is not above them")
            } else {
                (
                    RestPose::Collapsed,
                    "the bones lie along axes and do not form a standing figure",
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
                "the figure stands, and has no arms".to_owned(),
            );
        };
        let bent_legs = [
            (Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot),
            (Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot),
        ]
        .into_iter()
        .any(|(upper, lower, foot)| {
            let joints = self.at(upper).zip(self.at(lower)).zip(self.at(foot));
            joints.is_some_and(|((upper, lower), foot)| {
                (lower - upper)
                    .normalize_or_zero()
                    .dot((foot - lower).normalize_or_zero())
                    < 0.9
            })
        });
        let words = format!("the arms are {left:.0} and {right:.0} degrees below horizontal");
        if let Some(words) = self.is_a_moment() {
            return guess(RestPose::Other, Confidence::Likely, words);
        }
        let value = match (left.min(right), left.max(right)) {
            _ if bent_legs || !self.has_arms_outwards() => RestPose::Other,
            (low, high) if low > -20.0 && high <= 20.0 => RestPose::TPose,
            (low, high) if low > 15.0 && high <= 60.0 => RestPose::APose,
            (low, _) if low > 75.0 => RestPose::IPose,
            _ => RestPose::Other,
        };
        guess(value, Confidence::Sure, words)
    }
}
