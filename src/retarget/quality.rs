//! The report of a motion that was retargeted to another skeleton.

mod text;

use std::collections::BTreeMap;
use std::fmt;

use mocap_edit::report::FootLockReport;
use mocap_figure::HumanoidBone as Bone;
use serde::{Deserialize, Serialize};

use super::hand_report::HandsReport;
use super::plan::UnmappedBone;
use super::sight::{Aspect, AspectError};
use super::skin_report::SkinReport;

/// The largest increase of the feet's sliding speed from the source to the target, in m/s.
const MORE_SKATE: f64 = 0.005;

/// The largest fraction of frames in which feet may be below the floor.
const MOST_BELOW: f64 = 0.01;

/// The largest difference of speed between feet that move alike, in m/s: rounding of keys.
const SAME_SKATE: f64 = 1e-4;

/// The largest difference of height between feet that move alike, in metres. It is not visible.
const SAME_HEIGHT: f64 = 1e-3;

/// The angle between the directions of a limb on two bodies.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LimbError {
    /// The bone.
    pub bone: Bone,
    /// The mean angle over all frames, in degrees.
    pub mean_degrees: f64,
    /// The largest angle of a frame, in degrees.
    pub max_degrees: f64,
    /// The tick of the largest angle.
    pub tick: f64,
}

/// The feet of one skeleton in a motion.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FootMotion {
    /// The mean sliding speed of feet in stance, in metres per second.
    pub skate: f64,
    /// The fraction of frames in which a joint of a foot, or a sole of the skin, is below the floor. Depths up to 1.2 %
    /// of the leg do not count: 1 cm on a person.
    pub fraction_below_floor: f64,
    /// The largest depth of a foot below the floor, in metres.
    pub deepest: f64,
    /// The length of thigh plus shin, in metres.
    #[serde(default)]
    pub leg: f64,
}

/// The feet of the source and of the target.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FeetReport {
    /// The number of frames in which the source stands on a foot, added for both feet.
    pub contact_frames: usize,
    /// The feet of the source.
    pub source: FootMotion,
    /// The feet of the target, in the same frames.
    pub target: FootMotion,
    /// The largest difference in metres between a foot joint of the source and the same joint of the target, in their
    /// heights above their levels in stance.
    pub height_difference: f64,
}

impl fmt::Display for FeetReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "feet on the ground slide {:.1} cm/s, {:.1} in the source; in {:.1} % of frames a foot is more than 1.2 % \
             of the leg length below the floor, {:.1} % in the source",
            100.0 * self.target.skate,
            100.0 * self.source.skate,
            100.0 * self.target.fraction_below_floor,
            100.0 * self.source.fraction_below_floor
        )
    }
}

/// The largest fraction of frames with a hand inside the body in a good motion. A hand that only brushes the body is
/// inside in fewer frames.
const OFTEN_INSIDE: f64 = 0.02;

/// The effect of a foot lock on the speed of feet. The lock is relaxed if it would make feet faster.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LockedFeet {
    /// The largest ratio of a foot's speed in a frame to its speed without the lock around this frame. By default it is
    /// at most 1.2.
    pub speed_ratio: f32,
    /// The largest ratio of a foot's acceleration in a frame to its acceleration without the lock around this frame. By
    /// default it is at most 1.5.
    pub acceleration_ratio: f32,
    /// The number of frames in which the lock of the left and of the right foot was relaxed.
    pub given_way: [usize; 2],
}

/// A leg that could not reach its goal.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ClampedLeg {
    /// The foot that missed its goal.
    pub bone: Bone,
    /// The number of frames in which the foot missed its goal.
    pub frames: usize,
    /// The largest distance of the foot from its goal, in metres.
    pub largest: f32,
    /// The reason, as one phrase.
    pub reason: String,
}

/// Whether a motion is good enough to use unchanged. The reports with a verdict document its thresholds.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Verdict {
    /// The motion is good enough.
    Good,
    /// Look at the motion before you use it.
    Fair,
    /// The motion is not good enough, or nothing could be compared.
    Poor,
}

impl Verdict {
    /// The name of the verdict in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Poor => "poor",
        }
    }
}

/// The joints of a creature that are matched with joints of another creature.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ByNames {
    /// The kind of creature, such as `four-legged`.
    pub creature: String,
    /// The number of joints of the target that follow a joint of the source.
    pub joints: usize,
    /// The joints of the source that the target lacks.
    pub lacking: Vec<String>,
    /// Whether joints are matched by the parts of the body: trunk, legs, neck, head and tail. Otherwise, they are
    /// matched by their names.
    #[serde(default)]
    pub by_parts: bool,
}

/// The quality of a motion that was retargeted to another skeleton.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RetargetReport {
    /// The name of the motion.
    pub clip: String,
    /// The number of compared frames.
    pub frames: usize,
    /// The scale of the target's root motion, in metres per metre of the source.
    pub scale: f64,
    /// The angles of arms and legs.
    pub limbs: Vec<LimbError>,
    /// The mean angle of all limbs and frames, in degrees.
    pub mean_degrees: f64,
    /// The largest angle of a limb in a frame, in degrees.
    pub max_degrees: f64,
    /// Roll, trunk, head and palms, the largest angle first.
    pub seen: Vec<AspectError>,
    /// Bones of the source whose roll is guessed, each with the reason.
    pub guessed: Vec<UnmappedBone>,
    /// The bones that are not retargeted, each with the reason.
    pub unmapped: Vec<UnmappedBone>,
    /// Legs that could not reach the goals of locked feet, each with the reason. Empty without a foot lock.
    pub clamped: Vec<ClampedLeg>,
    /// The feet; absent if one skeleton has no feet.
    pub feet: Option<FeetReport>,
    /// The speed of locked feet relative to free feet; absent without a foot lock.
    #[serde(default)]
    pub lock: Option<LockedFeet>,
    /// The contacts of the hands; absent without contacts, or if the hands are free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hands: Option<HandsReport>,
    /// The skin; absent if the target has no skin, or it was not read.
    #[serde(default)]
    pub skin: Option<SkinReport>,
    /// Joints of the target that follow a joint other than their parent, because the skin shows it: the name of the
    /// joint that each follows.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub followers: BTreeMap<String, String>,
    /// For creatures. If joints are matched by their names, the angles are of all bones. The verdict is then good for a
    /// mean angle up to 15 degrees, and fair up to 30. Otherwise, the angles are of the segments of the legs, and the
    /// limits are 5 and 10 degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_names: Option<ByNames>,
    /// Whether the motion is good enough to use unchanged. It is good if the mean angle of the limbs is within 1
    /// degree, and fair within 3. It is poor above 3 degrees, or if nothing could be compared. It is at best fair if
    /// the mean angle of a roll or a line of the trunk is above 15 degrees. For a head or a palm, the limit is 60
    /// degrees. A guessed roll of a bone also makes it at best fair. It is poor if a roll or a line is above 30
    /// degrees, or a head above 90. It is at best fair if the feet are below the floor in 20 % more of the frames than
    /// in the source. It is poor if the feet are below the floor in half of the frames, and deeper than 24 % of the
    /// leg. It is poor if the orientation of the whole body is guessed: its up axis or its left side is unknown, or the
    /// motion has fewer than 5 frames. The skin makes it at best fair if an edge is longer than at rest by 5 % of the
    /// height, and poor above 10 %. The limits of the skin's depth below the floor are 2 % and 6 % of the height. It is
    /// at best fair if a hand is inside the body in more than 2 % of the frames.
    pub verdict: Verdict,
}

impl RetargetReport {
    /// The report of a motion in which only the limbs are compared.
    pub(crate) fn of_limbs(clip: String, frames: usize, scale: f64, limbs: Vec<LimbError>) -> Self {
        let sum: f64 = limbs.iter().map(|limb| limb.mean_degrees).sum();
        Self {
            clip,
            frames,
            scale,
            mean_degrees: sum / limbs.len().max(1) as f64,
            max_degrees: limbs.iter().map(|limb| limb.max_degrees).fold(0.0, f64::max),
            limbs,
            seen: Vec::new(),
            guessed: Vec::new(),
            unmapped: Vec::new(),
            clamped: Vec::new(),
            feet: None,
            lock: None,
            hands: None,
            skin: None,
            followers: BTreeMap::new(),
            by_names: None,
            verdict: Verdict::Poor,
        }
    }
}

/// The angles of an aspect up to which a motion is good, and up to which it is fair, in degrees.
const fn limits(aspect: Aspect) -> (f64, f64) {
    match aspect {
        Aspect::Roll | Aspect::Trunk => (15.0, 30.0),
        Aspect::Head => (60.0, 90.0),
        Aspect::Palm => (60.0, f64::INFINITY),
    }
}

/// The fraction of frames with a foot below the floor up to which a motion is good, in addition to the fraction of the
/// source. Up to the second fraction, it is fair even if feet are deep.
const OFTEN_BELOW: (f64, f64) = (0.2, 0.5);

/// The depth below the floor above which a motion is poor, as a fraction of the leg: 20 cm, deeper than an ankle.
const DEEP_BELOW: f64 = 0.24;

/// The mean angles of limbs up to which a motion is good and fair, in degrees. Three degrees are visible next to the
/// source.
const OF_LIMBS: (f64, f64) = (1.0, 3.0);

/// The mean angles of all bones of creatures up to which a motion is good and fair, in degrees. Creatures of one kind
/// differ more than people.
const OF_CREATURES: (f64, f64) = (15.0, 30.0);

/// The mean angles of the legs of animals up to which a motion is good and fair, in degrees. Legs of other proportions
/// bend to keep paws on the ground.
const OF_ANIMALS: (f64, f64) = (5.0, 10.0);

/// The stretch of an edge of the skin up to which a motion is good and fair, as a fraction of the height. Intact rigs
/// have 0.01 to 0.04. Stretched skins that look like ribbons have 0.25 and more.
const OF_SKIN: (f64, f64) = (0.05, 0.1);

/// The depth of the skin below the floor up to which a motion is good and fair, as a fraction of the height. Walks,
/// runs and dances with locked feet are up to 0.01 deep on 18 of 24 rigs. 0.02 is 3.4 cm on a person.
const OF_FLOOR: (f64, f64) = (0.02, 0.06);

/// The verdict for one value, with its limits of good and fair.
fn graded(value: f64, (good, fair): (f64, f64)) -> Verdict {
    match value {
        value if value <= good => Verdict::Good,
        value if value <= fair => Verdict::Fair,
        _ => Verdict::Poor,
    }
}

/// The verdict on a motion: the worst verdict of all findings in its report.
pub(super) fn verdict(report: &RetargetReport) -> Verdict {
    let found = findings(report).into_iter().map(|(verdict, _)| verdict);
    found.max_by_key(|verdict| *verdict as u8).unwrap_or(Verdict::Good)
}

/// The defects of a motion, each with its own verdict.
fn findings(report: &RetargetReport) -> Vec<(Verdict, String)> {
    let is_by_names = report.by_names.as_ref().map(|names| !names.by_parts);
    let (what, bounds) = match is_by_names {
        Some(true) => ("bone", OF_CREATURES),
        Some(false) => ("limb", OF_ANIMALS),
        None => ("limb", OF_LIMBS),
    };
    let mean_degrees = report
        .hands
        .as_ref()
        .map_or(report.mean_degrees, |hands| hands.free_mean_degrees);
    let mut limbs = format!("mean {what} error {mean_degrees:.1} degrees");
    let worst = |a: &&LimbError, b: &&LimbError| a.mean_degrees.total_cmp(&b.mean_degrees);
    if let Some(worst) = report.limbs.iter().max_by(worst) {
        limbs += &format!(", {} {:.1}", worst.bone.as_str(), worst.mean_degrees);
    }
    let mut findings = vec![match report.limbs.is_empty() && is_by_names != Some(true) {
        true => (Verdict::Poor, "no limb of both bodies could be compared".to_owned()),
        false => (graded(mean_degrees, bounds), limbs),
    }];
    findings.extend(report.seen.iter().map(|seen| {
        let reason = format!("{seen}: mean error {:.1} degrees", seen.mean_degrees);
        (graded(seen.mean_degrees, limits(seen.aspect)), reason)
    }));
    findings.extend(report.guessed.iter().map(|guess| {
        let reason = format!("{} is guessed: {}", guess.bone.as_str(), guess.reason);
        (Verdict::Fair, reason)
    }));
    findings.extend(report.feet.map(|FeetReport { source, target, .. }| {
        let (depth, percent) = (100.0 * target.deepest, 100.0 * target.fraction_below_floor);
        let reason = format!("feet up to {depth:.1} cm below the floor, in {percent:.0} % of frames");
        let is_deep = target.fraction_below_floor > OFTEN_BELOW.1 && target.deepest > DEEP_BELOW * target.leg;
        let is_often = target.fraction_below_floor - source.fraction_below_floor > OFTEN_BELOW.0;
        let verdict = match (is_deep, is_often) {
            (true, _) => Verdict::Poor,
            (_, true) => Verdict::Fair,
            _ => Verdict::Good,
        };
        (verdict, reason)
    }));
    if let Some(skin) = &report.skin {
        let [one, other] = &skin.stretched_between;
        let percent = 100.0 * skin.largest_stretch;
        let reason = format!("the skin between {one} and {other} is stretched by {percent:.0} % of the height");
        findings.push((graded(skin.largest_stretch, OF_SKIN), reason));
        let reason = format!("the skin is up to {:.1} cm below the floor", 100.0 * skin.below_floor);
        findings.push((graded(skin.below_floor / skin.height, OF_FLOOR), reason));
        if let Some(joint) = &skin.uneven_joint
            && let Some(worst) = findings
                .iter()
                .map(|(verdict, _)| *verdict)
                .max_by_key(|verdict| *verdict as u8)
        {
            let reason =
                format!("the scale of {joint} at rest is mirrored or uneven, so that rotations shear the skin");
            findings.push((worst, reason));
        }
        let percent = 100.0 * skin.hands_inside;
        let reason = format!("a hand is inside the body in {percent:.0} % of frames");
        findings.extend((skin.hands_inside > OFTEN_INSIDE).then_some((Verdict::Fair, reason)));
    }
    findings.retain(|(verdict, _)| *verdict != Verdict::Good);
    findings
}

impl RetargetReport {
    /// The reasons why the verdict is not good, the worst first.
    pub(crate) fn reasons(&self) -> Vec<String> {
        let mut findings = findings(self);
        // This reason applies whatever the measurements are.
        if self.verdict == Verdict::Poor && verdict(self) != Verdict::Poor {
            let reason = "the orientation of the whole body is guessed: its up axis or its left side is unknown, or the \
                          motion has fewer than 5 frames";
            findings.push((Verdict::Poor, reason.to_owned()));
        }
        findings.sort_by_key(|(verdict, _)| std::cmp::Reverse(*verdict as u8));
        findings.into_iter().map(|(_, reason)| reason).collect()
    }

    /// Adds the contacts of hands. The limbs are judged by `free`, the report without the contacts.
    pub(crate) fn keep_hands(&mut self, hands: HandsReport, free: &Self) {
        self.hands = Some(HandsReport {
            free_mean_degrees: free.mean_degrees,
            ..hands
        });
        if free.verdict != Verdict::Poor || verdict(free) == Verdict::Poor {
            self.verdict = verdict(self);
        }
    }

    /// Removes the legs and the feet from the report, for a target without legs.
    pub(crate) fn leave_out_legs(&mut self) {
        self.limbs.retain(|limb| !limb.bone.is_of_leg());
        let means = self.limbs.iter().map(|limb| limb.mean_degrees);
        self.mean_degrees = means.sum::<f64>() / self.limbs.len().max(1) as f64;
        self.max_degrees = self.limbs.iter().map(|limb| limb.max_degrees).fold(0.0, f64::max);
        self.feet = None;
    }

    /// The report of a motion with locked feet, with the goals that the legs could not reach.
    #[must_use]
    pub fn with_lock(mut self, lock: &FootLockReport) -> Self {
        let feet = [Bone::LeftFoot, Bone::RightFoot].into_iter().enumerate();
        let clamped = feet.map(|(side, bone)| ClampedLeg {
            bone,
            frames: lock.out_of_reach[side],
            largest: lock.farthest_out_of_reach[side],
            reason: "the leg is too short to reach the goal of the foot".to_owned(),
        });
        self.clamped = clamped.filter(|clamped| clamped.frames > 0).collect();
        self.lock = Some(LockedFeet {
            speed_ratio: lock.speed_ratio,
            acceleration_ratio: lock.acceleration_ratio,
            given_way: lock.given_way,
        });
        self
    }

    /// The worst angle in degrees. Compares the largest angle of a limb in a frame, and the mean angle of each roll,
    /// line of the trunk and palm.
    pub fn worst_degrees(&self) -> f64 {
        // The direction of a head is no difference, because people look aside.
        let differences = self.seen.iter().filter(|seen| seen.aspect != Aspect::Head);
        differences
            .map(|seen| seen.mean_degrees)
            .fold(self.max_degrees, f64::max)
    }

    /// The part with a larger angle than `allowed` degrees, as a sentence; `None` if there is none.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::retarget::{Retargeter, RetargetOptions};
    ///
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let target = mocap::import("fixtures/skeletons/human_default.gltf")?;
    /// let retargeting = Retargeter::new(walk, target, RetargetOptions::new())?;
    /// let report = retargeting.clips()[0].report.body().unwrap();
    /// assert_eq!(report.problem(180.0), None);
    /// assert!(report.problem(0.0).unwrap().ends_with("but at most 0 are allowed"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn problem(&self, allowed: f64) -> Option<String> {
        let angle = self.worst_degrees();
        let limb = self.limbs.iter().find(|limb| limb.max_degrees == angle);
        let seen = self.seen.iter().find(|seen| seen.mean_degrees == angle);
        let what = match (limb, seen) {
            (Some(limb), _) => format!(
                "{} has an error of {angle:.2} degrees at tick {}",
                limb.bone.as_str(),
                limb.tick
            ),
            (None, Some(seen)) => format!("the {seen} has a mean error of {angle:.2} degrees"),
            (None, None) => format!("a limb has an error of {angle:.2} degrees"),
        };
        (angle > allowed).then(|| format!("{}: {what}, but at most {allowed} are allowed", self.clip))
    }

    /// Whether a motion with locked feet is better than `free`, the motion without the lock. With the lock, feet slide
    /// less or are above the floor more often, and neither measure is much worse. The verdict is not poor, unless the
    /// verdict without the lock is also poor.
    pub fn is_better_locked_than(&self, free: &Self) -> bool {
        let Some((locked, free_feet)) = self.feet.zip(free.feet) else {
            return false;
        };
        let (locked, before) = (locked.target, free_feet.target);
        let less_skate = before.skate - locked.skate;
        let less_below = before.fraction_below_floor - locked.fraction_below_floor;
        (self.verdict != Verdict::Poor || free.verdict == Verdict::Poor)
            && less_skate > -MORE_SKATE
            && less_below > -MOST_BELOW
            && (less_skate > 0.0 || less_below > 0.0)
    }

    /// Whether feet in stance slide more on the target than on the source, or are often below its floor. If the feet
    /// move like the source's feet, on a body of the same size, the answer is no.
    pub fn slides(&self) -> bool {
        self.feet.is_some_and(|FeetReport { source, target, .. }| {
            let is_below = target.fraction_below_floor > MOST_BELOW;
            !self.feet_move_alike() && (is_below || target.skate > source.skate + MORE_SKATE)
        })
    }

    /// Whether the feet move like the source's feet, as on a body of the same size.
    pub fn feet_move_alike(&self) -> bool {
        self.feet.is_some_and(|feet| {
            (feet.source.skate - feet.target.skate).abs() < SAME_SKATE && feet.height_difference < SAME_HEIGHT
        })
    }
}
