//! Joint angles over the average stride.

use serde::Serialize;

use super::JointAngles;
use super::angles::POSITION;
use super::mean::MeanAndDeviation;

/// The number of samples of a cycle: every per cent, with both ends.
const SAMPLES: usize = 101;

/// A joint angle over the average stride of a foot.
///
/// [`Gait`](super::Gait) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct AngleCycle {
    /// The column of [`JointAngles`].
    pub column: String,
    /// The mean over the strides, in degrees, at 0, 1, ... 100 % of the stride.
    pub mean: Vec<f64>,
    /// The standard deviation over the strides (divisor `count - 1`) at 0, 1, ... 100 % of the stride; 0 for one
    /// stride.
    pub deviation: Vec<f64>,
}

impl AngleCycle {
    /// The average strides of a foot: the angles of its leg, the pelvis and the trunk. Each pair in `strikes` begins
    /// and ends a stride, in seconds. Columns whose names end in `ending` belong to the other side.
    pub(super) fn all(angles: &JointAngles, strikes: &[[f64; 2]], ending: &str) -> Vec<Self> {
        if strikes.is_empty() || angles.frames() == 0 {
            return Vec::new();
        }
        let own = |name: &&String| !name.ends_with(ending) && !POSITION.contains(&name.as_str());
        let cycle = |name: &String| {
            let values: Vec<f64> = angles.column(name)?.collect();
            let of_sample = |sample: usize| {
                let part = sample as f64 / (SAMPLES - 1) as f64;
                let value =
                    |[first, second]: &[f64; 2]| at(&values, (first + part * (second - first)) * angles.frame_rate);
                MeanAndDeviation::of(strikes.iter().map(value).collect())
            };
            let samples: Vec<MeanAndDeviation> = (0..SAMPLES).filter_map(of_sample).collect();
            Some(Self {
                column: name.clone(),
                mean: samples.iter().map(|sample| sample.mean).collect(),
                deviation: samples.iter().map(|sample| sample.deviation).collect(),
            })
        };
        angles.columns.iter().filter(own).filter_map(cycle).collect()
    }
}

/// The value between two frames, by linear interpolation.
fn at(values: &[f64], frame: f64) -> f64 {
    let last = values.len() - 1;
    let frame = frame.clamp(0.0, last as f64);
    let before = frame.floor() as usize;
    let part = frame - before as f64;
    values[before] * (1.0 - part) + values[(before + 1).min(last)] * part
}
