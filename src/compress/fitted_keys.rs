//! Key frame reduction with fitted keys, for a track with its own key frames.
//!
//! A key need not equal the target at its frame: any value within the tolerance works. A line through two targets has
//! errors on only one side of a curve. A line near the two targets has errors on both sides, and so spans more frames.
//! On a parabola, the line is longer by a factor of the square root of 2.
//!
//! The lines from a key that are within the tolerance at all frames so far form a cone. The cone gets narrower with
//! each frame, and the line ends when the cone is empty (J. Sklansky and V. Gonzalez, "Fast polygonal approximation of
//! digitized curves", Pattern Recognition 12, 1980; J. O'Rourke, "An on-line algorithm for fitting straight lines
//! between data ranges", Communications of the ACM 24, 1981).
//!
//! Here values have three components. So the cone is not computed; the algorithm keeps one line within the cone. If
//! this line is outside the tolerance at a frame, projections find another line within it (the method of L. M. Bregman,
//! 1965, for a common point of convex sets).
//!
//! The longest possible line may end where the next line must be short. So the algorithm tries several of the line's
//! last frames as the end, and takes the frame from which the next line gets farthest. Then each key moves towards the
//! least-squares fit of the two lines that it joins, as far as the tolerance allows. With these smaller errors, joints
//! further down have less to compensate for.

use glam::{Quat, Vec3};
use mocap_scene::math::cube_root::cube_root;
use mocap_scene::math::quaternion::{exp, log, nlerp};

use super::compensation::Target;
use super::error_metric::LeverArms;
use super::key_frames::{KeyFrames, alpha, between};
use super::quantize::{QuantizedRotation, QuantizedTranslation, RotationFormat, TranslationFormat};

// The constants below are tuned on the fixtures. The tolerance holds with any other values.

/// The number of possible end frames of a line from which the next line is tried.
const ENDS: usize = 4;
/// The largest number of frames of a line, which bounds the time for one line.
const LONGEST: usize = 1024;
/// The largest number of projections to find a line within the tolerance.
const PROJECTIONS: usize = 4;
/// The target of projections as a fraction of the tolerance. A value below 1 needs fewer projections.
const GOAL: f32 = 0.99;
/// The angle that rounding to 16 bits may add to a rotation, in radians.
const INT16_ROUNDING: f32 = 3e-5;
/// The largest distance between the results of a reader with nlerp and a reader with slerp, between two keys of a
/// rotation. The distance is measured at the end of the chain of descendants, as a fraction of the tolerance. Joints
/// further down compensate for nlerp only.
pub const NLERP_SHARE: f32 = 0.03;
/// The largest angle between nlerp and slerp, as a fraction of the cube of a small angle between two keys. It is the
/// maximum of `x (1 - x) (1 - 2 x) / 24` for x from 0 to 1: the square root of 3, divided by 432.
pub const NLERP_FROM_SLERP: f32 = 0.004;

/// A track to which keys are fitted.
pub trait Fit {
    /// A value in the form in which a key stores it.
    type Key: Copy;
    /// A value of the track, as a reader decodes it.
    type Value: Copy;

    fn frames(&self) -> usize;

    fn target(&self, frame: usize) -> Self::Value;

    /// The stored value nearest to a decoded one.
    fn quantize(&self, value: Self::Value, previous: Option<&Self::Key>) -> Self::Key;

    fn value(key: &Self::Key) -> Self::Value;

    fn displaced(value: Self::Value, by: Vec3) -> Self::Value;

    fn interpolate(from: Self::Value, to: Self::Value, alpha: f32) -> Self::Value;

    /// The displacement from a value to the target at a frame.
    fn displacement(&self, from: Self::Value, frame: usize) -> Vec3;

    /// The longest allowed displacement from one key to the next.
    fn longest(&self) -> f32;

    /// The smallest change of a displacement that brings the displacement within the tolerance at a frame. `target` is
    /// the displacement to the target. `None` if the displacement is within the tolerance already.
    fn correction(&self, frame: usize, target: Vec3, displacement: Vec3) -> Option<Vec3>;

    fn is_within(&self, frame: usize, value: Self::Value) -> bool;
}

/// Fits the rotations of a joint.
pub struct RotationFit<'a> {
    targets: &'a [Target],
    arms: &'a LeverArms,
    format: RotationFormat,
    tolerance: f32,
    /// The tolerance minus the allowance for rounding.
    before_rounding: f32,
    longest: f32,
}

impl<'a> RotationFit<'a> {
    pub fn new(targets: &'a [Target], arms: &'a LeverArms, format: RotationFormat, tolerance: f32) -> Self {
        let rounding = match format {
            RotationFormat::Int16 => arms.longest * INT16_ROUNDING,
            _ => 0.0,
        };
        Self {
            targets,
            arms,
            format,
            tolerance,
            before_rounding: (tolerance - rounding).max(0.5 * tolerance),
            longest: cube_root(tolerance * NLERP_SHARE / (arms.chain_length * NLERP_FROM_SLERP)),
        }
    }
}

/// A displacement is a rotation vector in the axes of the joint at the key. So a rotation at constant speed is a
/// straight line.
impl Fit for RotationFit<'_> {
    type Key = QuantizedRotation;
    type Value = Quat;

    fn frames(&self) -> usize {
        self.targets.len()
    }

    fn target(&self, frame: usize) -> Quat {
        self.targets[frame].rotation
    }

    fn quantize(&self, value: Quat, previous: Option<&QuantizedRotation>) -> QuantizedRotation {
        self.format.quantize(value, previous)
    }

    fn value(key: &QuantizedRotation) -> Quat {
        key.value
    }

    #[inline]
    fn displaced(value: Quat, by: Vec3) -> Quat {
        value * exp(by)
    }

    fn interpolate(from: Quat, to: Quat, alpha: f32) -> Quat {
        nlerp(from, to, alpha)
    }

    #[inline]
    fn displacement(&self, from: Quat, frame: usize) -> Vec3 {
        log(from.conjugate() * self.targets[frame].rotation)
    }

    fn longest(&self) -> f32 {
        self.longest
    }

    #[inline]
    fn correction(&self, frame: usize, target: Vec3, displacement: Vec3) -> Option<Vec3> {
        // Converts from the axes at the key to the axes at the frame: the first terms of the right Jacobian of the
        // exponential map.
        let off = displacement - target;
        let cross = target.cross(off);
        let off = off - cross * 0.5 + target.cross(cross) * (1.0 / 6.0);
        let (largest, goal) = (self.before_rounding, self.before_rounding * GOAL);
        let change = self.targets[frame].correction(self.arms, off, largest, goal)?;
        Some(change + target.cross(change) * 0.5)
    }

    fn is_within(&self, frame: usize, value: Quat) -> bool {
        self.targets[frame].error(self.arms, value) <= self.tolerance
    }
}

/// Fits the translations of a joint.
pub struct TranslationFit<'a> {
    pub targets: &'a [Vec3],
    pub format: TranslationFormat,
    pub tolerance: f32,
}

impl Fit for TranslationFit<'_> {
    type Key = QuantizedTranslation;
    type Value = Vec3;

    fn frames(&self) -> usize {
        self.targets.len()
    }

    fn target(&self, frame: usize) -> Vec3 {
        self.targets[frame]
    }

    fn quantize(&self, value: Vec3, previous: Option<&QuantizedTranslation>) -> QuantizedTranslation {
        self.format.quantize(value, previous, self.tolerance)
    }

    fn value(key: &QuantizedTranslation) -> Vec3 {
        key.value
    }

    fn displaced(value: Vec3, by: Vec3) -> Vec3 {
        value + by
    }

    fn interpolate(from: Vec3, to: Vec3, alpha: f32) -> Vec3 {
        from.lerp(to, alpha)
    }

    fn displacement(&self, from: Vec3, frame: usize) -> Vec3 {
        self.targets[frame] - from
    }

    fn longest(&self) -> f32 {
        f32::INFINITY
    }

    fn correction(&self, _: usize, target: Vec3, displacement: Vec3) -> Option<Vec3> {
        let off = displacement - target;
        let distance = off.length();
        (distance > self.tolerance).then(|| off * (self.tolerance * GOAL / distance - 1.0))
    }

    fn is_within(&self, frame: usize, value: Vec3) -> bool {
        value.distance(self.targets[frame]) <= self.tolerance
    }
}

/// The key frames of a track, and its keys. At the frames between two keys, the error is within the tolerance. If no
/// line from a key fits, the next frame gets a key with its rounded target. Only at a key with a rounded target, the
/// error may be larger than the tolerance.
pub fn fit<F: Fit>(fit: &F, ticks: &[f64]) -> (KeyFrames, Vec<F::Key>) {
    let mut keys = vec![fit.quantize(fit.target(0), None)];
    let mut key_frames = vec![0];
    let last = fit.frames().saturating_sub(1);
    let mut search = Search {
        fit,
        ticks,
        seen: Vec::new(),
    };
    let (mut from, mut key) = (0, keys[0]);
    let mut line = search.longest_line(from, F::value(&key));
    while from < last {
        let end = search.best_end(from, &key, line);
        (from, key, line) = (end.frame, end.key, end.next);
        key_frames.push(from as u32);
        keys.push(key);
    }
    search.smooth(&key_frames, &mut keys);
    (key_frames, keys)
}

/// A line that starts at a key.
#[derive(Clone, Copy)]
struct Line {
    /// The last frame at which the line is within the tolerance.
    last: usize,
    /// The displacement per tick.
    rise: Vec3,
}

/// The end of a line, and the line that starts there.
struct End<Key> {
    frame: usize,
    key: Key,
    next: Line,
}

struct Search<'a, F: Fit> {
    fit: &'a F,
    ticks: &'a [f64],
    /// For the frames after a key, the ticks from the key and the displacement to the target.
    seen: Vec<(f32, Vec3)>,
}

impl<F: Fit> Search<'_, F> {
    fn ticks_between(&self, from: usize, to: usize) -> f32 {
        (self.ticks[to] - self.ticks[from]) as f32
    }

    /// The longest line that starts at a value. The displacements along the line are within the tolerance; the caller
    /// checks whether the keys are too.
    fn longest_line(&mut self, from: usize, start: F::Value) -> Line {
        self.seen.clear();
        let longest = self.fit.longest();
        let (mut rise, mut sum, mut squares) = (Vec3::ZERO, Vec3::ZERO, 0.0);
        let last = (self.fit.frames() - 1).min(from + LONGEST);
        for to in from + 1..=last {
            let ticks = self.ticks_between(from, to);
            let target = self.fit.displacement(start, to);
            self.seen.push((ticks, target));
            sum += target * ticks;
            squares += ticks * ticks;
            if to == from + 1 {
                rise = target / ticks;
                continue;
            }
            let line = Line { last: to - 1, rise };
            if target.length_squared() > longest * longest {
                return line;
            }
            if self.fit.correction(to, target, rise * ticks).is_some() {
                match self.project(from, sum / squares) {
                    Some(found) => rise = found,
                    None => return line,
                }
            }
        }
        Line { last, rise }
    }

    /// A rise that keeps the line within the tolerance at all frames in `seen`. The projections start from `rise`.
    fn project(&self, from: usize, mut rise: Vec3) -> Option<Vec3> {
        let mut before = self.seen.len() - 1;
        for _ in 0..PROJECTIONS {
            // The frame of the last projection is the most likely one to exclude the rise again.
            let mut indices = std::iter::once(before).chain((0..self.seen.len()).rev());
            let excluded = indices.find_map(|index| {
                let (ticks, target) = self.seen[index];
                let change = self.fit.correction(from + 1 + index, target, rise * ticks)?;
                Some((index, change / ticks))
            });
            let Some((index, change)) = excluded else {
                return Some(rise);
            };
            rise += change;
            before = index;
        }
        None
    }

    /// The frame, among the last frames of a line, from which the next line gets farthest.
    fn best_end(&mut self, from: usize, key: &F::Key, line: Line) -> End<F::Key> {
        let mut ends = Vec::with_capacity(ENDS);
        let mut rest = from + 1..line.last + 1;
        while !rest.is_empty() {
            for frame in rest.by_ref().rev().take(ENDS) {
                let end = F::displaced(F::value(key), line.rise * self.ticks_between(from, frame));
                let next = self.longest_line(frame, end);
                ends.push((frame, end, next));
                if next.last + 1 == self.fit.frames() {
                    break;
                }
            }
            // A stable sort: on a tie, the later end wins.
            ends.sort_by_key(|(_, _, next)| std::cmp::Reverse(next.last));
            for (frame, end, next) in ends.drain(..) {
                let end = self.fit.quantize(end, Some(key));
                if self.fit.is_within(frame, F::value(&end)) && self.fits((from, key), (frame, &end)) {
                    return End { frame, key: end, next };
                }
            }
            // With rounding or nlerp, the line is not within the tolerance at any of these ends. So try ends in its
            // first half.
            rest.end = usize::midpoint(rest.start, rest.end);
        }
        let frame = from + 1;
        let key = self.fit.quantize(self.fit.target(frame), Some(key));
        let next = self.longest_line(frame, F::value(&key));
        End { frame, key, next }
    }

    /// Whether all frames between two keys are within the tolerance.
    fn fits(&self, (from, start): (usize, &F::Key), (to, end): (usize, &F::Key)) -> bool {
        let (start, end) = (F::value(start), F::value(end));
        between(self.ticks, from, to).all(|(frame, alpha)| self.fit.is_within(frame, F::interpolate(start, end, alpha)))
    }

    /// Moves each key towards the least squared errors of the frames between its neighbouring keys.
    fn smooth(&self, key_frames: &[u32], keys: &mut [F::Key]) {
        for index in 0..keys.len() {
            let (at, key) = (key_frames[index] as usize, keys[index]);
            let beside = |index: Option<usize>| {
                let index = index?;
                Some((*key_frames.get(index)? as usize, keys[index]))
            };
            let (before, after) = (beside(index.checked_sub(1)), beside(index.checked_add(1)));
            let mut sum = self.fit.displacement(F::value(&key), at);
            let mut squares = 1.0;
            for (end, other) in [before, after].into_iter().flatten() {
                for frame in at.min(end) + 1..at.max(end) {
                    let weight = alpha(self.ticks, end, at, frame);
                    let value = F::interpolate(F::value(&other), F::value(&key), weight);
                    sum += self.fit.displacement(value, frame) * weight;
                    squares += weight * weight;
                }
            }
            // Try the full distance, or half of it.
            let moved = |fraction: f32| {
                let value = F::displaced(F::value(&key), sum * (fraction / squares));
                self.fit.quantize(value, Some(&key))
            };
            let fits = |moved: &F::Key| {
                self.fit.is_within(at, F::value(moved))
                    && before.is_none_or(|(end, other)| self.fits((end, &other), (at, moved)))
                    && after.is_none_or(|(end, other)| self.fits((at, moved), (end, &other)))
            };
            if let Some(moved) = [1.0, 0.5].into_iter().map(moved).find(fits) {
                keys[index] = moved;
            }
        }
    }
}
