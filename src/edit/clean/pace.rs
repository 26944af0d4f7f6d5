//! Estimates how fast a track changes in each frame, as the density of the jerk that the smoother allows.
//!
//! A bank is a list of filters, each of which assumes one density. A filter predicts every frame from the frames
//! before, and also from the frames after. If the noise is known, the prediction error has a known variance, which
//! gives each filter a likelihood. The likelihoods of the frames around a frame are summed. This is multiple-model
//! adaptive estimation (Magill, "Optimal adaptive estimation of sampled stochastic processes", 1965) in both directions
//! of time.

use glam::DVec3;

use super::smoother::Covariance;

/// The rate in Hz at which noise is told from motion, whatever the rate of the take. It is about the rate of a film.
/// Faster takes do not show noise in each frame: the noise of an estimate is correlated over some frames, and an
/// interpolated take has noise only in its original frames.
const COMMON_RATE: f64 = 30.0;

/// The slowest original rate in Hz of an interpolated take. An animator sets keys more seldom, so a slower take is
/// animation.
const SLOWEST_OWN_RATE: f64 = 12.0;

/// The lowest cut-off frequency of the bank in Hz: the sway of a standing body is as slow.
const LOWEST: f64 = 0.4;

/// The ratio of the cut-off frequencies of neighbouring filters. At 30 Hz, nine filters cover the range from [`LOWEST`]
/// to [`HIGHEST`].
const RATIO: f64 = 1.5;
/// The highest cut-off frequency, as a fraction of the frame rate.
const HIGHEST: f64 = 0.4;

/// The time constant in seconds of the exponential window over which likelihoods are summed. A fast movement begins
/// within this time.
const AROUND: f64 = 0.06;

/// The least time constant of the same window in frames. At 25 frames per second, the window then still sums several
/// frames.
const AROUND_FRAMES: f64 = 2.5;
/// A filter does not count if the natural logarithm of its likelihood ratio to the best filter is below this.
const HARDLY: f64 = -25.0;

/// The exponent of a likelihood. Every frame is predicted from both sides, so each likelihood counts half.
const TEMPER: f64 = 0.5;

/// A filter of the bank, for noise of variance 1.
#[derive(Clone, Debug)]
struct Member {
    gains: [f64; 3],
    /// The variance of the innovations.
    variance: f64,
    /// The logarithm of the density of the jerk.
    jerk: f64,
}

/// The filters for one frame rate.
#[derive(Clone, Debug)]
pub(super) struct Bank {
    /// The distance of the sampled frames: one of `every` frames is used.
    pub(super) every: usize,
    members: Vec<Member>,
    /// The factor by which the weight of a likelihood falls with each frame of distance.
    decay: f64,
    /// The jerk that the smoother allows: `smoothing` of [`CleanWeights`](crate::CleanWeights).
    strength: f64,
}

impl Bank {
    /// A bank for a take of `rate` frames per second, sampled at one of `every` frames.
    pub(super) fn new(rate: f64, every: usize, strength: f64) -> Self {
        let rate = rate / every as f64;
        let mut cut_offs = vec![LOWEST.min(HIGHEST * rate)];
        while let Some(next) = cut_offs.last().map(|last| last * RATIO)
            && next <= HIGHEST * rate
        {
            cut_offs.push(next);
        }
        // The smoother's response is 1 / (1 + w^6 noise / jerk), which is 1/2 at the cut-off.
        let member = |cut_off: f64| Member::new((std::f64::consts::TAU * cut_off / rate).powi(6));
        Self {
            every,
            members: cut_offs.into_iter().map(member).collect(),
            decay: (-1.0 / (AROUND * rate).max(AROUND_FRAMES)).exp(),
            strength,
        }
    }

    /// The density of the jerk in each frame of the take. `noise` is the variance per axis in the frames of `sampled`.
    pub(super) fn jerk(&self, sampled: &Sampled, noise: f64) -> Vec<f64> {
        let logarithms = self.logarithms(&sampled.curve, noise);
        // The noise per hertz stays the same. A frame that is shorter by a factor has more noise by this factor, and
        // its ratio of jerk to noise falls by the sixth power.
        let scale = noise * self.strength * (self.every as f64).powi(-5);
        let last = logarithms.len() - 1;
        let at = |frame: usize| {
            let at = (frame as f64 - sampled.first as f64) / self.every as f64;
            let at = at.clamp(0.0, last as f64);
            let before = at as usize;
            let after = (before + 1).min(last);
            let [from, to] = [before, after].map(|index| logarithms[index]);
            scale * (from + (to - from) * at.fract()).exp()
        };
        (0..sampled.frames).map(at).collect()
    }

    /// The logarithm of the jerk in each frame, for noise of variance 1: the mean over the filters, weighted by
    /// likelihood.
    fn logarithms(&self, curve: &[DVec3], noise: f64) -> Vec<f64> {
        let frames = curve.len();
        let mut best = vec![f64::NEG_INFINITY; frames];
        let mut all = Vec::with_capacity(self.members.len());
        for member in &self.members {
            let mut likelihood = vec![0.0; frames];
            member.add_likelihood(curve.iter().copied(), noise, |frame, value| likelihood[frame] += value);
            let backwards = curve.iter().rev().copied();
            member.add_likelihood(backwards, noise, |frame, value| likelihood[frames - 1 - frame] += value);
            sum_around(&mut likelihood, self.decay);
            for (best, here) in best.iter_mut().zip(&likelihood) {
                *best = best.max(*here);
            }
            all.push(likelihood);
        }
        let mean = |frame: usize| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (member, likelihood) in self.members.iter().zip(&all) {
                let less = TEMPER * (likelihood[frame] - best[frame]);
                if less > HARDLY {
                    let weight = less.exp();
                    sum += weight * member.jerk;
                    weights += weight;
                }
            }
            sum / weights
        };
        (0..frames).map(mean).collect()
    }
}

/// The distance of the sampled frames of a take. `own` is the distance of the original frames of an interpolated take,
/// otherwise 1.
pub(super) fn frames_for_one(rate: f64, own: usize) -> usize {
    let is_estimate = rate >= SLOWEST_OWN_RATE * own as f64;
    ((rate / COMMON_RATE).round() as usize).max(if is_estimate { own } else { 1 })
}

/// A curve that is sampled at a rate near [`COMMON_RATE`].
pub(super) struct Sampled {
    pub(super) curve: Vec<DVec3>,
    pub(super) every: usize,
    first: usize,
    frames: usize,
}

impl Sampled {
    /// Samples one of `every` frames, beginning where the curve bends most. An interpolated take bends only in its
    /// original frames.
    pub(super) fn new(curve: &[DVec3], every: usize) -> Self {
        let mut bends = vec![0.0; every];
        for (index, three) in curve.windows(3).enumerate() {
            bends[(index + 1) % every] += (three[0] - 2.0 * three[1] + three[2]).length();
        }
        let first = (0..every).fold(0, |most, phase| if bends[phase] > bends[most] { phase } else { most });
        Self {
            curve: curve.iter().skip(first).step_by(every).copied().collect(),
            every,
            first,
            frames: curve.len(),
        }
    }

    /// Converts the standard deviation of noise in the sampled frames to the variance of noise in all frames of the
    /// take. Both noises are white, and have the same density per hertz.
    pub(super) fn of_all(&self, deviation: f64) -> f64 {
        deviation * deviation * self.every as f64
    }
}

impl Member {
    fn new(jerk: f64) -> Self {
        let mut covariance = Covariance::unknown(1.0, 1.0, 1.0);
        let mut gains = [0.0; 3];
        let mut variance = 1.0;
        // Iterates until the gains converge. A slow filter takes several of its own periods.
        for _ in 0..20_000 {
            covariance = covariance.predicted(jerk);
            let before = gains;
            (gains, variance) = covariance.gains(1.0);
            covariance = covariance.measured(gains, 1.0);
            if gains
                .iter()
                .zip(before)
                .all(|(now, before)| (now - before).abs() <= 1e-9 * now.abs())
            {
                break;
            }
        }
        let jerk = jerk.ln();
        Self { gains, variance, jerk }
    }

    /// Calls `add` with each frame and the logarithm of its likelihood, up to a constant.
    fn add_likelihood(&self, curve: impl Iterator<Item = DVec3>, noise: f64, mut add: impl FnMut(usize, f64)) {
        let variance = self.variance * noise;
        let constant = 1.5 * variance.ln();
        let [k0, k1, k2] = self.gains;
        let mut state: Option<[DVec3; 3]> = None;
        for (frame, measured) in curve.enumerate() {
            let [value, velocity, acceleration] = state.unwrap_or([measured, DVec3::ZERO, DVec3::ZERO]);
            let predicted = value + velocity + 0.5 * acceleration;
            let velocity = velocity + acceleration;
            let innovation = measured - predicted;
            state = Some([
                predicted + k0 * innovation,
                velocity + k1 * innovation,
                acceleration + k2 * innovation,
            ]);
            add(frame, -0.5 * innovation.length_squared() / variance - constant);
        }
    }
}

/// Replaces each value by a weighted sum of the values around. The weight falls with the distance.
fn sum_around(values: &mut [f64], decay: f64) {
    let mut after = vec![0.0; values.len()];
    let mut sum = 0.0;
    for (after, value) in after.iter_mut().zip(values.iter()).rev() {
        *after = sum;
        sum = decay * (sum + value);
    }
    sum = 0.0;
    for (value, after) in values.iter_mut().zip(after) {
        sum = decay * sum + *value;
        *value = sum + after;
    }
}
