//! The motion of joints in gaps, while too few of their markers are seen. A curve without jerk connects the last known
//! pose with the next one. The seen markers correct the curve.

use glam::{DQuat, DVec3};

use super::fit::Fit;
use super::model::{Model, Pose};

/// The standard deviation of a joint above which other frames also determine the joint, as a factor of its deviation
/// with all markers.
const LOOSE: f64 = 2.5;

/// The standard deviation below which markers determine a joint well enough, in radians: one degree.
const TOLD: f64 = 0.017;

/// The standard deviation of a joint from the curve in a gap that lasts [`OVER`], in radians. Interpolation errors grow
/// with the square of the time. The arms of a walk swing by 0.5 rad within half a second.
const OFF: f64 = 0.05;

/// The gap length for which [`OFF`] is stated, in seconds: half a swing.
const OVER: f64 = 0.2;

/// The time over which a joint's speed at an end of a gap is measured, in seconds. It averages over the noise of a
/// frame, and is shorter than a swing.
const SPEED_OVER: f64 = 0.04;

/// The joints that markers do not determine, in each frame.
pub(super) struct Gaps {
    /// The standard deviation of each joint with all markers.
    usual: Vec<f64>,
    /// The markers that were seen when `now` was computed.
    pattern: Vec<bool>,
    now: Vec<bool>,
    /// Indexed by joint, then frame.
    pub(super) loose: Vec<Vec<bool>>,
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
            pattern: vec![true; model.markers.len()],
            now: vec![false; model.joints.len()],
            loose: vec![vec![false; frames]; model.joints.len()],
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
            let is_loose = |(own, usual): (f64, &f64)| own > LOOSE * usual && own > TOLD;
            self.now = std::iter::zip(deviations, &self.usual).map(is_loose).collect();
        }
        for (own, is_loose) in std::iter::zip(&mut self.loose, &self.now) {
            own[frame] = *is_loose;
        }
    }

    /// For each frame, the joints that other frames determine better. Each has its rotation relative to its parent, and
    /// the standard deviation of the rotation in radians. `rotations` are relative to the world, indexed by joint, then
    /// frame.
    pub(super) fn between(&self, model: &Model, rotations: &[Vec<DQuat>], rate: f64) -> Vec<Vec<(usize, DQuat, f64)>> {
        let frames = self.loose.first().map_or(0, Vec::len);
        let mut found = vec![Vec::new(); frames];
        let speed_over = ((SPEED_OVER * rate).round() as usize).max(1);
        for (joint, loose) in self.loose.iter().enumerate() {
            let local = |frame: usize| match model.joints[joint].parent {
                None => rotations[joint][frame],
                Some(parent) => rotations[parent][frame].inverse() * rotations[joint][frame],
            };
            for (first, last) in runs(loose) {
                let (Some(before), after) = (first.checked_sub(1), last + 1) else {
                    continue;
                };
                if after >= frames {
                    continue;
                }
                let told_before = loose[..before].iter().rev().take(speed_over).take_while(|own| !**own);
                let told_after = loose[after + 1..].iter().take(speed_over).take_while(|own| !**own);
                let (back, on) = (told_before.count(), told_after.count());
                let curve = Curve::of(&local, (before, back), (after, on));
                let deviation = OFF * ((after - before) as f64 / (rate * OVER)).powi(2);
                for (frame, found) in found.iter_mut().enumerate().take(after).skip(first) {
                    found.push((joint, curve.at(frame), deviation));
                }
            }
        }
        found
    }
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

/// A cubic Hermite curve of rotation vectors from a frame to a later one.
struct Curve {
    first: usize,
    frames: f64,
    from: DQuat,
    turn: DVec3,
    /// Angular velocities at both ends, per frame.
    speeds: [DVec3; 2],
}

impl Curve {
    /// A curve between two frames. The speed at each end is averaged over `back` frames before and `on` frames after.
    fn of(local: &impl Fn(usize) -> DQuat, (first, back): (usize, usize), (last, on): (usize, usize)) -> Self {
        let turn = |from: usize, to: usize| {
            let turn = local(to) * local(from).inverse();
            (if turn.w < 0.0 { -turn } else { turn }).to_scaled_axis()
        };
        let frames = (last - first) as f64;
        let whole = turn(first, last);
        let speed = |from: usize, to: usize| match to - from {
            0 => whole / frames,
            count => turn(from, to) / count as f64,
        };
        Self {
            first,
            frames,
            from: local(first),
            turn: whole,
            speeds: [speed(first - back, first), speed(last, last + on)],
        }
    }

    fn at(&self, frame: usize) -> DQuat {
        let part = (frame - self.first) as f64 / self.frames;
        let (square, cube) = (part * part, part * part * part);
        let turn = self.turn * (3.0 * square - 2.0 * cube)
            + self.speeds[0] * (self.frames * (cube - 2.0 * square + part))
            + self.speeds[1] * (self.frames * (cube - square));
        (DQuat::from_scaled_axis(turn) * self.from).normalize()
    }
}
