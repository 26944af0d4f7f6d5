//! Gait events, and the gait table of a laboratory.
//!
//! Steps are found by the method of Zeni, Richards and Higginson (2008), which also works on a treadmill. In each step
//! a foot reaches its foremost position relative to the pelvis. Later its toes reach their rearmost position, which is
//! the toe-off.
//!
//! The heel strikes some hundredths of a second after the foremost position: when the midpoint of ankle and ball
//! descends fastest (O'Connor and others, 2007). If the toes leave the ground before their rearmost position, the
//! toe-off is the last frame in which they are slow (Ghoussayni and others, 2004). In a run, where the other foot
//! strikes only afterwards, the toe-off is when the knee is most extended (Dingwell and others, 2001). `tools/markers`
//! compares these events with the flight of the body. If the load of a force plate begins or ends near such an event,
//! the time of the load is used. If the file states the events, as C3D files of laboratories do, these events are used
//! instead.
//!
//! Step lengths and widths follow Huxham and others (2006). A stride goes from one heel strike of a foot to its next
//! heel strike. The heel strike of the other foot divides the stride. The distance of that strike from the line of the
//! stride is the step width.

use glam::{DVec2, DVec3};
use mocap_figure::Figure;
use mocap_figure::joint_angles::{Segment, ending};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Scene, Side};
use serde::Serialize;

use super::JointAngles;
use super::cycles::AngleCycle;
use super::events::FileEvents;
use super::mean::MeanAndDeviation;
use super::plates::PlateLoads;
use super::segments::Segments;

/// The time over which the pelvis direction is averaged, in seconds: about one stride, in which the pelvis turns to
/// both sides.
const DIRECTION_OVER: f64 = 1.0;

/// The smallest swing of a foot from behind the pelvis to its front, as a fraction of the leg length.
const LEAST_SWING: f64 = 0.25;

/// The smallest movement between two events, as a fraction of the foot's usual swing.
const TURN: f64 = 0.4;

/// The longest stride in seconds. If heel strikes are farther apart, the body stood still between them.
const LONGEST_STRIDE: f64 = 2.5;

/// The pelvis speed in metres per second below which the motion is in place, or on a treadmill.
const STAYS: f64 = 0.15;

/// The time in seconds after the foremost position within which the foot strikes: a quarter of the swing of a slow
/// walk. The foot also descends once earlier in the swing, after its toes passed over the ground.
const STRIKES_WITHIN: f64 = 0.15;

/// Half of the time over which foot heights are averaged, in seconds. The heights are averaged twice. This lets motion
/// up to 7 Hz pass, like the filter of O'Connor and others (2007).
const HEIGHTS_OVER: f64 = 0.025;

/// The time in seconds before the rearmost position within which the toes leave the ground: the flight phase of a run
/// and some of its swing.
const LEAVES_WITHIN: f64 = 0.2;

/// The toe speed in metres per second above which the toes have left the ground. In a walk with manual events (BTK's
/// example of Plug-in Gait) the toe marker has 1.3 to 1.9 m/s at toe-off.
const LEAVES_AT: f64 = 1.5;

/// The time in seconds before and after the last slow frame of the toes in which the knee of a runner is most extended.
/// In CMU's runs this is 0 to 60 ms after that frame, and then the knee bends fast.
const EXTENDS_WITHIN: [f64; 2] = [0.05, 0.1];

/// The time from a heel strike of a foot to its next one.
///
/// [`Gait`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Stride {
    /// The foot.
    pub side: Side,
    /// The times of its two heel strikes, in seconds from the first frame.
    pub strikes: [f64; 2],
    /// The time of the foot's toe-off between the two heel strikes.
    pub toe_off: Option<f64>,
    /// The time of the other foot's heel strike between the two heel strikes.
    pub other_strike: Option<f64>,
    /// The length in metres; `None` if the motion is in place.
    pub length: Option<f64>,
    /// The distance in metres, along the stride, from the other foot's heel strike to the second heel strike of this
    /// foot.
    pub step_length: Option<f64>,
    /// The distance in metres of the other foot from the line of the stride.
    pub step_width: Option<f64>,
}

/// The events of one foot, and the measures of its strides.
///
/// [`Gait`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SideOfGait {
    /// The times of heel strikes, in seconds from the first frame.
    pub heel_strikes: Vec<f64>,
    /// The times of toe-offs, in seconds from the first frame.
    pub toe_offs: Vec<f64>,
    /// The duration of a stride, in seconds.
    pub stride_time: Option<MeanAndDeviation>,
    /// The length of a stride, in metres.
    pub stride_length: Option<MeanAndDeviation>,
    /// The time from the other foot's heel strike to this foot's heel strike, in seconds.
    pub step_time: Option<MeanAndDeviation>,
    /// The length of a step, in metres.
    pub step_length: Option<MeanAndDeviation>,
    /// The width of a step, in metres.
    pub step_width: Option<MeanAndDeviation>,
    /// The duration of ground contact, in per cent of the stride.
    pub stance: Option<MeanAndDeviation>,
    /// The mean speed over a stride, in metres per second.
    pub speed: Option<MeanAndDeviation>,
    /// The angles of this side's joints, the pelvis and the trunk, over the average stride.
    pub cycles: Vec<AngleCycle>,
}

/// The gait of a walk: events, strides, and the table of a gait laboratory.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::biomechanics::Gait;
///
/// let gait = Gait::of(&mocap::import("fixtures/real/cmu_12_01_walk.bvh")?)?;
/// let cadence = gait.cadence.expect("there are steps");
/// assert!((80.0..130.0).contains(&cadence), "{cadence}");
/// assert!(gait.left.stance.is_some_and(|stance| (55.0..70.0).contains(&stance.mean)));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Gait {
    /// The strides of both feet, sorted by time.
    pub strides: Vec<Stride>,
    /// Steps per minute.
    pub cadence: Option<f64>,
    /// Whether the feet strike alternately in most strides. If not, the motion may not be a walk.
    pub alternates: bool,
    /// Whether the file states the events. If not, they were detected in the motion.
    pub events_of_file: bool,
    /// The number of detected events whose times were taken from force plates.
    pub events_of_plates: usize,
    /// Whether the motion is in place, as on a treadmill. If so, lengths and speeds are absent.
    pub in_place: bool,
    /// The left foot.
    pub left: SideOfGait,
    /// The right foot.
    pub right: SideOfGait,
}

impl Gait {
    /// Measures the walk in the first animation of a scene, in any unit and with any up axis.
    ///
    /// # Errors
    /// - [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid): no humanoid with feet is found.
    /// - [`Code::NoMotion`](mocap_scene::Code::NoMotion): there is no motion, or no foot makes a stride.
    pub fn of(scene: &Scene) -> Result<Self> {
        Self::of_figure(scene, &Figure::new(scene))
    }

    /// Like [`of`](Self::of), with the figure that was found in the scene, such as [`Figure::mapped`].
    ///
    /// # Errors
    /// The errors of [`of`](Self::of).
    pub fn of_figure(scene: &Scene, figure: &Figure) -> Result<Self> {
        let segments = Segments::of(scene, figure)?;
        let events = FileEvents::of(scene);
        let feet = [Side::Left, Side::Right].map(|side| Foot::of(&segments, side, events.as_ref()));
        let [Some(mut left), Some(mut right)] = feet else {
            let message = "the body lacks two feet, from which steps are detected";
            return Err(Diagnostic::new(Code::NotHumanoid, message).into());
        };
        let angles = JointAngles::of_segments(&segments);
        let mut events_of_plates = 0;
        if events.is_none() {
            let toe_offs =
                [(&left, &right), (&right, &left)].map(|(foot, other)| foot.running_toe_offs(other, &angles));
            [left.toe_offs, right.toe_offs] = toe_offs;
            let loads = PlateLoads::of(scene);
            for foot in [&mut left, &mut right] {
                events_of_plates += loads.replace(&mut foot.strikes, &mut foot.toe_offs);
            }
        }
        let mut strides: Vec<Stride> = left.strides(&right).chain(right.strides(&left)).collect();
        if strides.is_empty() {
            let message = "no foot makes a stride, from one heel strike to the next with the pelvis passing over the \
                foot";
            return Err(Diagnostic::new(Code::NoMotion, message)
                .help("choose a clip with two strides of a walk or a run, with {clip} or {trim}")
                .into());
        }
        strides.sort_by(|a, b| a.strikes[0].total_cmp(&b.strikes[0]));
        let in_place = stays(&segments, &strides);
        if in_place {
            for stride in &mut strides {
                (stride.length, stride.step_length) = (None, None);
            }
        }
        let of_side = |foot: &Foot<'_>| SideOfGait::of(foot, &strides, &angles);
        let in_turn = strides.iter().filter(|stride| stride.other_strike.is_some()).count();
        let steps: Vec<f64> = strides.iter().filter_map(Stride::step_time).collect();
        Ok(Self {
            cadence: MeanAndDeviation::of(steps).map(|time| 60.0 / time.mean),
            alternates: 2 * in_turn > strides.len(),
            events_of_file: events.is_some(),
            events_of_plates,
            in_place,
            left: of_side(&left),
            right: of_side(&right),
            strides,
        })
    }
}

impl Stride {
    fn time(&self) -> f64 {
        self.strikes[1] - self.strikes[0]
    }

    fn step_time(&self) -> Option<f64> {
        Some(self.strikes[1] - self.other_strike?)
    }
}

impl SideOfGait {
    fn of(foot: &Foot<'_>, strides: &[Stride], angles: &JointAngles) -> Self {
        let strides: Vec<&Stride> = strides.iter().filter(|stride| stride.side == foot.side).collect();
        let strikes: Vec<[f64; 2]> = strides.iter().map(|stride| stride.strikes).collect();
        let of = |measure: &dyn Fn(&Stride) -> Option<f64>| {
            MeanAndDeviation::of(strides.iter().filter_map(|stride| measure(stride)).collect())
        };
        Self {
            heel_strikes: foot.strikes.clone(),
            toe_offs: foot.toe_offs.clone(),
            stride_time: of(&|stride| Some(stride.time())),
            stride_length: of(&|stride| stride.length),
            step_time: of(&Stride::step_time),
            step_length: of(&|stride| stride.step_length),
            step_width: of(&|stride| stride.step_width),
            stance: of(&|stride| Some(100.0 * (stride.toe_off? - stride.strikes[0]) / stride.time())),
            speed: of(&|stride| Some(stride.length? / stride.time())),
            cycles: AngleCycle::all(angles, &strikes, ending(Some(foot.side.opposite()))),
        }
    }
}

/// A foot, and the times of its events in seconds.
struct Foot<'a> {
    side: Side,
    ankle: &'a [DVec3],
    strikes: Vec<f64>,
    toe_offs: Vec<f64>,
    frame_rate: f64,
}

impl<'a> Foot<'a> {
    /// `None` if the body lacks the foot.
    fn of(segments: &'a Segments, side: Side, events: Option<&FileEvents>) -> Option<Self> {
        let index = usize::from(side == Side::Right);
        let (ankle, ball) = (&segments.ankles[index], &segments.balls[index]);
        let forward = forward(segments)?;
        let before_pelvis = |positions: &[DVec3]| -> Vec<f64> {
            let offsets = positions.iter().zip(&segments.pelvis);
            offsets
                .zip(&forward)
                .map(|((position, pelvis), forward)| on_ground(*position - *pelvis).dot(*forward))
                .collect()
        };
        let turns_of = |positions: &[DVec3]| turns(&before_pelvis(positions), LEAST_SWING * segments.leg);
        let times = |frames: Vec<usize>| frames.iter().map(|frame| *frame as f64 / segments.frame_rate).collect();
        if ankle.is_empty() || ball.is_empty() {
            return None;
        }
        let (strikes, toe_offs) = match events {
            Some(events) => (events.strikes[index].clone(), events.toe_offs[index].clone()),
            None => {
                let heights = std::iter::zip(ankle, ball).map(|(ankle, ball)| ankle.midpoint(*ball).y);
                let farthest = turns_of(ankle).0;
                let strikes = landings(heights.collect(), &farthest, segments.frame_rate);
                let behind = turns_of(ball).1;
                (times(strikes), times(leavings(ball, &behind, segments.frame_rate)))
            }
        };
        Some(Self {
            side,
            ankle,
            strikes,
            toe_offs,
            frame_rate: segments.frame_rate,
        })
    }

    /// The toe-offs of this foot. If no foot is on the ground after a toe-off, the time is when the knee is most
    /// extended.
    fn running_toe_offs(&self, other: &Self, angles: &JointAngles) -> Vec<f64> {
        let name = format!("knee_angle{}", ending(Some(self.side)));
        let knee: Vec<f64> = angles.column(&name).into_iter().flatten().collect();
        let toe_off = |&time: &f64| {
            let frame = (time * self.frame_rate).round() as usize;
            match flies(time, &self.strikes, &other.strikes) {
                true => extended(&knee, frame, self.frame_rate).map_or(time, |frame| frame as f64 / self.frame_rate),
                false => time,
            }
        };
        self.toe_offs.iter().map(toe_off).collect()
    }

    /// The ankle position on the ground plane, in the frame nearest to a time.
    fn at(&self, time: f64) -> DVec2 {
        let frame = (time * self.frame_rate).round() as usize;
        on_ground(self.ankle[frame.min(self.ankle.len() - 1)])
    }

    /// The strides of this foot, with the heel strikes of the other foot between them.
    fn strides(&self, other: &Self) -> impl Iterator<Item = Stride> {
        let strikes = self.strikes.windows(2).map(|pair| [pair[0], pair[1]]);
        strikes
            .filter(|[first, second]| second - first <= LONGEST_STRIDE)
            .map(|[first, second]| {
                let between = |times: &[f64]| times.iter().copied().find(|time| (first..second).contains(time));
                let other_strike = between(&other.strikes);
                let [begin, end] = [first, second].map(|time| self.at(time));
                let along = (end - begin).try_normalize();
                let from_begin = other_strike.map(|time| other.at(time) - begin);
                let of_step = |measure: fn(DVec2, DVec2) -> f64| Some(measure(from_begin?, along?));
                let length = begin.distance(end);
                Stride {
                    side: self.side,
                    strikes: [first, second],
                    toe_off: between(&self.toe_offs),
                    other_strike,
                    length: Some(length),
                    step_length: of_step(DVec2::dot).map(|before| length - before),
                    step_width: of_step(|offset, along| offset.perp_dot(along).abs()),
                }
            })
    }
}

/// Whether the pelvis stays in place over the strides, as on a treadmill.
fn stays(segments: &Segments, strides: &[Stride]) -> bool {
    let frame = |time: f64| ((time * segments.frame_rate).round() as usize).min(segments.pelvis.len() - 1);
    let (mut distance, mut time) = (0.0, 0.0);
    for stride in strides {
        let [begin, end] = stride.strikes.map(|time| on_ground(segments.pelvis[frame(time)]));
        distance += begin.distance(end);
        time += stride.time();
    }
    distance < STAYS * time
}

/// A position on the ground plane: forward and to the right.
fn on_ground(position: DVec3) -> DVec2 {
    DVec2::new(position.x, position.z)
}

/// The facing direction of the pelvis on the ground plane, averaged over the frames around each frame.
fn forward(segments: &Segments) -> Option<Vec<DVec2>> {
    let rotations = segments.to_world(Segment::Pelvis)?;
    let mut sums = vec![DVec2::ZERO];
    for rotation in rotations {
        let last = sums[sums.len() - 1];
        sums.push(last + on_ground(*rotation * DVec3::X).normalize_or_zero());
    }
    let half = (0.5 * DIRECTION_OVER * segments.frame_rate) as usize;
    let mean = |frame: usize| {
        let (from, to) = (frame.saturating_sub(half), (frame + half + 1).min(rotations.len()));
        (sums[to] - sums[from]).normalize_or(DVec2::X)
    };
    Some((0..rotations.len()).map(mean).collect())
}

/// The frames in which the foot descends fastest, each soon after a frame of `farthest`. `farthest` has the foremost
/// positions relative to the pelvis. If the foot does not descend soon after a frame of `farthest`, the result is this
/// frame.
pub fn landings(mut heights: Vec<f64>, farthest: &[usize], frame_rate: f64) -> Vec<usize> {
    for _ in 0..2 {
        heights = averaged(&heights, (HEIGHTS_OVER * frame_rate).round() as usize);
    }
    let fall = |frame: usize| heights[frame - 1] - heights[frame + 1];
    let is_fastest = |frame: &usize| {
        let own = fall(*frame);
        own > 0.0 && own > fall(frame - 1) && own >= fall(frame + 1)
    };
    let within = (STRIKES_WITHIN * frame_rate).round() as usize;
    let landing = |&farthest: &usize| {
        let after = (farthest.max(2)..heights.len().saturating_sub(2)).take(within + 1);
        let fastest = after.filter(is_fastest).max_by(|a, b| fall(*a).total_cmp(&fall(*b)));
        fastest.unwrap_or(farthest)
    };
    farthest.iter().map(landing).collect()
}

/// The frames in which a foot leaves the ground, each soon before a frame of `behind`. Each is the last frame in which
/// the ball of the foot is slow. `behind` has the rearmost positions relative to the pelvis. If the ball is not slow
/// soon before a frame of `behind`, the result is this frame.
pub fn leavings(ball: &[DVec3], behind: &[usize], frame_rate: f64) -> Vec<usize> {
    let is_slow = |frame: &usize| {
        let (before, after) = (frame.saturating_sub(1), (frame + 1).min(ball.len() - 1));
        ball[before].distance(ball[after]) * frame_rate < LEAVES_AT * (after - before) as f64
    };
    let within = (LEAVES_WITHIN * frame_rate).round() as usize;
    let leaving = |&behind: &usize| {
        let before = (behind.saturating_sub(within)..=behind).rev();
        before.into_iter().find(is_slow).unwrap_or(behind)
    };
    behind.iter().map(leaving).collect()
}

/// Whether no foot is on the ground after a toe-off at `time`: the foot itself was the last to strike the ground, and
/// the other foot is the next. In a walk, the other foot strikes before the toe-off.
fn flies(time: f64, own: &[f64], other: &[f64]) -> bool {
    let last = |strikes: &[f64]| strikes.iter().copied().rfind(|strike| *strike <= time);
    let next = |strikes: &[f64]| strikes.iter().copied().find(|strike| *strike > time);
    match (last(own), last(other)) {
        (Some(own), other) => other.is_none_or(|other| other < own),
        (None, Some(_)) => false,
        (None, None) => next(other).is_some_and(|other| next(own).is_none_or(|own| other < own)),
    }
}

/// The frame near `frame` in which a knee is most extended, from its flexion in every frame. `None` if the knee still
/// extends at the end of the searched frames.
pub fn extended(flexion: &[f64], frame: usize, frame_rate: f64) -> Option<usize> {
    let [before, after] = EXTENDS_WITHIN.map(|time| (time * frame_rate).round() as usize);
    let (first, last) = (frame.saturating_sub(before), frame + after);
    let least = (first..=last.min(flexion.len().checked_sub(1)?)).min_by(|a, b| flexion[*a].total_cmp(&flexion[*b]))?;
    (first < least && least < last && least + 1 < flexion.len()).then_some(least)
}

/// The moving average of the values. The window shrinks near the ends, so that it stays centred.
fn averaged(values: &[f64], half: usize) -> Vec<f64> {
    let mean = |index: usize| {
        let half = half.min(index).min(values.len() - 1 - index);
        let around = &values[index - half..=index + half];
        around.iter().sum::<f64>() / around.len() as f64
    };
    (0..values.len()).map(mean).collect()
}

/// The frames in which the values turn from rising to falling, and from falling to rising. On both sides of a turn, the
/// values must change by at least `TURN` of their usual range. Empty if that change is less than `least`.
pub fn turns(values: &[f64], least: f64) -> (Vec<usize>, Vec<usize>) {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |fraction: f64| sorted[((sorted.len() - 1) as f64 * fraction) as usize];
    let range = if sorted.is_empty() { 0.0 } else { at(0.95) - at(0.05) };
    let (mut highest, mut lowest) = (Vec::new(), Vec::new());
    if range.is_nan() || range < least {
        return (highest, lowest);
    }
    let change = TURN * range;
    // The extremes since the last turn. `rises` is `None` until the values change enough in one direction.
    let (mut top, mut bottom) = (0, 0);
    let mut rises: Option<bool> = None;
    for (frame, value) in values.iter().enumerate() {
        if *value > values[top] {
            top = frame;
        }
        if *value < values[bottom] {
            bottom = frame;
        }
        if rises != Some(false) && values[top] - value >= change {
            // The first extreme may be the start of the motion, so it is no turn.
            if rises.is_some() {
                highest.push(top);
            }
            (rises, bottom) = (Some(false), frame);
        } else if rises != Some(true) && value - values[bottom] >= change {
            if rises.is_some() {
                lowest.push(bottom);
            }
            (rises, top) = (Some(true), frame);
        }
    }
    (highest, lowest)
}
