//! Medians and percentiles.

use std::cmp::Ordering;

use glam::DVec3;

/// The median absolute value of a normal variable with standard deviation 1: its 75th percentile.
pub const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// A number with a total order.
pub trait OrderedNumber: Copy {
    fn compare(&self, other: &Self) -> Ordering;
}

impl OrderedNumber for f32 {
    fn compare(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

impl OrderedNumber for f64 {
    fn compare(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

/// The value at `rank` in sorted order, counted from 0; beyond the last rank, the last value. `None` if there are no
/// values. Reorders the values.
pub fn ranked<N: OrderedNumber>(values: &mut [N], rank: usize) -> Option<N> {
    let last = values.len().checked_sub(1)?;
    Some(*values.select_nth_unstable_by(rank.min(last), N::compare).1)
}

/// The median; of an even number of values, the larger of the two middle values. `None` if there are no values.
/// Reorders the values.
pub fn median<N: OrderedNumber>(values: &mut [N]) -> Option<N> {
    ranked(values, values.len() / 2)
}

/// The value below which a fraction of the values lies; `None` if there are no values. Ranks are counted from 0, and
/// `rounding` makes the rank whole.
pub fn percentile<N: OrderedNumber>(
    values: impl IntoIterator<Item = N>,
    fraction: f64,
    rounding: fn(f64) -> f64,
) -> Option<N> {
    let mut values: Vec<N> = values.into_iter().collect();
    let last = values.len().saturating_sub(1) as f64;
    ranked(&mut values, rounding(last * fraction) as usize)
}

/// The median of each coordinate over the finite vectors.
pub fn median_vector(vectors: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let of = |axis: usize| {
        let numbers = vectors.clone().map(|vector| vector[axis]);
        let mut numbers: Vec<f64> = numbers.filter(|number| number.is_finite()).collect();
        median(&mut numbers).unwrap_or_default()
    };
    DVec3::new(of(0), of(1), of(2))
}
