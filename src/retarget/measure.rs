//! How well a motion sits on another skeleton, measured on the poses of both.

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

use super::feet::Soles;
use super::plan::Unmapped;
use super::root::Root;
use super::sight::{Aspect, Seen, Sight};
use crate::edit::{FootLockReport, contacts_of};
use crate::figure::HumanoidBone as Bone;
use crate::figure::body::Body;
use crate::figure::t_pose::limb_end;
use crate::pose::{Binding, Pose};
use crate::scene::{Animation, NodeId, Scene};

/// The depth below the floor that counts, in metres.
const BELOW: f32 = 0.01;

/// How much faster the feet of the target may slide than those of the source, in metres a second.
const MORE_SKATE: f64 = 0.005;

/// The fraction of frames in which they may be below the floor.
const MOST_BELOW: f64 = 0.01;

/// The largest differences between feet that move alike, in metres a second and in metres.
const SAME_SKATE: f64 = 1e-4;
const SAME_HEIGHT: f64 = 1e-3;

/// How far the directions of a limb are apart on two bodies.
///
/// [`Retargeter`](crate::retarget::Retargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
/// [`Retargeter`](crate::retarget::Retargeter) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FootMotion {
    /// The mean speed over the ground of feet that stand, in metres a second.
    pub skate: f64,
    /// The fraction of frames in which a joint of a foot, or a sole of the skin, is more than 1 cm below the floor.
    pub share_below_floor: f64,
    /// How far below the floor one of them is at most, in metres.
    pub deepest: f64,
}

/// The feet before and after.
///
/// [`Retargeter`](crate::retarget::Retargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FeetReport {
    /// Frames in which the source stands on a foot, those of both feet together.
    pub contact_frames: usize,
    /// The feet of the source.
    pub source: FootMotion,
    /// The feet of the target, at the same frames.
    pub target: FootMotion,
    /// The largest difference between heights of a joint of the feet over where it stands, in metres.
    pub height_difference: f64,
}

/// A leg that could not do what was asked of it.
///
/// [`Retargeter`](crate::retarget::Retargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Clamped {
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
/// [`Retargeter`](crate::retarget::Retargeter) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
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

/// How well a motion sits on another skeleton.
///
/// [`Retargeter`](crate::retarget::Retargeter) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    pub seen: Vec<Seen>,
    /// Bones of the source of which nothing says how they are turned about themselves, and how they are turned.
    pub guessed: Vec<Unmapped>,
    /// What is not moved, and why.
    pub unmapped: Vec<Unmapped>,
    /// What a leg could not reach, and why: with locked feet alone.
    pub clamped: Vec<Clamped>,
    /// The feet; absent where one skeleton has none.
    pub feet: Option<FeetReport>,
    /// Whether the motion is good enough to use unchanged: good where the limbs are within 1 degree in the mean, fair
    /// within 3, poor where they are farther off or nothing could be compared. No more than fair where a roll or a
    /// line of the trunk is more than 15 degrees off, a head or a palm more than 60, or how a thigh or an upper arm
    /// is turned about itself is guessed; poor where a roll or a line is more than 30 off, a head more than 90, or
    /// the feet are below the floor in more than half of the frames and deeper than 20 cm.
    pub verdict: Verdict,
}

/// The angles of an aspect above which a motion is no more than fair, and above which it is poor, in degrees.
const fn limits(aspect: Aspect) -> (f64, f64) {
    match aspect {
        Aspect::Roll | Aspect::Trunk => (15.0, 30.0),
        Aspect::Head => (60.0, 90.0),
        Aspect::Palm => (60.0, f64::INFINITY),
    }
}

/// The fraction of frames with a foot below the floor, and how deep, in metres, above which a motion is poor.
const OFTEN_BELOW: f64 = 0.5;
const DEEP_BELOW: f64 = 0.2;

/// What a motion is good for by its limbs, in degrees in the mean, and by all else in its report.
fn verdict(report: &RetargetReport) -> Verdict {
    let by_limbs = match report.mean_degrees {
        _ if report.limbs.is_empty() => Verdict::Poor,
        mean if mean <= 1.0 => Verdict::Good,
        mean if mean <= 3.0 => Verdict::Fair,
        _ => Verdict::Poor,
    };
    let by_sight = report.seen.iter().map(|seen| match limits(seen.aspect) {
        (_, poor) if seen.mean_degrees > poor => Verdict::Poor,
        (fair, _) if seen.mean_degrees > fair => Verdict::Fair,
        _ => Verdict::Good,
    });
    let by_guess = if report.guessed.is_empty() {
        Verdict::Good
    } else {
        Verdict::Fair
    };
    let is_below = |feet: FootMotion| feet.share_below_floor > OFTEN_BELOW && feet.deepest > DEEP_BELOW;
    let by_floor = match report.feet {
        Some(feet) if is_below(feet.target) => Verdict::Poor,
        _ => Verdict::Good,
    };
    let all = by_sight.chain([by_limbs, by_guess, by_floor]);
    all.max_by_key(|verdict| *verdict as u8).unwrap_or(Verdict::Poor)
}

impl RetargetReport {
    /// The report of a motion whose feet were locked, with what its legs could not reach.
    #[must_use]
    pub fn with_lock(mut self, lock: &FootLockReport) -> Self {
        let feet = [Bone::LeftFoot, Bone::RightFoot].into_iter().enumerate();
        let clamped = feet.map(|(side, bone)| Clamped {
            bone,
            frames: lock.out_of_reach[side],
            largest: lock.farthest_out_of_reach[side],
            reason: "the leg is too short to reach where the foot belongs".to_owned(),
        });
        self.clamped = clamped.filter(|clamped| clamped.frames > 0).collect();
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
    /// use mocap::retargeting::{Retargeting, RetargetingOptions};
    ///
    /// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let target = mocap::import("fixtures/skeletons/human_default.gltf")?;
    /// let retargeting = Retargeting::new(walk, target, RetargetingOptions::new())?;
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

    /// Whether a motion with locked feet is better than `free`, the same without: its feet slide less or are above the
    /// floor more often, neither much worse, and its limbs still point where they should.
    pub fn is_better_locked_than(&self, free: &Self) -> bool {
        let Some((locked, free_feet)) = self.feet.zip(free.feet) else {
            return false;
        };
        let (locked, before) = (locked.target, free_feet.target);
        let less_skate = before.skate - locked.skate;
        let less_below = before.share_below_floor - locked.share_below_floor;
        self.verdict != Verdict::Poor
            && less_skate > -MORE_SKATE
            && less_below > -MOST_BELOW
            && (less_skate > 0.0 || less_below > 0.0)
    }

    /// Whether feet that stand slide more on the target than on the source, or are often below its floor. Feet that do
    /// what those of the source do, on a body of the same size, are left as they are.
    pub fn slides(&self) -> bool {
        self.feet.is_some_and(|FeetReport { source, target, .. }| {
            let is_below = target.share_below_floor > MOST_BELOW;
            !self.feet_move_alike() && (is_below || target.skate > source.skate + MORE_SKATE)
        })
    }

    /// Whether the feet do what those of the source do, as on a body of the same size.
    pub fn feet_move_alike(&self) -> bool {
        self.feet.is_some_and(|feet| {
            (feet.source.skate - feet.target.skate).abs() < SAME_SKATE && feet.height_difference < SAME_HEIGHT
        })
    }
}

/// A skeleton with a motion.
pub(super) struct Moving<'a> {
    pub(super) body: &'a Body,
    pub(super) scene: &'a Scene,
    pub(super) animation: &'a Animation,
}

/// What is measured of a skeleton, frame by frame.
pub(super) struct Track {
    /// The directions of the limbs that it has, in the axes of the figure.
    limbs: Vec<(Bone, Vec<Vec3>)>,
    /// The joints of both feet in metres in the axes of the figure; +Y is up.
    feet: Vec<(Bone, Vec<Vec3>)>,
    /// How high the lowest point of the soles is over where it stands, in metres; infinite without a skin.
    soles: Vec<f32>,
}

/// The joints of a foot that are looked at.
const FOOT: [Bone; 4] = [Bone::LeftFoot, Bone::LeftToes, Bone::RightFoot, Bone::RightToes];

impl Moving<'_> {
    /// With the `soles` of the skin, where these are looked at.
    pub(super) fn track(&self, ticks: &[f64], soles: Option<&Soles>) -> Track {
        let limb = |bone: Bone| {
            let ends = self
                .body
                .joint(bone)
                .zip(limb_end(bone).and_then(|end| self.body.joint(end)));
            Some((bone, ends?))
        };
        let ends: Vec<(Bone, (NodeId, NodeId))> = Bone::ALL.iter().copied().filter_map(limb).collect();
        let joints = FOOT
            .into_iter()
            .filter_map(|bone| Some((bone, self.body.foot_joint(bone)?)));
        let joints: Vec<(Bone, NodeId)> = joints.collect();
        let of_bone = |bone: &Bone| (*bone, Vec::with_capacity(ticks.len()));
        let mut track = Track {
            limbs: ends.iter().map(|(bone, _)| of_bone(bone)).collect(),
            feet: joints.iter().map(|(bone, _)| of_bone(bone)).collect(),
            soles: Vec::with_capacity(ticks.len()),
        };
        let world_to_frame: Quat = self.body.axes.inverse();
        let metres = self.body.metres_per_unit as f32;
        let binding = Binding::new(self.scene, self.animation);
        let mut pose = Pose::rest(self.scene);
        for &tick in ticks {
            pose.sample(&binding, self.animation, tick);
            for ((_, directions), (_, (from, to))) in track.limbs.iter_mut().zip(&ends) {
                let way = pose.position(*to) - pose.position(*from);
                directions.push((world_to_frame * way).normalize_or_zero());
            }
            for ((_, places), (_, joint)) in track.feet.iter_mut().zip(&joints) {
                places.push(metres * (world_to_frame * pose.position(*joint)));
            }
            track
                .soles
                .push(soles.map_or(f32::INFINITY, |soles| metres * soles.lowest(&pose)));
        }
        track
    }
}

/// The angle of each limb that both have, in degrees, at each tick.
pub(super) fn angles(was: &Track, is: &Track) -> Vec<(Bone, Vec<f32>)> {
    let limbs = was.limbs.iter().filter_map(|(bone, was)| {
        let (_, is) = is.limbs.iter().find(|(other, _)| other == bone)?;
        let angle = |(was, is): (&Vec3, &Vec3)| was.cross(*is).length().atan2(was.dot(*is)).to_degrees();
        Some((*bone, was.iter().zip(is).map(angle).collect()))
    });
    limbs.collect()
}

/// Compares two motions at the same ticks.
pub(super) fn measure(
    source: &Moving<'_>,
    target: &Moving<'_>,
    ticks: &[f64],
    scale: f64,
    root: &Root,
    unmapped: &[Unmapped],
) -> RetargetReport {
    let soles = Soles::new(target.body, target.scene, root.target_ankle);
    let (was, is) = (source.track(ticks, None), target.track(ticks, Some(&soles)));
    let mut limbs = Vec::new();
    let (mut sum, mut count) = (0.0, 0);
    for (bone, angles) in angles(&was, &is) {
        let mut limb = LimbError {
            bone,
            mean_degrees: 0.0,
            max_degrees: 0.0,
            tick: 0.0,
        };
        for (angle, &tick) in angles.into_iter().map(f64::from).zip(ticks) {
            limb.mean_degrees += angle;
            if angle > limb.max_degrees {
                (limb.max_degrees, limb.tick) = (angle, tick);
            }
        }
        sum += limb.mean_degrees;
        count += ticks.len();
        limb.mean_degrees /= ticks.len().max(1) as f64;
        limbs.push(limb);
    }
    let mean_degrees = sum / count.max(1) as f64;
    let mut report = RetargetReport {
        clip: target.animation.name.clone(),
        frames: ticks.len(),
        scale,
        max_degrees: limbs.iter().map(|limb| limb.max_degrees).fold(0.0, f64::max),
        verdict: Verdict::Poor,
        seen: sight(source, target, ticks),
        guessed: guessed(source.body),
        limbs,
        mean_degrees,
        unmapped: unmapped.to_vec(),
        clamped: Vec::new(),
        feet: feet(source, target, (&was, &is), ticks, root),
    };
    report.verdict = verdict(&report);
    report
}

/// The most frames at which both bodies are looked at.
const LOOKS: usize = 400;

fn sight(source: &Moving<'_>, target: &Moving<'_>, ticks: &[f64]) -> Vec<Seen> {
    let mut sight = Sight::new(source.body, target.body);
    let bindings = [source, target].map(|moving| Binding::new(moving.scene, moving.animation));
    let (mut was, mut is) = (Pose::rest(source.scene), Pose::rest(target.scene));
    for &tick in ticks.iter().step_by(ticks.len().div_ceil(LOOKS).max(1)) {
        was.sample(&bindings[0], source.animation, tick);
        is.sample(&bindings[1], target.animation, tick);
        sight.look(&was, &is, tick);
    }
    sight.found(ticks.first().copied().unwrap_or_default())
}

fn guessed(body: &Body) -> Vec<Unmapped> {
    let guess = |(bone, reason): (Bone, &str)| Unmapped {
        bone,
        reason: format!("turned about itself {reason}: the motion does not bend it"),
    };
    body.guessed().into_iter().map(guess).collect()
}

/// What the feet do in the frames in which [`contacts`](crate::edit::contacts()) finds those of the source at rest. Of
/// the joints of a foot that rest, the slowest counts: it may roll over heel or toes.
fn feet(
    source: &Moving<'_>,
    target: &Moving<'_>,
    (was, is): (&Track, &Track),
    ticks: &[f64],
    root: &Root,
) -> Option<FeetReport> {
    let has_feet = |body: &Body| body.joint(Bone::LeftFoot).is_some() && body.joint(Bone::RightFoot).is_some();
    if !(has_feet(source.body) && has_feet(target.body)) {
        return None;
    }
    let contacts = contacts_of(source.scene, source.animation, &source.body.figure).ok()?;
    let per_second = source.animation.ticks_per_second as f32;
    let speed = |places: &[Vec3], frame: usize| {
        let step = ticks[frame + 1] - ticks[frame];
        let way = places[frame + 1] - places[frame];
        Vec3::new(way.x, 0.0, way.z).length() * per_second / step as f32
    };
    let (mut contact_frames, mut before, mut after) = (0, 0.0, 0.0);
    let frames = ticks.len().min(contacts.frames).saturating_sub(1);
    for side in [&FOOT[..2], &FOOT[2..]] {
        let joints = side.iter().filter_map(|bone| {
            let places = |track: &'_ Track| track.feet.iter().position(|(other, _)| other == bone);
            Some((&contacts.point(*bone)?.at_rest, places(was)?, places(is)?))
        });
        let joints: Vec<_> = joints.collect();
        for frame in 0..frames {
            let rests = joints
                .iter()
                .filter(|(at_rest, _, _)| at_rest[frame] && at_rest[frame + 1]);
            let speeds = rests.map(|(_, from, to)| (speed(&was.feet[*from].1, frame), speed(&is.feet[*to].1, frame)));
            if let Some((source, target)) = speeds.min_by(|a, b| a.0.total_cmp(&b.0)) {
                contact_frames += 1;
                before += f64::from(source);
                after += f64::from(target);
            }
        }
    }
    let above_standing = |moving: &Moving<'_>, ankle: f32, bone: Bone, place: Vec3| {
        place.y - moving.body.metres_per_unit as f32 * moving.body.standing_height(bone, ankle)
    };
    let mut height_difference = 0.0_f32;
    for (bone, was) in &was.feet {
        let Some((_, is)) = is.feet.iter().find(|(other, _)| other == bone) else {
            continue;
        };
        for (was, is) in was.iter().zip(is) {
            let was = above_standing(source, root.source_ankle, *bone, *was);
            let is = above_standing(target, root.target_ankle, *bone, *is);
            height_difference = height_difference.max((was - is).abs());
        }
    }
    let motion = |moving: &Moving<'_>, track: &Track, ankle: f32, speeds: f64| {
        let lowest = |frame: usize| {
            let heights = track
                .feet
                .iter()
                .map(|(bone, places)| above_standing(moving, ankle, *bone, places[frame]));
            heights.fold(track.soles[frame], f32::min)
        };
        let below = (0..ticks.len()).filter(|frame| lowest(*frame) < -BELOW).count();
        let deepest = (0..ticks.len()).map(lowest).fold(0.0, f32::min);
        FootMotion {
            skate: speeds / contact_frames.max(1) as f64,
            share_below_floor: below as f64 / ticks.len().max(1) as f64,
            deepest: f64::from(-deepest),
        }
    };
    Some(FeetReport {
        contact_frames,
        source: motion(source, was, root.source_ankle, before),
        target: motion(target, is, root.target_ankle, after),
        height_difference: f64::from(height_difference),
    })
}
