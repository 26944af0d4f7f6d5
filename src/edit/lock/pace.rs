//! Compares the speed of a foot with and without the lock, and reduces the lock in frames in which the lock adds too
//! much speed.
//!
//! After a contact, a locked foot has to catch up with its swing. A leg that is too short pulls at a locked foot. Both
//! make the foot faster, which must not be visible. The limits are multiples of the speed and the acceleration without
//! the lock. If a joint of the foot exceeds a limit, the correction around this frame is reduced, round by round, until
//! the joint is within its limits.

use glam::Vec3;
use mocap_scene::pose::Pose;
use mocap_scene::scene::NodeId;

use super::leg::LegTrack;
use super::shift::envelope;
use super::weights::FootLockWeights;
use crate::frames::Frames;

/// After this number of rounds, the lock is removed around the frames that exceed a limit. After twice this number, the
/// lock is removed in the whole motion. So the search always ends.
const ROUNDS: usize = 10;

/// The joints of one foot over time, with the lock and without.
pub(super) struct Pace {
    /// The ankle and the ball of the foot.
    joints: Vec<NodeId>,
    free: Vec<Vec<Vec3>>,
    changed: Vec<Vec<Vec3>>,
    /// For each joint and frame, the largest allowed speed in m/s and acceleration in m/s^2.
    most: Vec<[Vec<f32>; 2]>,
    /// For each frame, the fraction of the change that is made.
    weights: Vec<f32>,
    /// For each frame, whether the last round changed its weight.
    is_new: Vec<bool>,
    rate: f32,
    metres: f32,
    around: usize,
    ease: usize,
    rounds: usize,
    weights_of_lock: FootLockWeights,
    /// The largest ratios of speeds and accelerations in the last round.
    pub(super) ratios: [f32; 2],
}

impl Pace {
    pub(super) fn new(leg: &LegTrack, frames: &Frames) -> Self {
        let joints: Vec<NodeId> = leg.points.iter().map(|point| point.node).collect();
        Self {
            free: joints.iter().map(|_| Vec::with_capacity(frames.len())).collect(),
            changed: Vec::new(),
            most: Vec::new(),
            weights: vec![1.0; frames.len()],
            is_new: vec![true; frames.len()],
            rate: frames.rate as f32,
            metres: 1.0,
            around: frames.frames_in(leg.weights.around),
            ease: frames.frames_in(leg.weights.ease),
            rounds: 0,
            weights_of_lock: leg.weights,
            ratios: [0.0; 2],
            joints,
        }
    }

    /// Adds the next frame without the lock.
    pub(super) fn see(&mut self, pose: &Pose) {
        for (track, joint) in self.free.iter_mut().zip(&self.joints) {
            track.push(pose.position(*joint));
        }
    }

    /// Computes the limits for every frame. `metres` are the metres in one unit of the scene.
    pub(super) fn compare_with_free(&mut self, metres: f32) {
        self.metres = metres;
        self.changed.clone_from(&self.free);
        let FootLockWeights {
            moving,
            still_speed,
            still_acceleration,
            ..
        } = self.weights_of_lock;
        let moving = moving as f32;
        let allowed = |values: Vec<f32>, still: f32| -> Vec<f32> {
            let floor = still.max(moving * values.iter().copied().fold(0.0, f32::max));
            let highest = highest_around(&values, self.around);
            highest.map(|highest| highest.max(floor)).collect()
        };
        let most = self.free.iter().map(|track| {
            let [speeds, accelerations] = self.paces(track);
            [
                allowed(speeds, still_speed as f32),
                allowed(accelerations, still_acceleration as f32),
            ]
        });
        self.most = most.collect();
    }

    /// Sets a frame with the lock.
    pub(super) fn see_changed(&mut self, frame: usize, pose: &Pose) {
        for (track, joint) in self.changed.iter_mut().zip(&self.joints) {
            track[frame] = pose.position(*joint);
        }
    }

    /// The fraction of the change that is applied in a frame.
    pub(super) fn weight(&self, frame: usize) -> f32 {
        self.weights[frame]
    }

    /// Whether a frame must be changed again.
    pub(super) fn is_new(&self, frame: usize) -> bool {
        self.is_new[frame]
    }

    /// The number of frames in which the lock is relaxed.
    pub(super) fn frames_given_way(&self) -> usize {
        self.weights.iter().filter(|weight| **weight < 1.0).count()
    }

    /// Reduces the change around frames in which a joint exceeds its limit. Returns `None` if no joint does.
    pub(super) fn give_way(&mut self) -> Option<()> {
        let mut excess = vec![0.0_f32; self.weights.len()];
        self.ratios = [0.0; 2];
        self.is_new.fill(false);
        let weights = self.weights_of_lock;
        let (aim, least) = (weights.aim as f32, weights.least_step as f32);
        let ratios = [weights.speed_ratio, weights.acceleration_ratio].map(|ratio| ratio as f32);
        for (track, most) in self.changed.iter().zip(&self.most) {
            let kinds = self.paces(track).into_iter().zip(most).zip(ratios);
            for (kind, ((values, most), largest)) in kinds.enumerate() {
                for ((excess, value), most) in excess.iter_mut().zip(values).zip(most) {
                    self.ratios[kind] = self.ratios[kind].max(value / most);
                    *excess = excess.max(value / (aim * largest * most));
                }
            }
        }
        if excess.iter().all(|excess| *excess <= 1.0) || self.weights.iter().all(|weight| *weight == 0.0) {
            return None;
        }
        self.rounds += 1;
        let less = |excess: &f32| match *excess > 1.0 {
            _ if self.rounds > 2 * ROUNDS => 1.0,
            true if self.rounds > ROUNDS => 1.0,
            true => (1.0 - 1.0 / excess).max(least),
            false => 0.0,
        };
        let less: Vec<f32> = excess.iter().map(less).collect();
        for ((weight, is_new), less) in self
            .weights
            .iter_mut()
            .zip(&mut self.is_new)
            .zip(envelope(&less, self.ease))
        {
            *is_new = less > 0.0 && *weight > 0.0;
            *weight *= 1.0 - less.min(1.0);
        }
        Some(())
    }

    /// The speed and the acceleration in each frame, by central differences.
    fn paces(&self, track: &[Vec3]) -> [Vec<f32>; 2] {
        let [mut speeds, mut accelerations] = [vec![0.0; track.len()], vec![0.0; track.len()]];
        for frame in 1..track.len().saturating_sub(1) {
            let [from, to] = [track[frame] - track[frame - 1], track[frame + 1] - track[frame]];
            speeds[frame] = (from + to).length() * self.metres * self.rate / 2.0;
            accelerations[frame] = (to - from).length() * self.metres * self.rate.powi(2);
        }
        [speeds, accelerations]
    }
}

/// For each value, the largest value within `radius`.
fn highest_around(values: &[f32], radius: usize) -> impl Iterator<Item = f32> {
    (0..values.len()).map(move |index| {
        let around = index.saturating_sub(radius)..=(index + radius).min(values.len() - 1);
        values[around].iter().copied().fold(0.0, f32::max)
    })
}
