//! Removes noise from a live motion.

use std::collections::VecDeque;

use glam::{DQuat, DVec3};
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::pose::Trs;

use super::noise::{is_noise_of_angle, without_noise};
use super::pace::{Bank, frames_for_one};
use super::smoother::{Positions, Rotations};
use crate::clean_weights::CleanWeights;

/// The smoother uses this much of the past, as a multiple of the delay. Earlier frames hardly have an effect.
const PAST: f64 = 2.0;

/// The shortest past in seconds: the estimate of noise needs two spans of half a second.
const LEAST_PAST: f64 = 1.0;
/// The smallest number of past frames that the smoother uses. The estimate of noise needs this number of frames.
const LEAST_FRAMES: usize = 24;

/// Removes noise from a live motion, frame by frame, with a delay. This is the part `noise` of [`Clean`](crate::Clean),
/// with a fixed delay. Positions are in metres.
///
/// ```
/// use mocap::Trs;
/// use mocap::edit::LiveClean;
///
/// let mut live = LiveClean::new(60.0, 0.5)?;
/// let still = [Trs::IDENTITY];
/// let given: Vec<_> = (0..40).filter_map(|_| live.push(&still)).collect();
/// assert_eq!(given.len(), 10); // the first 30 frames are half a second
/// assert_eq!(live.finish().len(), 30);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct LiveClean {
    rate: f64,
    delay: usize,
    longest: usize,
    bank: Bank,
    seen: VecDeque<Vec<Trs>>,
    /// The number of frames in `seen` that have already been returned.
    given: usize,
}

impl LiveClean {
    /// A cleaner for a motion of `rate` frames per second. It returns each frame `delay` seconds later.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the rate is not above 0 or the delay is negative. Both must be finite, and the delay
    /// at most 10 seconds and 10,000 frames.
    pub fn new(rate: f64, delay: f64) -> Result<Self> {
        positive(Code::InvalidValue, "rate", rate)?;
        not_negative(Code::InvalidValue, "delay", delay)?;
        not_negative(Code::InvalidValue, "10 seconds less the delay", 10.0 - delay)?;
        not_negative(Code::InvalidValue, "10,000 frames less the delay", 1e4 - delay * rate)?;
        let delay_frames = (delay * rate).round() as usize;
        let past = ((PAST * delay).max(LEAST_PAST) * rate).round().min(3e4) as usize;
        Ok(Self {
            rate,
            delay: delay_frames,
            longest: (delay_frames + past).max(LEAST_FRAMES),
            bank: Bank::new(rate, frames_for_one(rate, 1), CleanWeights::default().smoothing),
            seen: VecDeque::new(),
            given: 0,
        })
    }

    /// Takes the next frame: the transforms of all joints relative to their parents. Returns the cleaned frame that is
    /// older by the delay, or `None` if the motion is still shorter than the delay. If the number of joints changes, a
    /// new motion begins.
    pub fn push(&mut self, joints: &[Trs]) -> Option<Vec<Trs>> {
        if self.seen.back().is_some_and(|last| last.len() != joints.len()) {
            self.seen.clear();
            self.given = 0;
        }
        self.seen.push_back(joints.to_vec());
        if self.seen.len() > self.longest {
            self.seen.pop_front();
            self.given = self.given.saturating_sub(1);
        }
        (self.seen.len() > self.given + self.delay).then(|| {
            self.given += 1;
            self.frame(self.given - 1)
        })
    }

    /// Ends the motion, and returns the cleaned frames that were not yet returned.
    pub fn finish(&mut self) -> Vec<Vec<Trs>> {
        let left = (self.given..self.seen.len()).map(|frame| self.frame(frame)).collect();
        self.seen.clear();
        self.given = 0;
        left
    }

    /// Frame `frame` of `seen`, cleaned.
    fn frame(&self, frame: usize) -> Vec<Trs> {
        let joints = 0..self.seen[frame].len();
        joints.map(|joint| self.joint(joint, frame)).collect()
    }

    fn joint(&self, joint: usize, frame: usize) -> Trs {
        let mut trs = self.seen[frame][joint];
        let track = self.seen.iter().map(|row| row[joint]);
        let rotations: Vec<DQuat> = track.clone().map(|trs| trs.rotation.as_dquat().normalize()).collect();
        let positions: Vec<DVec3> = track.map(|trs| trs.translation.as_dvec3()).collect();
        let (rate, bank) = (self.rate, &self.bank);
        let weights = CleanWeights::default();
        let is_noise = |noise: f64| is_noise_of_angle(noise, &weights, false);
        if let Some((smoothed, _)) = without_noise::<Rotations>(&rotations, &[], rate, bank, false, is_noise) {
            trs.rotation = in_hemisphere_of(trs.rotation, smoothed[frame].as_quat());
        }
        let is_noise = |noise: f64| noise >= weights.least_distance;
        if let Some((smoothed, _)) = without_noise::<Positions>(&positions, &[], rate, bank, false, is_noise) {
            trs.translation = smoothed[frame].as_vec3();
        }
        trs
    }
}
