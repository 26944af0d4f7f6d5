//! Computes and reduces the displacement of a knee when its ankle is shifted.

use glam::{Quat, Vec3};
use mocap_scene::ik::bend_about_hinge;

use super::leg::LegTrack;
use super::shift;

/// The smallest distance of a knee from the line between hip and ankle that counts, as a fraction of the thigh. With
/// this limit, [`LegTrack::bend_rate`] is finite for a straight leg.
const STRAIGHT: f32 = 0.01;

/// If the ankle is nearer to the hip joint than this fraction of the leg, the direction to the ankle consists only of
/// rounding errors.
const NO_REACH: f32 = 1e-6;

impl LegTrack {
    /// The lengths of thigh and shin, in units of the scene.
    fn bones(&self, frame: usize) -> [f32; 2] {
        let [thigh, knee, ankle] = [&self.thigh, &self.knee, &self.ankle].map(|track| track[frame]);
        [thigh.distance(knee), knee.distance(ankle)]
    }

    /// The sideways displacement of the knee for each unit by which the ankle comes nearer to the hip joint.
    pub(super) fn bend_rate(&self, frame: usize) -> f32 {
        let [a, b] = self.bones(frame);
        let reach = self.thigh[frame].distance(self.ankle[frame]);
        if reach <= NO_REACH * (a + b) {
            return 0.0;
        }
        let along = (reach * reach + a * a - b * b) / (2.0 * reach);
        let aside = aside([a, b], reach).max(STRAIGHT * a);
        (along * (1.0 - along / reach) / aside).abs()
    }

    /// The distance by which the knee moves if the hips are shifted by `carried` and the foot moves to its goal.
    pub(super) fn knee_change(&self, frame: usize, carried: Vec3) -> f32 {
        if carried == Vec3::ZERO && self.shifts[frame] == Vec3::ZERO {
            return 0.0;
        }
        let joints = [&self.thigh, &self.knee, &self.ankle].map(|track| track[frame] + carried);
        let goal = self.ankle[frame] + self.shifts[frame];
        let hinge = self.thigh_rotations[frame] * self.hinge;
        let upper = bend_about_hinge(joints, goal, hinge).map_or(Quat::IDENTITY, |found| found.upper);
        let knee = joints[0] + upper * (joints[1] - joints[0]);
        knee.distance(self.knee[frame])
    }

    /// Raises or lowers a foot a little if the knee of a nearly straight leg would otherwise move sideways. In such a
    /// leg, a change of height by a millimetre moves the knee by centimetres. `carried` has the shifts of the hips.
    pub(super) fn spare_knee(&mut self, carried: &[Vec3], up: Vec3, radius: usize) {
        let to_ankle = (0..self.shifts.len())
            .map(|frame| self.ankle[frame] + self.shifts[frame] - self.thigh[frame] - carried[frame]);
        let to_ankle: Vec<Vec3> = to_ankle.collect();
        let cost = self.weights.knee_height as f32;
        let change = |(frame, offset): (usize, &Vec3)| {
            let bones = self.bones(frame);
            let before = self.ankle[frame].distance(self.thigh[frame]);
            let change = aside(bones, offset.length()) - aside(bones, before);
            let rate = (self.bend_rate(frame) * offset.normalize_or_zero().dot(up)).powi(2);
            change * cost / (cost + rate)
        };
        let changes: Vec<f32> = to_ankle.iter().enumerate().map(change).collect();
        for (frame, change) in shift::smooth(&changes, radius).into_iter().enumerate() {
            if carried[frame] == Vec3::ZERO && self.shifts[frame] == Vec3::ZERO && change == 0.0 {
                continue;
            }
            let (bones, offset) = (self.bones(frame), to_ankle[frame]);
            let before = self.ankle[frame].distance(self.thigh[frame]);
            let reach = reach(bones, aside(bones, before) + change);
            let along = offset.dot(up);
            let square = along * along - offset.length_squared() + reach * reach;
            if along < 0.0 && square >= 0.0 {
                self.shifts[frame] += up * (-along - square.sqrt());
            }
        }
    }
}

/// The distance of the knee from the line between hip and ankle.
fn aside([a, b]: [f32; 2], reach: f32) -> f32 {
    let reach = reach.clamp((a - b).abs().max(NO_REACH * (a + b)), a + b);
    let along = (reach * reach + a * a - b * b) / (2.0 * reach);
    (a * a - along * along).max(0.0).sqrt()
}

/// The distance between hip and ankle at which the distance of the knee from their line is `aside`.
fn reach([a, b]: [f32; 2], aside: f32) -> f32 {
    let aside = aside.clamp(0.0, a.min(b));
    (a * a - aside * aside).sqrt() + (b * b - aside * aside).sqrt()
}
