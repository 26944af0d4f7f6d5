//! Mean and standard deviation.

use serde::Serialize;

/// Mean and standard deviation of a measure, with the number of values.
///
/// [`Gait`](super::Gait) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MeanAndDeviation {
    /// The mean.
    pub mean: f64,
    /// The standard deviation of the values (divisor `count - 1`); 0 for one value.
    pub deviation: f64,
    /// The number of values.
    pub count: usize,
}

impl MeanAndDeviation {
    pub(super) fn of(values: Vec<f64>) -> Option<Self> {
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        (count > 0).then(|| Self {
            mean,
            deviation: (squares / (count.max(2) - 1) as f64).sqrt(),
            count,
        })
    }
}
