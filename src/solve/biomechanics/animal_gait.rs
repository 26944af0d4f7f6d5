//! The gaits of an animal on four legs.
//!
//! The footfalls of a stride name the gait, as in Hildebrand (Science 150, 1965). In walk, trot and pace, both legs of
//! a pair strike evenly in time. The lag tells these gaits apart: the part of the stride from the strike of a hind paw
//! to the strike of the fore paw of the same side. In canter and gallop, the legs of a pair strike soon after each
//! other.
//!
//! A paw strikes when it is foremost relative to its hip or shoulder, and lifts when it is rearmost (Zeni, Richards and
//! Higginson, 2008). So gaits on a treadmill have names too.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use mocap_figure::animal::{AnimalFrame, AnimalTrack};
use mocap_figure::report::Quadruped;
use mocap_figure::{Confidence, Figure};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::median::median;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::gait::turns;

/// The smallest swing of a paw, as a fraction of the leg. Paws of dogs that stand and shift their weight move less.
const LEAST_SWING: f64 = 0.25;

/// The speed of a paw relative to its hip above which the animal steps, in lengths of the leg per second.
const MOVES: f64 = 0.3;

/// Half of the time over which this speed is measured, in seconds. In a trot, all paws turn back at one time.
const AROUND: f64 = 0.05;

/// The smallest backward speed of a paw on the ground, as a fraction of its median speed between strike and lift. The
/// paw is slower before it touches the ground, and after it leaves the ground. In walks of a Labrador, the speed varies
/// by a half while the paw is on the ground.
const ON_GROUND: f64 = 0.3;

/// The acceleration of gravity, in metres per second squared.
const GRAVITY: f64 = 9.81;

/// The longest stride, in times of the leg: the root of its length by gravity. It is 1.9 s for a Labrador, whose slow
/// walk has strides of 1.2 s.
const LONGEST_STRIDE: f64 = 8.0;

/// The farthest strike of a paw from the middle of a stride, as a fraction of the stride. It is above a half, because
/// paws that strike together differ by some frames.
const NEAR_MIDDLE: f64 = 0.6;

/// The mean deviation of both pairs from strikes that are even in time, above which a gait is asymmetrical. Trots of a
/// Labrador have up to 0.05, and canters have 0.2.
const UNEVEN: f64 = 0.12;

/// The largest lag between a hind paw and the fore paw of the other side in a canter, as a fraction of the stride. They
/// strike together.
const TOGETHER: f64 = 0.1;

/// The smallest Froude number of a canter or a gallop: the square of the speed by gravity and the leg. Animals walk
/// below 0.5 (Alexander and Jayes, 1983).
const RUNS: f64 = 0.5;

/// The duty factor above which a gait is a walk: the part of a stride in which a paw is on the ground.
const WALKS: f64 = 0.5;

/// The smallest lag of a trot, as a fraction of the stride: half-way between the four even beats of a walk and a trot.
const TROT: f64 = 0.375;

/// The largest lags of a pace with the duty factor of a walk, and of a faster pace. A walk of dogs has lags from 0.1.
const PACE: [f64; 2] = [0.0625, 0.125];

/// The height of hips or shoulders below which the animal sits or lies, as a fraction of the leg along its bones. A
/// Labrador that stands has 0.85 to 1, and 0.6 in a crouch.
const LOWERED: f64 = 0.5;

/// The height of a paw in the air, as a fraction of the leg.
const IN_AIR: f64 = 0.09;

/// The shortest flight of a jump, in times of the leg. In this time a body rises and falls by an eighth of the leg.
const FLIES: f64 = 1.0;

/// The shortest stretch that is not a jump, in seconds. Strides of dogs last at least 0.25 s.
const SHORTEST: f64 = 0.25;

/// The margins from the nearest limit that make a name sure, and likely, as a fraction of the stride or of the leg.
const MARGINS: [f64; 2] = [0.05, 0.02];

/// The name of an animal's gait, or of its posture without steps.
///
/// [`BodyGait`](super::BodyGait) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum GaitName {
    /// Four beats, each paw on the ground for more than half of the stride.
    Walk,
    /// Four beats as in a walk, each paw on the ground for less than half of the stride.
    Amble,
    /// A hind paw strikes with the fore paw of the other side.
    Trot,
    /// A hind paw strikes with the fore paw of the same side.
    Pace,
    /// Three beats: one hind paw strikes with the fore paw of the other side.
    Canter,
    /// Both hind paws strike soon after each other, and then both fore paws. A bound is one, too.
    Gallop,
    /// All paws are in the air for a long time.
    Jump,
    /// No steps, with hips and shoulders high.
    Stand,
    /// No steps, with low hips and high shoulders.
    Sit,
    /// No steps, with low hips and low shoulders.
    Lie,
    /// Steps without a regular order, such as in a turn on the spot.
    Other,
}

impl GaitName {
    /// The name in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Walk => "walk",
            Self::Amble => "amble",
            Self::Trot => "trot",
            Self::Pace => "pace",
            Self::Canter => "canter",
            Self::Gallop => "gallop",
            Self::Jump => "jump",
            Self::Stand => "stand",
            Self::Sit => "sit",
            Self::Lie => "lie",
            Self::Other => "other",
        }
    }
}

/// Consecutive frames with one gait.
///
/// [`BodyGait`](super::BodyGait) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GaitStretch {
    /// The name of the gait.
    pub gait: GaitName,
    /// The confidence in the name.
    pub confidence: Confidence,
    /// The first and the last frame, from 0.
    pub frames: [usize; 2],
    /// The number of strides of the left hind leg.
    pub strides: usize,
    /// The mean part of a stride in which a paw is on the ground.
    pub duty_factor: Option<f64>,
    /// The mean part of a stride from the strike of a hind paw to the strike of the fore paw of the same side.
    pub lag: Option<f64>,
    /// The mean speed of the trunk relative to paws on the ground, in metres per second.
    pub speed: Option<f64>,
}

/// The events of a paw.
///
/// [`BodyGait`](super::BodyGait) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Footfalls {
    /// The name of the leg, such as `leftFore`.
    pub leg: &'static str,
    /// The times at which the paw strikes, in seconds from the first frame.
    pub strikes: Vec<f64>,
    /// The times at which the paw lifts, in seconds from the first frame.
    pub lifts: Vec<f64>,
}

/// The gaits of an animal on four legs.
///
/// [`BodyGait`](super::BodyGait) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct AnimalGait {
    /// The frames per second.
    pub frame_rate: f64,
    /// The stretches of frames with one gait, which cover all frames.
    pub stretches: Vec<GaitStretch>,
    /// The events of the left and the right fore paw, and of the left and the right hind paw.
    pub paws: Vec<Footfalls>,
}

impl AnimalGait {
    /// Names the gaits in the first animation of a scene.
    pub(super) fn of(scene: &Scene, figure: &Figure, animal: &Quadruped) -> Result<Self> {
        let moving = scene.animations.first().filter(|animation| animation.frame_count() > 1);
        let animation = moving.ok_or_else(|| Diagnostic::new(Code::NoMotion, "the animal has no motion"))?;
        let frame_rate = animation.ticks_per_second;
        let track = AnimalTrack::new(scene, animation, figure, animal);
        let paws: [Paw; 4] = std::array::from_fn(|index| Paw::of(&track, index));
        let seconds = |frames: &[usize]| frames.iter().map(|frame| *frame as f64 / frame_rate).collect();
        let events = animal.legs.iter().zip(&paws).map(|(leg, paw)| Footfalls {
            leg: leg.as_str(),
            strikes: seconds(&paw.strikes),
            lifts: seconds(&paw.lifts),
        });
        Ok(Self {
            frame_rate,
            paws: events.collect(),
            stretches: stretches(&track, &paws, frame_rate),
        })
    }
}

/// A paw, its position in front of its hip in each frame, and the frames of its events.
struct Paw {
    ahead: Vec<f64>,
    strikes: Vec<usize>,
    lifts: Vec<usize>,
}

impl Paw {
    fn of(track: &AnimalTrack, index: usize) -> Self {
        let ahead = |frame: &AnimalFrame| {
            let forward = (frame.rotation * DVec3::X).truncate().normalize_or(DVec2::X);
            (frame.paws[index] - frame.hips[index]).truncate().dot(forward)
        };
        let ahead: Vec<f64> = track.frames.iter().map(ahead).collect();
        let (strikes, lifts) = turns(&ahead, LEAST_SWING * track.leg);
        Self { ahead, strikes, lifts }
    }

    /// The strike nearest to the middle of a stride.
    fn strike_in(&self, [begin, end]: [usize; 2]) -> Option<usize> {
        let middle = begin.midpoint(end);
        let strike = *self.strikes.iter().min_by_key(|strike| strike.abs_diff(middle))?;
        let near = NEAR_MIDDLE * (end - begin) as f64;
        (strike.abs_diff(middle) as f64 <= near).then_some(strike)
    }

    /// The frames on the ground after a strike, and the backward speed in metres per frame. `None` if the paw does not
    /// lift within `longest` frames.
    fn stance(&self, strike: usize, longest: usize) -> Option<(f64, f64)> {
        let lift = *self.lifts.iter().find(|lift| **lift > strike)?;
        if lift - strike > longest {
            return None;
        }
        let steps = self.ahead[strike..=lift].windows(2);
        let backward: Vec<f64> = steps.map(|pair| pair[0] - pair[1]).collect();
        let usual = median(&mut backward.clone())?;
        let stands = backward.iter().filter(|step| **step >= ON_GROUND * usual).count();
        Some((stands as f64, usual))
    }
}

/// The measures of a stride of the left hind leg.
struct Stride {
    frames: [usize; 2],
    /// `None` if a paw does not strike, or no paw lifts.
    measures: Option<Measures>,
}

#[derive(Clone, Copy)]
struct Measures {
    phases: [f64; 4],
    duty: f64,
    speed: f64,
    froude: f64,
}

impl Stride {
    fn new(paws: &[Paw; 4], frames: [usize; 2], leg: f64, frame_rate: f64) -> Self {
        let length = frames[1] - frames[0];
        let strikes: Option<Vec<usize>> = paws.iter().map(|paw| paw.strike_in(frames)).collect();
        let measures = strikes.and_then(|strikes| {
            let pairs = paws.iter().zip(&strikes);
            let stances: Vec<(f64, f64)> = pairs.filter_map(|(paw, strike)| paw.stance(*strike, length)).collect();
            let mean = |of: fn(&(f64, f64)) -> f64| stances.iter().map(of).sum::<f64>() / stances.len() as f64;
            let speed = frame_rate * mean(|stance| stance.1);
            (!stances.is_empty()).then(|| Measures {
                phases: std::array::from_fn(|index| (strikes[index] as f64 - frames[0] as f64) / length as f64),
                duty: mean(|stance| stance.0) / length as f64,
                speed,
                froude: speed * speed / (GRAVITY * leg),
            })
        });
        Self { frames, measures }
    }

    /// The name of the gait, with the margin from the nearest other name.
    fn named(&self) -> (GaitName, f64) {
        let Some(measures) = self.measures else {
            return (GaitName::Other, 0.0);
        };
        let [left_fore, right_fore, left_hind, right_hind] = measures.phases;
        let uneven = 0.5 - 0.5 * (apart(left_fore, right_fore) + apart(left_hind, right_hind));
        if uneven > UNEVEN {
            if measures.froude < RUNS {
                return (GaitName::Other, 0.0);
            }
            let diagonal = apart(left_hind, right_fore).min(apart(right_hind, left_fore));
            let gait = if diagonal < TOGETHER {
                GaitName::Canter
            } else {
                GaitName::Gallop
            };
            return (gait, (uneven - UNEVEN).min((diagonal - TOGETHER).abs()));
        }
        let walks = measures.duty > WALKS;
        let pace = PACE[usize::from(!walks)];
        let lag = apart(mean_phase(measures.lags()), 0.0);
        let (gait, margin) = if lag > TROT {
            (GaitName::Trot, lag - TROT)
        } else if lag < pace {
            (GaitName::Pace, pace - lag)
        } else {
            let gait = if walks { GaitName::Walk } else { GaitName::Amble };
            let margin = (lag - pace).min(TROT - lag);
            (gait, margin.min((measures.duty - WALKS).abs()))
        };
        (gait, margin.min(UNEVEN - uneven))
    }
}

impl Measures {
    /// The lag of the left and of the right side.
    fn lags(&self) -> [f64; 2] {
        let [left_fore, right_fore, left_hind, right_hind] = self.phases;
        [left_fore - left_hind, right_fore - right_hind]
    }
}

/// The distance of two phases, up to a half.
fn apart(a: f64, b: f64) -> f64 {
    let between = (a - b).rem_euclid(1.0);
    between.min(1.0 - between)
}

/// The mean of phases, from 0 to 1.
fn mean_phase(phases: impl IntoIterator<Item = f64>) -> f64 {
    let sum: DVec2 = phases.into_iter().map(|phase| DVec2::from_angle(TAU * phase)).sum();
    (sum.to_angle() / TAU).rem_euclid(1.0)
}

/// The gait in a frame, and the margin of the name.
type Named = (GaitName, f64);

fn stretches(track: &AnimalTrack, paws: &[Paw; 4], frame_rate: f64) -> Vec<GaitStretch> {
    let time_of_leg = (track.leg / GRAVITY).sqrt() * frame_rate;
    let longest = LONGEST_STRIDE * time_of_leg;
    let strides: Vec<Stride> = paws[2]
        .strikes
        .windows(2)
        .filter(|pair| ((pair[1] - pair[0]) as f64) < longest)
        .map(|pair| Stride::new(paws, [pair[0], pair[1]], track.leg, frame_rate))
        .collect();
    let mut named: Vec<Option<Named>> = vec![None; track.frames.len()];
    for stride in &strides {
        named[stride.frames[0]..stride.frames[1]].fill(Some(stride.named()));
    }
    // The first and the last steps are no whole strides.
    let around = (AROUND * frame_rate).round().max(1.0) as usize;
    let moves = |frame: usize| {
        let (before, after) = (frame.saturating_sub(around), (frame + around).min(named.len() - 1));
        let least = MOVES * track.leg * (after - before) as f64 / frame_rate;
        paws.iter().any(|paw| {
            let around = paw.ahead[before..=after].iter().copied();
            around.clone().fold(f64::MIN, f64::max) - around.fold(f64::MAX, f64::min) > least
        })
    };
    let mut extended = named.clone();
    for stride in &strides {
        let [begin, end] = stride.frames;
        let length = end - begin;
        let is_open = |frame: &usize| named[*frame].is_none() && moves(*frame);
        let before = (begin.saturating_sub(length)..begin).rev().take_while(is_open);
        let after = (end..named.len().min(end + length)).take_while(is_open);
        for frame in before.chain(after) {
            extended[frame] = Some(stride.named());
        }
    }
    let mut named = extended;
    for ([begin, end], margin) in jumps(track, FLIES * time_of_leg) {
        named[begin..end].fill(Some((GaitName::Jump, margin)));
    }
    let posture = |(frame, named): (usize, Option<Named>)| named.unwrap_or_else(|| posture(track, frame));
    let named: Vec<Named> = named.into_iter().enumerate().map(posture).collect();
    let runs = runs(&named, (SHORTEST * frame_rate) as usize);
    runs.into_iter()
        .map(|(gait, frames)| stretch(gait, frames, &named, &strides))
        .collect()
}

/// The posture in a frame without steps.
fn posture(track: &AnimalTrack, frame: usize) -> Named {
    let height = |pair: [usize; 2]| {
        let above = |index: usize| track.frames[frame].hips[index].z - track.ground[index];
        0.5 * pair.into_iter().map(above).sum::<f64>() / track.leg
    };
    let [fore, hind] = [[0, 1], [2, 3]].map(|pair| height(pair) - LOWERED);
    match (fore < 0.0, hind < 0.0) {
        (true, true) => (GaitName::Lie, fore.abs().min(hind.abs())),
        (false, true) => (GaitName::Sit, fore.min(hind.abs())),
        (_, false) => (GaitName::Stand, hind),
    }
}

/// The frames of jumps: from the lift of the fore paws to the landing of the hind paws, around a flight of at least
/// `shortest` frames. Each has the margin of the flight, as a fraction of `shortest`.
fn jumps(track: &AnimalTrack, shortest: f64) -> Vec<([usize; 2], f64)> {
    let frames = track.frames.len();
    let in_air = |frame: usize, pair: [usize; 2]| {
        let mut paws = pair.into_iter();
        paws.all(|paw| track.frames[frame].paws[paw].z - track.ground[paw] > IN_AIR * track.leg)
    };
    let (fore, hind) = (
        |frame: usize| in_air(frame, [0, 1]),
        |frame: usize| in_air(frame, [2, 3]),
    );
    let mut found = Vec::new();
    let mut frame = 0;
    while frame < frames {
        let flight = (frame..frames).take_while(|frame| fore(*frame) && hind(*frame)).count();
        if flight as f64 >= shortest {
            // A body that rears has its fore paws in the air for a longer time.
            let before = (frame.saturating_sub(flight)..frame)
                .rev()
                .take_while(|frame| fore(*frame))
                .count();
            let after = (frame + flight..frames.min(frame + 2 * flight))
                .take_while(|frame| hind(*frame))
                .count();
            found.push(([frame - before, frame + flight + after], flight as f64 / shortest - 1.0));
        }
        frame += flight.max(1);
    }
    found
}

/// The gait, and the first and the last frame of each run. A run of fewer than `shortest` frames that is no jump
/// belongs to the run before it, or at the start to the run after it.
fn runs(named: &[Named], shortest: usize) -> Vec<(GaitName, [usize; 2])> {
    let mut runs: Vec<(GaitName, [usize; 2])> = Vec::new();
    let mut begin = 0;
    for run in named.chunk_by(|a, b| a.0 == b.0) {
        let (gait, end) = (run[0].0, begin + run.len() - 1);
        let is_short = run.len() < shortest && gait != GaitName::Jump;
        match runs.last_mut() {
            Some((before, frames)) if *before == gait || is_short => frames[1] = end,
            _ => runs.push((gait, [begin, end])),
        }
        begin = end + 1;
    }
    if let [(gait, [first, last]), (_, second), ..] = &mut runs[..]
        && *last - *first < shortest
        && *gait != GaitName::Jump
    {
        second[0] = *first;
        runs.remove(0);
    }
    runs
}

fn stretch(gait: GaitName, frames: [usize; 2], named: &[Named], strides: &[Stride]) -> GaitStretch {
    let [first, last] = frames;
    let own = named[first..=last].iter().filter(|(name, _)| *name == gait);
    let (sum, count) = own.fold((0.0, 0), |(sum, count), (_, margin)| (sum + margin, count + 1));
    let margin = sum / f64::from(count);
    let inside = strides.iter().filter(|stride| {
        let middle = stride.frames[0].midpoint(stride.frames[1]);
        (first..=last).contains(&middle) && stride.named().0 == gait
    });
    let measures: Vec<Measures> = inside.filter_map(|stride| stride.measures).collect();
    let mean = |of: fn(&Measures) -> f64| {
        (!measures.is_empty()).then(|| measures.iter().map(of).sum::<f64>() / measures.len() as f64)
    };
    // One stride may be a step between two gaits.
    let is_repeated = strides.iter().all(|stride| stride.named().0 != gait) || measures.len() > 1;
    GaitStretch {
        gait,
        confidence: match margin {
            _ if gait == GaitName::Other => Confidence::Unsure,
            margin if margin >= MARGINS[0] && is_repeated => Confidence::Sure,
            margin if margin >= MARGINS[1] => Confidence::Likely,
            _ => Confidence::Unsure,
        },
        frames,
        strides: measures.len(),
        duty_factor: mean(|measures| measures.duty),
        lag: (!measures.is_empty()).then(|| mean_phase(measures.iter().flat_map(Measures::lags))),
        speed: mean(|measures| measures.speed),
    }
}
