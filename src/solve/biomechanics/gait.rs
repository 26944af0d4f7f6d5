//! The events of a walk, and the table that a gait laboratory makes of them.
//!
//! Each step is found as Zeni, Richards and Higginson (2008) do. The foot is farthest before the pelvis, and then its
//! toes farthest behind it, which is when they leave the ground. That holds on a treadmill too. The foot strikes some
//! hundredths of a second after it was farthest before: when the middle of ankle and ball is lowered fastest, as
//! O'Connor and others (2007) have it. In a run the toes leave the ground before they are farthest behind. There the
//! last moment counts in which they are slow, as Ghoussayni and others (2004) have it. Where the file itself has the
//! events, as C3D files of laboratories do, they are taken instead.
//!
//! Lengths and widths of steps are those of Huxham and others (2006). A stride goes from a strike of a foot to its next
//! strike. The strike of the other foot between them divides it, and its distance from the line of the stride is the
//! width.

use glam::{DVec2, DVec3};
use mocap_figure::Figure;
use mocap_figure::joint_angles::Segment;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::{Scene, Side};
use serde::Serialize;

use super::events::FileEvents;
use super::segments::Segments;

/// The time over which the direction of the pelvis is averaged, in seconds: about a stride, in which it turns to both
/// sides.
const DIRECTION_OVER: f64 = 1.0;

/// A foot swings by at least this fraction of the length of the leg, from behind the pelvis to before it.
const LEAST_SWING: f64 = 0.25;

/// An event is a turn of the foot after at least this fraction of its usual swing.
const TURN: f64 = 0.4;

/// The longest stride that is one, in seconds: between others the body stood.
const LONGEST_STRIDE: f64 = 2.5;

/// Slower than this, in metres per second, the pelvis stays where it is: the motion is in place, or on a treadmill.
const STAYS: f64 = 0.15;

/// The time in seconds within which a foot strikes after it was farthest before the pelvis: a quarter of the swing of a
/// slow walk. The foot is lowered once more in the swing, after its toes passed over the ground.
const STRIKES_WITHIN: f64 = 0.15;

/// Half of the time in seconds over which heights of a foot are averaged, twice: so as to pass 7 Hz, as O'Connor and
/// others (2007) filter them.
const HEIGHTS_OVER: f64 = 0.025;

/// The time in seconds within which toes left the ground before they are farthest behind the pelvis: the flight of a
/// run, and a part of its swing.
const LEAVES_WITHIN: f64 = 0.2;

/// The speed in metres per second above which toes have left the ground. In a walk with events set by hand (BTK's
/// example of Plug-in Gait) the marker on the toes has 1.3 to 1.9 m/s then.
const LEAVES_AT: f64 = 1.5;

/// From a heel strike of a foot to its next one.
///
/// [`Gait`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Stride {
    /// The foot.
    pub side: Side,
    /// The times of its heel strikes, in seconds from the first frame.
    pub strikes: [f64; 2],
    /// When its toes left the ground between them.
    pub toe_off: Option<f64>,
    /// When the heel of the other foot struck between them.
    pub other_strike: Option<f64>,
    /// The length in metres; `None` where the body stays in place.
    pub length: Option<f64>,
    /// From the strike of the other foot to the second of this one, along the stride, in metres.
    pub step_length: Option<f64>,
    /// The distance of the other foot from the line of the stride, in metres.
    pub step_width: Option<f64>,
}

/// Mean and standard deviation of a measure, with the number of its values.
///
/// [`Gait`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MeanAndDeviation {
    /// The mean.
    pub mean: f64,
    /// The standard deviation of the values, with one less than their number below; 0 for one value.
    pub deviation: f64,
    /// How many values there are.
    pub count: usize,
}

/// The events of one foot, and the measures of its strides.
///
/// [`Gait`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SideOfGait {
    /// When the heel strikes the ground, in seconds from the first frame.
    pub heel_strikes: Vec<f64>,
    /// When the toes leave the ground, in seconds from the first frame.
    pub toe_offs: Vec<f64>,
    /// In seconds.
    pub stride_time: Option<MeanAndDeviation>,
    /// In metres.
    pub stride_length: Option<MeanAndDeviation>,
    /// From the strike of the other foot to that of this one, in seconds.
    pub step_time: Option<MeanAndDeviation>,
    /// In metres.
    pub step_length: Option<MeanAndDeviation>,
    /// In metres.
    pub step_width: Option<MeanAndDeviation>,
    /// The part of the stride in which the foot is on the ground, in per cent.
    pub stance: Option<MeanAndDeviation>,
    /// In metres per second.
    pub speed: Option<MeanAndDeviation>,
}

/// A walk: its events, its strides, and the table of a gait laboratory.
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
    /// The strides of both feet, in the order of time.
    pub strides: Vec<Stride>,
    /// Steps in a minute.
    pub cadence: Option<f64>,
    /// Whether the feet strike in turn, in most of the strides; if not, this may be no walk.
    pub alternates: bool,
    /// Whether the events are those of the file; or else they are found in the motion.
    pub events_of_file: bool,
    /// Whether the body stays where it is, as on a treadmill: then there are no lengths and no speeds.
    pub in_place: bool,
    /// The left foot.
    pub left: SideOfGait,
    /// The right foot.
    pub right: SideOfGait,
}

impl Gait {
    /// The walk in the first animation of a scene, in any unit and with any axis up.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] where no humanoid with feet is found; [`Code::NoMotion`] where there is no motion or no
    /// foot makes a stride.
    pub fn of(scene: &Scene) -> Result<Self> {
        Self::of_figure(scene, &Figure::new(scene))
    }

    /// As [`of`](Self::of), with the figure that was found in the scene, such as [`Figure::mapped`].
    ///
    /// # Errors
    /// As [`of`](Self::of).
    pub fn of_figure(scene: &Scene, figure: &Figure) -> Result<Self> {
        let segments = Segments::of(scene, figure)?;
        let events = FileEvents::of(scene);
        let feet = [Side::Left, Side::Right].map(|side| Foot::of(&segments, side, events.as_ref()));
        let [Some(left), Some(right)] = feet else {
            let message = "the body has not two feet, by whose positions steps are found";
            return Err(Diagnostic::new(Code::NotHumanoid, message).into());
        };
        let mut strides: Vec<Stride> = left.strides(&right).chain(right.strides(&left)).collect();
        if strides.is_empty() {
            let message = "no foot makes a stride: from one heel strike to the next, with the pelvis over it between";
            return Err(Diagnostic::new(Code::NoMotion, message)
                .help("take a clip that has two strides of a walk or a run, with {clip} or {trim}")
                .into());
        }
        strides.sort_by(|a, b| a.strikes[0].total_cmp(&b.strikes[0]));
        let in_place = stays(&segments, &strides);
        if in_place {
            for stride in &mut strides {
                (stride.length, stride.step_length) = (None, None);
            }
        }
        let of_side = |foot: &Foot<'_>| SideOfGait::of(foot, strides.iter().filter(|stride| stride.side == foot.side));
        let in_turn = strides.iter().filter(|stride| stride.other_strike.is_some()).count();
        let steps: Vec<f64> = strides.iter().filter_map(Stride::step_time).collect();
        Ok(Self {
            cadence: MeanAndDeviation::of(steps).map(|time| 60.0 / time.mean),
            alternates: 2 * in_turn > strides.len(),
            events_of_file: events.is_some(),
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

impl MeanAndDeviation {
    fn of(values: Vec<f64>) -> Option<Self> {
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        (count > 0).then(|| Self {
            mean,
            deviation: (squares / (count.max(2) - 1) as f64).sqrt(),
            count,
        })
    }
}

impl SideOfGait {
    fn of<'a>(foot: &Foot<'_>, strides: impl Iterator<Item = &'a Stride> + Clone) -> Self {
        let of = |measure: &dyn Fn(&Stride) -> Option<f64>| {
            MeanAndDeviation::of(strides.clone().filter_map(measure).collect())
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
    /// `None` where the body has no such foot.
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

    /// Where the ankle is on the ground, in the frame nearest to a time.
    fn at(&self, time: f64) -> DVec2 {
        let frame = (time * self.frame_rate).round() as usize;
        on_ground(self.ankle[frame.min(self.ankle.len() - 1)])
    }

    /// The strides of this foot, with the strikes of the other one between.
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

/// Whether the pelvis stays where it is over the strides, as on a treadmill.
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

/// A position on the ground: forward and to the right.
fn on_ground(position: DVec3) -> DVec2 {
    DVec2::new(position.x, position.z)
}

/// Where the pelvis looks, on the ground, on the average of the frames around each.
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

/// The frames in which a foot of these heights is lowered fastest, each soon after the frame in which it is farthest
/// before the pelvis. If the foot is not lowered then, that frame is taken.
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

/// The frames in which a foot leaves the ground. Each is the last one in which the ball of the foot is slow, soon
/// before the ball is farthest `behind` the pelvis. If the ball is not slow there, it is the frame of `behind`.
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

/// The mean of each value and those around it, fewer near the ends, so that it stays in the middle of them.
fn averaged(values: &[f64], half: usize) -> Vec<f64> {
    let mean = |index: usize| {
        let half = half.min(index).min(values.len() - 1 - index);
        let around = &values[index - half..=index + half];
        around.iter().sum::<f64>() / around.len() as f64
    };
    (0..values.len()).map(mean).collect()
}

/// The frames in which the values turn from rising to falling, and from falling to rising, after a change of at least
/// `TURN` of their usual range, on both sides. None if that is less than `least`.
pub fn turns(values: &[f64], least: f64) -> (Vec<usize>, Vec<usize>) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |fraction: f64| sorted[((sorted.len() - 1) as f64 * fraction) as usize];
    let range = if sorted.is_empty() { 0.0 } else { at(0.95) - at(0.05) };
    let (mut highest, mut lowest) = (Vec::new(), Vec::new());
    if range.is_nan() || range < least {
        return (highest, lowest);
    }
    let change = TURN * range;
    // The extremes since the last turn; `rises` once a change in one direction was seen.
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
            // Before the first turn nothing says that the foot rose there.
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
