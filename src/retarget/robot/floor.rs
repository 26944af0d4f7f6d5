//! The height of the floor under a motion.

use serde::{Deserialize, Serialize};

/// The height of the floor for a motion on a robot.
///
/// ```
/// use mocap::retarget::robot::RobotOptions;
/// use mocap::retarget::robot::report::Floor;
///
/// let options = RobotOptions::new().floor(Floor::Zero);
/// assert_eq!(serde_json::to_string(&options.floor).unwrap(), "\"z=0\"");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Floor {
    /// Under the feet in stance. If a foot in stance is above the floor by up to 6 cm, the whole robot is lowered. A
    /// robot that would be below the floor is raised.
    #[default]
    Auto,
    /// At height 0 of the source's file. A robot that would be below this height is raised.
    #[serde(rename = "z=0")]
    #[cfg_attr(feature = "clap", value(name = "z=0"))]
    Zero,
    /// At its mean height in the source. Heights do not change, even below the floor.
    Keep,
}

/// The height above the floor from which a foot in stance stands on another object, in metres.
const HIGHEST: f64 = 0.06;

/// The standard deviation of the Gaussian that smooths the lowering of a robot, in seconds: shorter than a step.
const BELL: f64 = 0.1;

/// The reach of the Gaussian, in standard deviations. Only 0.3 % of the Gaussian is beyond.
const REACH: f64 = 3.0;

/// The lowering of the robot in each frame: the height of the lower foot in stance above the floor. Between frames in
/// stance, it changes smoothly. `heights` are the heights of both soles.
pub fn drops(heights: &[[f64; 2]], contacts: &[[bool; 2]], fps: f64) -> Vec<f64> {
    let standing = heights.iter().zip(contacts);
    let standing = standing.map(|(heights, stands)| standing_height(heights, *stands));
    let known: Vec<(usize, f64)> = standing
        .enumerate()
        .filter_map(|(frame, height)| Some((frame, height?)))
        .collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        return vec![0.0; heights.len()];
    };
    let mut drops = vec![first.1; first.0];
    for pair in known.windows(2) {
        let [(from, low), (to, high)] = [pair[0], pair[1]];
        let along = |frame: usize| (frame - from) as f64 / (to - from) as f64;
        drops.extend((from..to).map(|frame| low + along(frame) * (high - low)));
    }
    drops.resize(heights.len(), last.1);
    smooth(&drops, BELL * fps)
}

/// The height of the lower foot in stance above the floor; `None` if no foot is in stance, or if the foot stands on
/// another object.
pub(super) fn standing_height(heights: &[f64; 2], stands: [bool; 2]) -> Option<f64> {
    let heights = heights.iter().zip(stands).filter(|(_, stands)| *stands);
    let lower = heights.map(|(height, _)| *height).reduce(f64::min)?;
    (lower <= HIGHEST).then_some(lower.max(0.0))
}

/// Smooths values by a Gaussian with this standard deviation, in frames.
pub(super) fn smooth(values: &[f64], deviation: f64) -> Vec<f64> {
    let reach = (REACH * deviation).ceil().min(values.len() as f64) as usize;
    let bell = |apart: usize| (-0.5 * (apart as f64 / deviation).powi(2)).exp();
    let bell: Vec<f64> = (0..=reach).map(bell).collect();
    let mean = |frame: usize| {
        let near = frame.saturating_sub(reach)..(frame + reach + 1).min(values.len());
        let sums = near.map(|other| (bell[other.abs_diff(frame)], values[other]));
        let (weights, sum) = sums.fold((0.0, 0.0), |(weights, sum), (weight, value)| {
            (weights + weight, sum + weight * value)
        });
        sum / weights
    };
    (0..values.len()).map(mean).collect()
}
