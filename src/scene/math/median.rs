//! The median, and percentiles.

use std::cmp::Ordering;

use glam::DVec3;

/// The median of the absolute values of a normal variable with the standard deviation 1: its 75th percentile.
pub const MEDIAN_OF_NORMAL: f64 = 0.6745;

/// A number that is sorted.
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

/// The value of a rank, counted from 0; of a rank beyond the last, the last; `None` for no values. The order of the
/// values changes.
pub fn ranked<N: OrderedNumber>(values: &mut [N], rank: usize) -> Option<N> {
    let last = values.len().checked_sub(1)?;
    Some(*values.select_nth_unstable_by(rank.min(last), N::compare).1)
}

/// The median of the values, of an even number the upper one; `None` for none. The order of the values changes.
pub fn median<N: OrderedNumber>(values: &mut [N]) -> Option<N> {
    ranked(values, values.len() / 2)
}

/// The value below which a fraction of the values is; `None` for no values. Ranks are counted from 0, and `rounding`
/// makes the rank a whole one.
pub fn percentile<N: OrderedNumber>(
    values: impl IntoIterator<Item = N>,
    fraction: f64,
    rounding: fn(f64) -> f64,
) -> Option<N> {
    let mut values: Vec<N> = values.into_iter().collect();
    let last = values.len().saturating_sub(1) as f64;
    ranked(&mut values, rounding(last * fraction) as usize)
}

/// The median of each coordinate of those that are finite.
pub fn median_vector(vectors: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let of = |axis: usize| {
        let numbers = vectors.clone().map(|vector| vector[axis]);
        let mut numbers: Vec<f64> = numbers.filter(|number| number.is_finite()).collect();
        median(&mut numbers).unwrap_or_default()
    };
    DVec3::new(of(0), of(1), of(2))
}
