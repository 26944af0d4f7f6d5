//! Measures a motion before and after each part of the cleaning.

use std::collections::VecDeque;

use glam::Vec3;
use mocap_scene::math::median::{median, ranked};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone as Bone, NodeKind};
use serde::Serialize;

use super::time;
use crate::contacts::{ContactOptions, DetectedContacts, detect};
use crate::flips;
use crate::floor;
use crate::frames::{Frames, tracks};
use crate::work::Work;

/// The time over which the speed of a joint is measured, in seconds. Over a shorter time, noise would add speed.
const SPEED_OVER: f64 = 0.1;
/// The peak speed is the speed that one of this many values exceeds, over all joints and frames.
const PEAK: usize = 100;

/// The number of frames that a jerk needs, because it is a third difference.
const JERK_FRAMES: usize = 4;

/// Measures of a motion, in metres, seconds and degrees.
///
/// [`Clean`](crate::Clean) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CleanMeasures {
    /// Frames per second.
    pub frame_rate: f64,
    /// The number of frames that repeat the frame before, although the body moves before and after them.
    pub held_frames: usize,
    /// The number of rotations that jump from one frame to the next.
    pub jumps: usize,
    /// The mean jerk of all joints, in metres per second cubed.
    pub jitter: f64,
    /// The speed that one percent of the speeds of all joints in all frames exceed, in metres per second. A speed is
    /// measured over a tenth of a second.
    pub peak_speed: f64,
    /// The mean speed over the ground of feet in contact, in metres per second. `None` if the figure has no feet or
    /// they have no contact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skate: Option<f64>,
    /// The mean vertical distance of feet in contact from their resting level, in metres. It is measured at the balls
    /// of the feet, or at the ankles if no foot has a ball. `None` without feet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uneven: Option<f64>,
    /// The mean distance between two hands that touch, or between a hand and the bone that it touches, in metres. It is
    /// measured from the centre of the hand. `None` if no hand touches anything, or if this was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hands: Option<f64>,
    /// The height of the floor under the feet, in metres. `None` if no foot is ever in stance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor_height: Option<f64>,
    /// The slope of the floor, in degrees. `None` if the feet do not determine it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub floor_slope: Option<f64>,
}

impl CleanMeasures {
    pub(super) fn new(work: &Work<'_>) -> Self {
        let frames = &work.frames;
        let [jitter, peak_speed] = jitter_and_peak(work, frames);
        let is_humanoid = work.is_humanoid();
        let found = is_humanoid.then(|| floor::find(work)).flatten();
        let contacts = || detect(work.scene, frames, work.figure, &ContactOptions::default());
        let contacts = is_humanoid.then(contacts);
        let jumps = |column: usize| {
            let track: Vec<_> = frames.track(column).iter().map(|trs| trs.rotation).collect();
            flips::count(&track)
        };
        Self {
            frame_rate: frames.rate,
            held_frames: time::held(work),
            jumps: (0..frames.nodes().len()).map(jumps).sum(),
            jitter,
            peak_speed,
            skate: contacts.as_ref().and_then(|contacts| skate(work, contacts)),
            uneven: contacts.as_ref().and_then(uneven),
            hands: None,
            floor_height: found.as_ref().map(|floor| floor.height),
            floor_slope: found.filter(floor::Floor::tells).map(|floor| floor.slope()),
        }
    }
}

/// Whether the movement that a part of the cleaning removed from `before` is only noise. Of noise, one step in 10,000
/// is longer than three times the median step. If the part cut peaks of the motion, more than one step in 10,000 is
/// longer.
pub(super) fn is_noise(work: &Work<'_>, before: &Frames) -> bool {
    // A step is long if it is longer than this multiple of the median step. Noise hardly ever makes such steps.
    const LONG: f32 = 3.0;
    let nodes = work.frames.nodes();
    let over = work.frames.frames_in(SPEED_OVER);
    let (mut all, mut long) = (0, 0);
    let pairs = tracks(before, work.scene, nodes).into_iter();
    for (before, after) in pairs.zip(tracks(&work.frames, work.scene, nodes)) {
        let removed: Vec<Vec3> = before
            .iter()
            .zip(&after)
            .map(|(before, after)| *before - *after)
            .collect();
        let steps: Vec<f32> = removed
            .windows(over + 1)
            .map(|pair| pair[0].distance(pair[over]))
            .collect();
        let usual = median(&mut steps.clone()).unwrap_or_default();
        all += steps.len();
        long += steps.iter().filter(|step| **step > LONG * usual).count();
    }
    PEAK * long < all
}

/// Whether a rotation jumps at a frame at which it did not jump in `before`. Also true if the number of frames changed.
pub(super) fn has_new_jump(before: &Work<'_>, after: &Work<'_>) -> bool {
    let track = |work: &Work<'_>, column: usize| -> Vec<_> { work.frames.rotations(column).collect() };
    let is_new = |column: usize| flips::count_new(&track(after, column), &track(before, column)) > 0;
    before.frames.len() != after.frames.len() || (0..after.frames.nodes().len()).any(is_new)
}

/// The mean jerk in m/s^3, and the peak speed in m/s.
pub(super) fn jitter_and_peak(work: &Work<'_>, frames: &Frames) -> [f64; 2] {
    let rate = frames.rate;
    let nodes = work.scene.nodes.iter().enumerate();
    let joints: Vec<usize> = nodes
        .filter(|(_, node)| node.kind == NodeKind::Joint)
        .map(|(index, _)| index)
        .collect();
    let over = frames.frames_in(SPEED_OVER);
    let mut pose = Pose::rest(work.scene);
    // The latest frames, oldest first.
    let mut rows: VecDeque<Vec<Vec3>> = VecDeque::new();
    let mut jerk = 0.0;
    let mut fastest = Largest::new(frames.len().saturating_sub(over) * joints.len());
    for frame in 0..frames.len() {
        frames.pose(frame, &mut pose);
        let mut row = match rows.len() > over.max(JERK_FRAMES - 1) {
            true => rows.pop_front().unwrap_or_default(),
            false => Vec::new(),
        };
        row.clear();
        let world = joints.iter().map(|joint| pose.node_to_world[*joint].w_axis.truncate());
        row.extend(world.map(|position| position * work.metres));
        rows.push_back(row);
        let before = |frames: usize| rows.len().checked_sub(frames + 1).map(|index| &rows[index]);
        if let [Some(a), Some(b), Some(c), Some(d)] = [3, 2, 1, 0].map(before) {
            for ((a, b), (c, d)) in a.iter().zip(b).zip(c.iter().zip(d)) {
                jerk += f64::from((*d - *a + 3.0 * (*b - *c)).length());
            }
        }
        if let [Some(a), Some(b)] = [over, 0].map(before) {
            a.iter().zip(b).for_each(|(a, b)| fastest.push(a.distance(*b)));
        }
    }
    let count = frames.len().saturating_sub(JERK_FRAMES - 1) * joints.len();
    let peak = fastest.least().map_or(0.0, |peak| f64::from(peak) * rate / over as f64);
    [jerk * rate.powi(3) / count.max(1) as f64, peak]
}

/// Keeps the largest hundredth ([`PEAK`]) of many values, and drops all other values.
struct Largest {
    kept: usize,
    values: Vec<f32>,
}

impl Largest {
    /// The smallest number of values that are dropped at once. With this number, a value is seldom moved in memory.
    const DROPPED: usize = 4096;

    fn new(all: usize) -> Self {
        Self {
            kept: all.saturating_sub(1) / PEAK + 1,
            values: Vec::new(),
        }
    }

    fn push(&mut self, value: f32) {
        self.values.push(value);
        if self.values.len() >= self.kept + self.kept.max(Self::DROPPED) {
            self.least();
        }
    }

    /// The smallest of the kept values. Drops all other values first.
    fn least(&mut self) -> Option<f32> {
        let others = self.values.len().saturating_sub(self.kept);
        let least = ranked(&mut self.values, others);
        self.values.drain(..others);
        least
    }
}

/// The mean speed over the ground of the points of feet in contact, in m/s.
fn skate(work: &Work<'_>, found: &DetectedContacts) -> Option<f64> {
    let (mut slid, mut steps) = (0.0, 0);
    for point in &found.points {
        for frame in (1..found.frames).filter(|frame| point.at_rest[frame - 1] && point.at_rest[*frame]) {
            let step = point.positions[frame] - point.positions[frame - 1];
            slid += f64::from((step - work.up * step.dot(work.up)).length() * work.metres);
            steps += 1;
        }
    }
    (steps > 0).then(|| slid * work.frames.rate / steps as f64)
}

/// The mean distance of feet from their resting level in `before`, in metres. Only the frames count in which the feet
/// are in contact in `after`.
pub(super) fn uneven_before(before: &Work<'_>, after: &Work<'_>) -> Option<f64> {
    let [mut feet, locked] =
        [before, after].map(|work| detect(work.scene, &work.frames, work.figure, &ContactOptions::default()));
    for (point, locked) in feet.points.iter_mut().zip(locked.points) {
        point.at_rest = locked.at_rest;
    }
    uneven(&feet)
}

/// The mean distance of feet in contact from their resting level, in metres.
fn uneven(found: &DetectedContacts) -> Option<f64> {
    let heights = |of_balls: bool| -> Vec<f32> {
        let is_ball = |bone: Bone| matches!(bone, Bone::LeftToes | Bone::RightToes);
        let points = found.points.iter().filter(|point| is_ball(point.bone) == of_balls);
        let heights = points.flat_map(|point| point.above_rest.iter().zip(&point.at_rest));
        heights
            .filter(|(_, at_rest)| **at_rest)
            .map(|(height, _)| *height)
            .collect()
    };
    let balls = heights(true);
    let mut heights = if balls.is_empty() { heights(false) } else { balls };
    let level = median(&mut heights)?;
    let off = heights.iter().map(|height| f64::from((height - level).abs()));
    Some(off.sum::<f64>() / heights.len() as f64)
}
