//! The noise of each joint, and the motion without it.
//!
//! The differences of a track, from the second on, are each divided by their gain for white noise. Then white noise is
//! alike in all of them, and a motion is smaller in each further one. So the smallest of them is the noise, or above
//! it. It is taken in spans of half a second by the median, and of all spans that of a calm one counts. What has hardly
//! any noise is not touched.

use glam::{DQuat, DVec3};
use mocap_scene::math::median::{MEDIAN_OF_NORMAL, percentile};
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::Trs;
use mocap_scene::scene::NodeId;

use super::pace::{Bank, Sampled};
use super::smoother::{Positions, Rotations, Values, smooth};
use crate::clean_weights::CleanWeights;
use crate::work::Work;

/// The differences that are looked at.
const ORDERS: std::ops::RangeInclusive<usize> = 2..=7;

/// The time of a span in seconds: the calm part of a step.
const SPAN: f64 = 0.5;

/// Frames of a span at least: a median of fewer differences says little.
const SPAN_FRAMES: usize = 16;

/// The fraction of the spans, ordered from calm to lively, at which the span that counts stands: the calmest spans are
/// calm by chance.
const CALM: f64 = 0.3;

/// The shortest clip, in seconds, in which single joints with noise are smoothed if most joints have none. In a shorter
/// clip no span may be calm, and the step of a run resembles noise.
const CALM_AFTER: f64 = 3.0;

/// The ratio of the last two differences from which on a track is white noise, whose ratio is 1; motions have less.
const FLAT: f64 = 0.85;
/// Less than all white noise is found so, because the least of several estimates of a calm span counts. The deficit is
/// this factor over the root of the frames of a span. Simulated with 60 draws each: 0.79 for 16 frames, 0.845 for 30,
/// 0.887 for 60.
const LESS: f64 = 0.85;

/// The fraction of the joints that turn which is most of them.
const MOST: f64 = 0.5;

/// The fraction of the joints that turn which is nearly all of them.
const NEARLY_ALL: f64 = 0.7;

/// The least noise, as a fraction of that of one joint, where most joints have it. Noise of an estimate is correlated,
/// and shows a third of its size in single frames.
const OF_LEAST: f64 = 0.4;

/// What was found and done.
#[derive(Default)]
pub(super) struct SmoothingOutcome {
    pub(super) rotations: usize,
    pub(super) positions: usize,
    /// The median noise of the joints that were smoothed, in degrees.
    pub(super) angle: f64,
    /// The largest noise of a position, in metres.
    pub(super) distance: f64,
    /// The noise of the whole body along the axis of a camera, in metres.
    pub(super) depth: Option<f64>,
    /// Whether most joints had noise.
    pub(super) in_most: bool,
}

impl SmoothingOutcome {
    pub(super) fn is_nothing(&self) -> bool {
        self.rotations + self.positions == 0 && self.depth.is_none()
    }
}

/// The noise of the rotations of each joint, as the displacement of the farthest joint below it, in metres.
pub(super) fn levels(work: &Work<'_>) -> Vec<(NodeId, f64)> {
    let nodes = work.frames.nodes().iter().enumerate();
    let level = |(column, node): (usize, &NodeId)| {
        let rotations = work.frames.rotations(column);
        let values: Vec<DQuat> = rotations.map(|rotation| rotation.as_dquat().normalize()).collect();
        // Of a motion, as most tracks are, no more is asked.
        let level = |curve: Sampled| Spans::new(&curve, work.frames.rate).level(true).noise(false);
        let noise = curve::<Rotations>(&values, 1).map(level);
        (*node, noise.unwrap_or_default() * f64::from(work.reach(*node)))
    };
    nodes.map(level).collect()
}

/// The noise of the rotations of each column; `None` for one that does not turn.
fn of_rotations(work: &Work<'_>, bank: &Bank) -> Vec<Option<Level>> {
    let level = |column: usize| {
        let rotations = work.frames.rotations(column);
        let values: Vec<DQuat> = rotations.map(|rotation| rotation.as_dquat().normalize()).collect();
        Some(Level::new(&curve::<Rotations>(&values, bank.every)?, work.frames.rate))
    };
    (0..work.frames.nodes().len()).map(level).collect()
}

/// Whether most joints that turn have noise: then a joint that looks calmer by chance has it too. Little noise must be
/// in nearly all.
fn is_in_most(levels: &[Option<Level>], weights: &CleanWeights) -> bool {
    let turning = levels.iter().flatten().count() as f64;
    let noisy = |is_shared: bool| {
        let is_noisy = |level: &&Level| is_noise_of_angle(level.noise(false), weights, is_shared);
        levels.iter().flatten().filter(is_noisy).count() as f64
    };
    noisy(false) > MOST * turning || noisy(true) > NEARLY_ALL * turning
}

/// Smooths every joint that has noise.
pub(super) fn remove(work: &mut Work<'_>, bank: &Bank) -> SmoothingOutcome {
    let levels = of_rotations(work, bank);
    let mut done = SmoothingOutcome {
        in_most: is_in_most(&levels, &work.weights),
        ..SmoothingOutcome::default()
    };
    if !done.in_most && (work.frames.len() as f64) < CALM_AFTER * work.frames.rate {
        return done;
    }
    let mut angles = Vec::new();
    for (column, level) in levels.into_iter().enumerate() {
        let node = work.frames.nodes()[column];
        let mut track = work.frames.track(column);
        let turned = level.and_then(|level| rotations(&mut track, work, node, bank, (&level, done.in_most)));
        let moved = positions(&mut track, work, bank, done.in_most);
        if let Some(angle) = turned {
            angles.push(angle.to_degrees());
            done.rotations += 1;
        }
        if let Some(distance) = moved {
            done.distance = done.distance.max(distance);
            done.positions += 1;
        }
        if turned.is_some() || moved.is_some() {
            work.frames.set_track(column, &track);
        }
    }
    angles.sort_by(f64::total_cmp);
    done.angle = angles.get(angles.len() / 2).copied().unwrap_or_default();
    done
}

/// Smooths the rotations of a track, and says how much noise they had, in radians.
fn rotations(
    track: &mut [Trs],
    work: &Work<'_>,
    node: NodeId,
    bank: &Bank,
    (level, in_most): (&Level, bool),
) -> Option<f64> {
    let reach = f64::from(work.reach(node));
    let least = level.noise(in_most);
    if !is_noise_of_angle(least, &work.weights, in_most) || !is_noise_of_distance(least * reach, &work.weights, in_most)
    {
        return None;
    }
    let values: Vec<DQuat> = track.iter().map(|trs| trs.rotation.as_dquat().normalize()).collect();
    let curve = curve::<Rotations>(&values, bank.every)?;
    let noise = least / level.of_white;
    let jerk = bank.jerk(&curve, noise * noise);
    let smoothed = smooth::<Rotations>(&values, &work.missing, curve.of_all(noise), &jerk);
    for (trs, rotation) in track.iter_mut().zip(smoothed) {
        trs.rotation = in_hemisphere_of(trs.rotation, rotation.as_quat());
    }
    Some(noise)
}

/// Smooths the positions of a track, and says how much noise they had, in metres.
fn positions(track: &mut [Trs], work: &Work<'_>, bank: &Bank, in_most: bool) -> Option<f64> {
    let values: Vec<DVec3> = track.iter().map(|trs| trs.translation.as_dvec3()).collect();
    let metres = f64::from(work.metres);
    let is_noise = |noise: f64| is_noise_of_distance(noise * metres, &work.weights, in_most);
    let (smoothed, noise) =
        without_noise::<Positions>(&values, &work.missing, work.frames.rate, bank, in_most, is_noise)?;
    for (trs, position) in track.iter_mut().zip(smoothed) {
        trs.translation = position.as_vec3();
    }
    Some(noise * metres)
}

/// Whether an angle in radians is more than the noise that is left. `in_most` says whether most joints have noise.
pub(super) fn is_noise_of_angle(noise: f64, weights: &CleanWeights, in_most: bool) -> bool {
    noise.to_degrees() >= least(weights.least_angle, in_most)
}

/// Whether a distance in metres is more than the noise that is left. `in_most` says whether most joints have noise.
pub(super) fn is_noise_of_distance(noise: f64, weights: &CleanWeights, in_most: bool) -> bool {
    noise >= least(weights.least_distance, in_most)
}

fn least(weight: f64, in_most: bool) -> f64 {
    if in_most { OF_LEAST * weight } else { weight }
}

/// Values without their noise, and its standard deviation per axis; `None` where `is_noise` says no of that. `in_most`
/// says whether most joints have noise.
pub(super) fn without_noise<S: Values>(
    values: &[S::Value],
    missing: &[bool],
    rate: f64,
    bank: &Bank,
    in_most: bool,
    is_noise: impl Fn(f64) -> bool,
) -> Option<(Vec<S::Value>, f64)> {
    let curve = curve::<S>(values, bank.every)?;
    let level = Level::new(&curve, rate);
    let least = level.noise(in_most);
    if !is_noise(least) {
        return None;
    }
    let noise = least / level.of_white;
    let jerk = bank.jerk(&curve, noise * noise);
    Some((smooth::<S>(values, missing, curve.of_all(noise), &jerk), noise))
}

/// The sum of the steps of a track: a curve of vectors which changes as the track does, in one of `every` frames.
/// `None` where it does not change, or is too short to tell.
fn curve<S: Values>(values: &[S::Value], every: usize) -> Option<Sampled> {
    let mut sum = DVec3::ZERO;
    let mut curve = vec![sum];
    for pair in values.windows(2) {
        sum += S::difference(pair[0], pair[1]);
        curve.push(sum);
    }
    let changes = curve.iter().any(|value| *value != DVec3::ZERO);
    let sampled = (changes && sum.is_finite()).then(|| Sampled::new(&curve, every))?;
    (sampled.curve.len() > SPAN_FRAMES).then_some(sampled)
}

/// The standard deviation of what may be noise in a curve, per axis, and whether it looks like noise, and not like a
/// motion.
struct Level {
    least: f64,
    /// What `least` is of white noise, as a fraction of its standard deviation.
    of_white: f64,
    is_white: bool,
}

/// A curve in spans, whose differences are made one order after the other.
struct Spans<'a> {
    curve: &'a [DVec3],
    /// The frames of a span, and how many spans there are, each beginning in the middle of the one before.
    span: usize,
    count: usize,
}

impl<'a> Spans<'a> {
    fn new(sampled: &'a Sampled, rate: f64) -> Self {
        let (curve, rate) = (&sampled.curve, rate / sampled.every as f64);
        let span = ((SPAN * rate).round() as usize).clamp(SPAN_FRAMES, curve.len());
        Self {
            curve,
            span,
            count: (2 * curve.len() / span).saturating_sub(1).max(1),
        }
    }

    /// For each order from `first` to `last`, and for each span, the standard deviation of the possible noise.
    fn of_orders(&self, first: usize, last: usize) -> Vec<Vec<f64>> {
        let mut differences = self.curve.to_vec();
        let mut found = Vec::new();
        for order in 1..=last {
            for index in 1..differences.len() {
                differences[index - 1] = differences[index] - differences[index - 1];
            }
            differences.pop();
            if order >= first {
                found.push(self.of_order(order, &differences));
            }
        }
        found
    }

    /// The noise that the differences of one order show.
    fn of_order(&self, order: usize, differences: &[DVec3]) -> Vec<f64> {
        // The variance that the difference makes of white noise of variance 1: (2 n)! / (n!)^2.
        let of_white: f64 = (1..=order)
            .map(|n| (2 * n * (2 * n - 1)) as f64 / (n * n) as f64)
            .product();
        let mut of_span = Vec::with_capacity(3 * self.span);
        let mut deviation = |index: usize| {
            let from = (index * self.span / 2).min(differences.len().saturating_sub(self.span));
            let to = (from + self.span).min(differences.len());
            // Bits of numbers that are not negative are in the order of the numbers, and compared faster.
            let sizes = differences[from..to]
                .iter()
                .flat_map(|d| d.abs().to_array().map(f64::to_bits));
            of_span.clear();
            of_span.extend(sizes);
            let rank = of_span.len().saturating_sub(1) / 2;
            let middle = match of_span.is_empty() {
                true => 0.0,
                false => f64::from_bits(*of_span.select_nth_unstable(rank).1),
            };
            middle / MEDIAN_OF_NORMAL / of_white.sqrt()
        };
        (0..self.count).map(&mut deviation).collect()
    }

    /// What the noise may be. With `if_white`, it is measured only where the differences are those of white noise.
    fn level(&self, if_white: bool) -> Level {
        let last = *ORDERS.end();
        let ends = self.of_orders(last - 1, last);
        let [before, after] = [0, 1].map(|end| calm(&ends[end]));
        let mut level = Level {
            least: 0.0,
            of_white: 1.0 - LESS / (self.span as f64).sqrt(),
            is_white: after >= FLAT * before,
        };
        if level.is_white || !if_white {
            let found = [self.of_orders(*ORDERS.start(), last - 2), ends].concat();
            let least = |span: usize| found.iter().map(|spans| spans[span]).fold(f64::INFINITY, f64::min);
            level.least = calm(&(0..self.count).map(least).collect::<Vec<f64>>());
        }
        level
    }
}

impl Level {
    fn new(curve: &Sampled, rate: f64) -> Self {
        Spans::new(curve, rate).level(false)
    }

    /// The least that the noise is, 0 for a motion. Where most joints have noise, the calm one is no proof of a motion.
    fn noise(&self, in_most: bool) -> f64 {
        if self.is_white || in_most { self.least } else { 0.0 }
    }
}

/// The value of a calm span.
fn calm(spans: &[f64]) -> f64 {
    percentile(spans.iter().copied(), CALM, f64::floor).unwrap_or_default()
}
