//! The motion of joints in gaps, while too few of their markers are seen. A curve without jerk connects the last known
//! pose with the next one. The seen markers correct the curve.

use glam::{DQuat, DVec3};

use super::fit::{Fit, SMALLEST_STEP};
use super::model::{Model, Pose};

/// The standard deviation of a joint above which other frames also determine the joint, as a factor of its deviation
/// with all markers.
const LOOSE: f64 = 2.5;

/// The standard deviation below which markers determine a joint well enough, in radians: one degree.
const TOLD: f64 = 0.017;

/// The standard deviation of a joint from the curve in the middle of a gap that lasts [`OVER`], in radians.
/// Interpolation errors grow with the square of the time. The arms of a walk swing by 0.5 rad within half a second.
const OFF: f64 = 0.05;

/// The gap length for which [`OFF`] is stated, in seconds: half a swing.
const OVER: f64 = 0.2;

/// The time over which a joint's speed at an end of a gap is measured, in seconds. It averages over the noise of a
/// frame, and is shorter than a swing.
const SPEED_OVER: f64 = 0.04;

/// The longest time in which a joint keeps some of its speed at an end of a gap, in seconds: half a swing of an arm or
/// leg. After this time, the joint may have turned back.
const SWING: f64 = 0.5;

/// The joints that markers do not determine, in each frame.
pub(super) struct Gaps {
    /// The standard deviation of each joint with all markers.
    usual: Vec<f64>,
    /// The joints that move markers.
    marked: Vec<bool>,
    /// The markers that were seen when `now` was computed.
    pattern: Vec<bool>,
    now: Vec<bool>,
    /// Indexed by joint, then frame.
    pub(super) loose: Vec<Vec<bool>>,
    /// The frames in which no marker is seen.
    hidden: Vec<bool>,
}

impl Gaps {
    pub(super) fn new(model: &Model, pose: &Pose, frames: usize) -> Self {
        let mut fit = Fit::default();
        model.world(pose, &mut fit.world);
        let all: Vec<Option<DVec3>> = (0..model.markers.len())
            .map(|marker| Some(model.marker(marker, &fit.world)))
            .collect();
        Self {
            usual: fit.deviations(model, pose, &all),
            marked: moving(model, (0..model.markers.len()).map(|_| true)),
            pattern: vec![true; model.markers.len()],
            now: vec![false; model.joints.len()],
            loose: vec![vec![false; frames]; model.joints.len()],
            hidden: vec![false; frames],
        }
    }

    /// Notes the joints that the markers of a frame hardly determine. `distances` has the distances of the seen
    /// markers.
    pub(super) fn note(
        &mut self,
        (model, fit): (&Model, &mut Fit),
        pose: &Pose,
        (frame, distances): (usize, &[Option<f64>]),
    ) {
        let counts = |distance: &Option<f64>| distance.is_some_and(|distance| distance < model.weights.outlier);
        if !distances.iter().map(counts).eq(self.pattern.iter().copied()) {
            self.pattern = distances.iter().map(counts).collect();
            let expected = self.pattern.iter().enumerate();
            let seen: Vec<Option<DVec3>> = expected
                .map(|(marker, is_seen)| is_seen.then(|| model.marker(marker, &fit.world)))
                .collect();
            let deviations = fit.deviations(model, pose, &seen);
            let seen = moving(model, self.pattern.iter().copied());
            // The usual deviation of a neck is large, because head markers only show the rotation of neck and head
            // together.
            let is_loose = |joint: usize| {
                let (own, usual) = (deviations[joint], self.usual[joint]);
                own > LOOSE * usual && own > TOLD || self.marked[joint] && !seen[joint]
            };
            self.now = (0..deviations.len()).map(is_loose).collect();
        }
        self.hidden[frame] = !self.pattern.contains(&true);
        for (own, is_loose) in std::iter::zip(&mut self.loose, &self.now) {
            own[frame] = *is_loose;
        }
    }

    /// For each frame, the joints that other frames determine better. Each has its rotation relative to its parent, and
    /// the standard deviation of the rotation in radians. `rotations` are relative to the world, indexed by joint, then
    /// frame.
    pub(super) fn between(&self, model: &Model, rotations: &[Vec<DQuat>], rate: f64) -> Vec<Vec<(usize, DQuat, f64)>> {
        let frames = self.hidden.len();
        let mut found = vec![Vec::new(); frames];
        for (joint, loose) in self.loose.iter().enumerate() {
            let local = |frame: usize| match model.joints[joint].parent {
                None => rotations[joint][frame],
                Some(parent) => rotations[parent][frame].inverse() * rotations[joint][frame],
            };
            let turn = |from: usize, to: usize| {
                let turn = local(to) * local(from).inverse();
                (if turn.w < 0.0 { -turn } else { turn }).to_scaled_axis()
            };
            for gap in runs(loose) {
                let Some(curve) = Curve::of(turn, (loose, gap), rate, SWING * rate) else {
                    continue;
                };
                for (frame, found) in found.iter_mut().enumerate().take(gap.1 + 1).skip(gap.0) {
                    let rotation = DQuat::from_scaled_axis(curve.at(frame)) * local(curve.from);
                    let middle = curve.middle(frame) / (rate * OVER);
                    let deviation = (OFF * middle * middle).clamp(SMALLEST_STEP, model.weights.hold);
                    found.push((joint, rotation.normalize(), deviation));
                }
            }
        }
        found
    }

    /// Moves the root along a curve while no marker is seen.
    pub(super) fn move_root(&self, roots: &mut [DVec3], rate: f64) {
        for gap in runs(&self.hidden) {
            let way = |from: usize, to: usize| roots[to] - roots[from];
            // A body keeps its speed longer than a limb.
            if let Some(curve) = Curve::of(way, (&self.hidden, gap), rate, f64::INFINITY) {
                for frame in gap.0..=gap.1 {
                    roots[frame] = roots[curve.from] + curve.at(frame);
                }
            }
        }
    }
}

/// The joints that move at least one of the seen markers.
fn moving(model: &Model, seen: impl Iterator<Item = bool>) -> Vec<bool> {
    let mut moving = vec![false; model.joints.len()];
    for (marker, _) in std::iter::zip(&model.markers, seen).filter(|(_, is_seen)| *is_seen) {
        model.chain(marker.joint).iter().for_each(|joint| moving[*joint] = true);
    }
    moving
}

/// The runs of loose frames, each as first and last frame.
pub(super) fn runs(loose: &[bool]) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for frame in (0..loose.len()).filter(|frame| loose[*frame]) {
        match runs.last_mut() {
            Some((_, last)) if *last + 1 == frame => *last = frame,
            _ => runs.push((frame, frame)),
        }
    }
    runs
}

/// A cubic Hermite curve of vectors through a gap. In a long gap, the speeds at the ends have no effect on the middle.
/// In a gap at an end of the take, the curve comes to rest.
struct Curve {
    /// The frame from which the vectors of the curve start.
    from: usize,
    before: Option<usize>,
    after: Option<usize>,
    /// The number of frames after which the speed at an end has no effect.
    swing: f64,
    /// The vector from the frame before the gap to the frame after the gap.
    whole: DVec3,
    /// The speeds at both ends, per frame.
    speeds: [DVec3; 2],
}

impl Curve {
    /// A curve through a gap, which is a run of `loose` frames. `difference` has the vector between two frames. The
    /// speed at an end has an effect for at most `swing` frames. `None` if the gap is the whole take.
    fn of(
        difference: impl Fn(usize, usize) -> DVec3,
        (loose, (first, last)): (&[bool], (usize, usize)),
        rate: f64,
        swing: f64,
    ) -> Option<Self> {
        let (before, after) = (
            first.checked_sub(1),
            Some(last + 1).filter(|after| *after < loose.len()),
        );
        let (whole, frames) = match (before, after) {
            (Some(before), Some(after)) => (difference(before, after), (after - before) as f64),
            _ => (DVec3::ZERO, f64::INFINITY),
        };
        let speed_over = ((SPEED_OVER * rate).round() as usize).max(1);
        let speed = |from: usize, to: usize| match to - from {
            0 => whole / frames,
            count => difference(from, to) / count as f64,
        };
        let speed_before = before.map(|before| {
            let told = loose[..before].iter().rev().take(speed_over);
            speed(before - told.take_while(|own| !**own).count(), before)
        });
        let speed_after = after.map(|after| {
            let told = loose[after + 1..].iter().take(speed_over);
            speed(after, after + told.take_while(|own| !**own).count())
        });
        Some(Self {
            from: before.or(after)?,
            before,
            after,
            swing: swing.min(frames),
            whole,
            speeds: [speed_before, speed_after].map(Option::unwrap_or_default),
        })
    }

    /// The numbers of frames to both ends of the gap. The end of the take is infinitely far.
    fn ends(&self, frame: usize) -> [f64; 2] {
        let distance = |end: Option<usize>| end.map_or(f64::INFINITY, |end| end.abs_diff(frame) as f64);
        [self.before, self.after].map(distance)
    }

    /// The length of a gap, in frames, in whose middle a curve is as wrong as here. The error of a cubic curve is
    /// proportional to the square of the product of the distances to both ends.
    fn middle(&self, frame: usize) -> f64 {
        let [before, after] = self.ends(frame);
        4.0 / (before.recip() + after.recip())
    }

    fn at(&self, frame: usize) -> DVec3 {
        let [before, after] = self.ends(frame);
        let swung = |passed: f64| match passed < self.swing {
            true => passed * (1.0 - passed / self.swing).powi(2),
            false => 0.0,
        };
        let part = match self.before.is_some() && self.after.is_some() {
            true => before / (before + after),
            false => 0.0,
        };
        self.whole * (part * part * (3.0 - 2.0 * part)) + self.speeds[0] * swung(before) - self.speeds[1] * swung(after)
    }
}
