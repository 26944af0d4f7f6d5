//! The noise of a take: the error of a marker's position, independent in every frame.

use mocap_scene::math::median::{MEDIAN_OF_NORMAL, median};

use super::take::Track;

/// The rate in frames per second below which the motion itself changes as much as noise from frame to frame.
const LEAST_RATE: f64 = 60.0;

/// The number of differences to sample, which bounds the time.
const DIFFERENCES: usize = 20_000;

/// The weights of a third difference, the binomial coefficients. The difference is 0 for a motion without jerk.
const WEIGHTS: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];

/// The sum of the squares of these weights, the factor by which the difference multiplies the variance of noise.
const SQUARES: f64 = 20.0;

/// The standard deviation of the noise of a coordinate, in metres; 0 if the frame rate is too low to measure it.
pub fn of(tracks: &[Track], rate: f64) -> f64 {
    let count = tracks.len() * tracks.first().map_or(0, Vec::len);
    if rate < LEAST_RATE || count == 0 {
        return 0.0;
    }
    let step = (count / DIFFERENCES).max(1);
    let difference = |index: usize| -> Option<[f64; 3]> {
        let (marker, frame) = (index % tracks.len(), index / tracks.len());
        let track = tracks[marker].get(frame..frame + WEIGHTS.len())?;
        let mut sum = glam::DVec3::ZERO;
        for (position, weight) in track.iter().zip(WEIGHTS) {
            sum += (*position)? * weight;
        }
        Some(sum.abs().to_array())
    };
    let mut sizes: Vec<f64> = (0..count).step_by(step).filter_map(difference).flatten().collect();
    match sizes.is_empty() {
        true => 0.0,
        false => median(&mut sizes).unwrap_or_default() / (MEDIAN_OF_NORMAL * SQUARES.sqrt()),
    }
}
