//! The median.

use glam::DVec3;

/// The median of the values, of an even number the upper one; `None` for none. The order of the values changes.
pub fn median(values: &mut [f32]) -> Option<f32> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// The median of the values, of an even number the upper one, and 0 for none. The order of the values changes.
pub fn wide_median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The median of each coordinate of those that are finite.
pub fn median_vector(vectors: impl Iterator<Item = DVec3> + Clone) -> DVec3 {
    let of = |axis: usize| {
        let numbers = vectors.clone().map(|vector| vector[axis]);
        wide_median(&mut numbers.filter(|number| number.is_finite()).collect::<Vec<f64>>())
    };
    DVec3::new(of(0), of(1), of(2))
}
