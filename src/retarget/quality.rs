//! The report of a motion on another skeleton.

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

/// The largest increase of the sliding speed of the feet of the target against the source, in metres a second.
const MORE_SKATE: f64 = 0.005;

/// The fraction of frames in which they may be below the floor.
const MOST_BELOW: f64 = 0.01;

/// The largest difference of speed in m/s between feet that move alike: rounding of keys.
const SAME_SKATE: f64 = 1e-4;

/// The largest difference of height in metres between feet that move alike: it is not seen.
const SAME_HEIGHT: f64 = 1e-3;

/// How far the directions of a limb are apart on two bodies.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LimbError {
    /// The bone.
    pub bone: Bone,
    /// The mean of all frames, in degrees.
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
    /// The mean speed over the ground of feet that stand, in metres a second.
    pub skate: f64,
    /// The fraction of frames in which a joint of a foot, or a sole of the skin, is below the floor. Depths up to 1.2 %
    /// of the leg do not count: 1 cm on a person.
    pub fraction_below_floor: f64,
    /// How far below the floor one of them is at most, in metres.
    pub deepest: f64,
    /// Thigh and shin, in metres.
    #[serde(default)]
    pub leg: f64,
}

/// The feet before and after.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FeetReport {
    /// Frames in which the source stands on a foot, added for both feet.
    pub contact_frames: usize,
    /// The feet of the source.
    pub source: FootMotion,
    /// The feet of the target, at the same frames.
    pub target: FootMotion,
    /// The largest difference between heights of a joint of the feet over its level in stance, in metres.
    pub height_difference: f64,
}

impl fmt::Display for FeetReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "feet on the ground slide {:.1} cm/s, {:.1} in the source; in {:.1} % of frames one is more than 1.2 % \
             of the leg below the floor, {:.1} % in the source",
            100.0 * self.target.skate,
            100.0 * self.source.skate,
            100.0 * self.target.fraction_below_floor,
            100.0 * self.source.fraction_below_floor
        )
    }
}

/// The fraction of frames with a hand inside the body up to which a motion may be good: less is a hand that brushes by.
const OFTEN_INSIDE: f64 = 0.02;

/// The effect of a lock on the speed of feet. The lock gives way if it would make them faster.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct LockedFeet {
    /// The largest ratio of the speed of a foot to its speed without the lock around that moment: at most 1.2.
    pub speed_ratio: f32,
    /// The largest ratio of accelerations likewise: at most 1.5.
    pub acceleration_ratio: f32,
    /// The frames in which the left and the right foot give way to the motion without the lock.
    pub given_way: [usize; 2],
}

/// A leg that could not do what was asked of it.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ClampedLeg {
    /// The foot that is elsewhere.
    pub bone: Bone,
    /// The frames in which it is.
    pub frames: usize,
    /// How far it is from where it belongs at most, in metres.
    pub largest: f32,
    /// Why, as one phrase.
    pub reason: String,
}

/// Whether a motion is good enough to use unchanged. The reports that have it say how it is found.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Verdict {
    /// It is.
    Good,
    /// It should be looked at first.
    Fair,
    /// It is not, or nothing could be compared.
    Poor,
}

impl Verdict {
    /// Its name in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Poor => "poor",
        }
    }
}

/// How a motion went by the names of joints.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ByNames {
    /// The kind of creature, such as `four-legged`.
    pub creature: String,
    /// The joints of the target that have the name of one in the source.
    pub joints: usize,
    /// The joints of the source that the target lacks.
    pub lacking: Vec<String>,
}

/// How well a motion sits on another skeleton.
///
/// [`PoseRetargeter`](crate::PoseRetargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RetargetReport {
    /// The name of the motion.
    pub clip: String,
    /// Frames compared.
    pub frames: usize,
    /// How many times as long the steps of the target are, both in metres.
    pub scale: f64,
    /// Arms and legs.
    pub limbs: Vec<LimbError>,
    /// The mean of all limbs and frames, in degrees.
    pub mean_degrees: f64,
    /// The largest angle of a limb in a frame, in degrees.
    pub max_degrees: f64,
    /// Roll, trunk, head and palms, the farthest off first.
    pub seen: Vec<AspectError>,
    /// Bones of the source whose roll nothing shows, and the roll that they get.
    pub guessed: Vec<UnmappedBone>,
    /// What is not moved, and why.
    pub unmapped: Vec<UnmappedBone>,
    /// What a leg could not reach, and why: with locked feet alone.
    pub clamped: Vec<ClampedLeg>,
    /// The feet; absent where one skeleton has none.
    pub feet: Option<FeetReport>,
    /// How fast they are beside free ones; absent where they are not locked.
    #[serde(default)]
    pub lock: Option<LockedFeet>,
    /// What the hands touch; absent where they touch nothing, or are free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hands: Option<HandsReport>,
    /// The skin; absent where the target has none that is read.
    #[serde(default)]
    pub skin: Option<SkinReport>,
    /// Joints of the target that follow another joint than their parent, because the skin shows it: the joint that each
    /// follows, by their names.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub followers: BTreeMap<String, String>,
    /// For creatures, which are matched by the names of their joints. The angles are those of all bones. The verdict is
    /// good up to 15 degrees in the mean, and fair up to 30.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_names: Option<ByNames>,
    /// Whether the motion is good enough to use unchanged. It is good if the limbs are within 1 degree in the mean, and
    /// fair within 3. It is poor if they are farther off or nothing could be compared. It is at best fair if a roll or
    /// a line of the trunk is more than 15 degrees off, or a head or a palm more than 60. A guessed roll of a bone
    /// makes it at best fair too. It is poor if a roll or a line is more than 30 degrees off, or a head more than 90.
    /// It is at best fair if the feet are below the floor in 20 % more of the frames than in the source. It is poor if
    /// they are so in half of the frames, and deeper than 24 % of the leg. It is poor if the orientation of the whole
    /// body is guessed: up, left, or all of it from less than 5 frames. The skin makes it at best fair if an edge is
    /// longer than at rest by 5 % of the height. So does a skin that is 2 % of the height below the floor. Above 10 %
    /// and 6 % it is poor.
    pub verdict: Verdict,
}

impl RetargetReport {
    /// The report of a motion of which the limbs alone are compared.
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

/// The angles of an aspect above which a motion is no more than fair, and above which it is poor, in degrees.
const fn limits(aspect: Aspect) -> (f64, f64) {
    match aspect {
        Aspect::Roll | Aspect::Trunk => (15.0, 30.0),
        Aspect::Head => (60.0, 90.0),
        Aspect::Palm => (60.0, f64::INFINITY),
    }
}

/// The fraction of frames with a foot below the floor up to which a motion is good, beyond that of the source. Up to
/// the second one it is fair although feet are deep.
const OFTEN_BELOW: (f64, f64) = (0.2, 0.5);

/// The depth below the floor above which a motion is poor, as a fraction of the leg: deeper than an ankle, 20 cm.
const DEEP_BELOW: f64 = 0.24;

/// The mean angles in degrees of limbs up to which a motion is good and fair: three are seen beside the source.
const OF_LIMBS: (f64, f64) = (1.0, 3.0);

/// The same of all bones of creatures, in degrees: creatures of one kind are built so differently.
const OF_CREATURES: (f64, f64) = (15.0, 30.0);

/// The stretch of an edge of the skin up to which a motion is good and fair, as a fraction of the height. Intact rigs
/// have 0.01 to 0.04, ribbons 0.25 and more.
const OF_SKIN: (f64, f64) = (0.05, 0.1);

/// The depth of the skin below the floor up to which a motion is good and fair, as a fraction of the height. Walks,
/// runs and dances with locked feet are up to 0.01 deep on 18 of 24 rigs. 0.02 is 3.4 cm on a person.
const OF_FLOOR: (f64, f64) = (0.02, 0.06);

/// The verdict by one value, with its bounds of good and fair.
fn graded(value: f64, (good, fair): (f64, f64)) -> Verdict {
    match value {
        value if value <= good => Verdict::Good,
        value if value <= fair => Verdict::Fair,
        _ => Verdict::Poor,
    }
}

/// What a motion is good for by its limbs, in degrees in the mean, and by all else in its report.
pub(super) fn verdict(report: &RetargetReport) -> Verdict {
    let found = findings(report).into_iter().map(|(verdict, _)| verdict);
    found.max_by_key(|verdict| *verdict as u8).unwrap_or(Verdict::Good)
}

/// What of a motion is not good, each with its own verdict.
fn findings(report: &RetargetReport) -> Vec<(Verdict, String)> {
    let (what, bounds) = match report.by_names {
        Some(_) => ("bones", OF_CREATURES),
        None => ("limbs", OF_LIMBS),
    };
    let mean_degrees = report
        .hands
        .as_ref()
        .map_or(report.mean_degrees, |hands| hands.free_mean_degrees);
    let mut limbs = format!("{what} {mean_degrees:.1} degrees off in the mean");
    let worst = |a: &&LimbError, b: &&LimbError| a.mean_degrees.total_cmp(&b.mean_degrees);
    if let Some(worst) = report.limbs.iter().max_by(worst) {
        limbs += &format!(", {} {:.1}", worst.bone.as_str(), worst.mean_degrees);
    }
    let mut findings = vec![match report.limbs.is_empty() && report.by_names.is_none() {
        true => (Verdict::Poor, "no limb of both bodies could be compared".to_owned()),
        false => (graded(mean_degrees, bounds), limbs),
    }];
    findings.extend(report.seen.iter().map(|seen| {
        let reason = format!("{seen} {:.1} degrees off in the mean", seen.mean_degrees);
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
    /// Why the verdict is not good, the worst first.
    pub(crate) fn reasons(&self) -> Vec<String> {
        let mut findings = findings(self);
        // Whatever is measured on such a body.
        if self.verdict == Verdict::Poor && verdict(self) != Verdict::Poor {
            let reason = "how the body is turned as a whole is guessed: up, left, or all of it from few frames";
            findings.push((Verdict::Poor, reason.to_owned()));
        }
        findings.sort_by_key(|(verdict, _)| std::cmp::Reverse(*verdict as u8));
        findings.into_iter().map(|(_, reason)| reason).collect()
    }

    /// Adds what hands touch, and judges the limbs by `free`, the report without it.
    pub(crate) fn keep_hands(&mut self, hands: HandsReport, free: &Self) {
        self.hands = Some(HandsReport {
            free_mean_degrees: free.mean_degrees,
            ..hands
        });
        if free.verdict != Verdict::Poor || verdict(free) == Verdict::Poor {
            self.verdict = verdict(self);
        }
    }

    /// Of arms alone, for a target without legs.
    pub(crate) fn leave_out_legs(&mut self) {
        self.limbs.retain(|limb| !limb.bone.is_of_leg());
        let means = self.limbs.iter().map(|limb| limb.mean_degrees);
        self.mean_degrees = means.sum::<f64>() / self.limbs.len().max(1) as f64;
        self.max_degrees = self.limbs.iter().map(|limb| limb.max_degrees).fold(0.0, f64::max);
        self.feet = None;
    }

    /// The report of a motion with locked feet, with the goals that its legs could not reach.
    #[must_use]
    pub fn with_lock(mut self, lock: &FootLockReport) -> Self {
        let feet = [Bone::LeftFoot, Bone::RightFoot].into_iter().enumerate();
        let clamped = feet.map(|(side, bone)| ClampedLeg {
            bone,
            frames: lock.out_of_reach[side],
            largest: lock.farthest_out_of_reach[side],
            reason: "the leg is too short to reach where the foot belongs".to_owned(),
        });
        self.clamped = clamped.filter(|clamped| clamped.frames > 0).collect();
        self.lock = Some(LockedFeet {
            speed_ratio: lock.speed_ratio,
            acceleration_ratio: lock.acceleration_ratio,
            given_way: lock.given_way,
        });
        self
    }

    /// The worst angle of all: the largest of a limb in a frame, and the mean of each roll, line of the trunk and
    /// palm.
    pub fn worst_degrees(&self) -> f64 {
        // Where a head looks is no difference: people do look aside.
        let differences = self.seen.iter().filter(|seen| seen.aspect != Aspect::Head);
        differences
            .map(|seen| seen.mean_degrees)
            .fold(self.max_degrees, f64::max)
    }

    /// What is farther off than `allowed` degrees, as a sentence; `None` where nothing is.
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
    /// assert!(report.problem(0.0).unwrap().ends_with("and 0 are allowed"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn problem(&self, allowed: f64) -> Option<String> {
        let angle = self.worst_degrees();
        let limb = self.limbs.iter().find(|limb| limb.max_degrees == angle);
        let seen = self.seen.iter().find(|seen| seen.mean_degrees == angle);
        let what = match (limb, seen) {
            (Some(limb), _) => format!("{} is {angle:.2} degrees off at tick {}", limb.bone.as_str(), limb.tick),
            (None, Some(seen)) => format!("the {seen} is {angle:.2} degrees off in the mean"),
            (None, None) => format!("a limb is {angle:.2} degrees off"),
        };
        (angle > allowed).then(|| format!("{}: {what}, and {allowed} are allowed", self.clip))
    }

    /// Whether a motion with locked feet is better than `free`, the motion without the lock. Its feet slide less or are
    /// above the floor more often, and neither is much worse. Its limbs still have their directions, unless the motion
    /// without the lock is poor too.
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

    /// Whether feet that stand slide more on the target than on the source, or are often below its floor. Feet that
    /// move as the source's feet, on a body of the same size, are not changed.
    pub fn slides(&self) -> bool {
        self.feet.is_some_and(|FeetReport { source, target, .. }| {
            let is_below = target.fraction_below_floor > MOST_BELOW;
            !self.feet_move_alike() && (is_below || target.skate > source.skate + MORE_SKATE)
        })
    }

    /// Whether the feet move as the source's feet, as on a body of the same size.
    pub fn feet_move_alike(&self) -> bool {
        self.feet.is_some_and(|feet| {
            (feet.source.skate - feet.target.skate).abs() < SAME_SKATE && feet.height_difference < SAME_HEIGHT
        })
    }
}
