//! Finds tracks whose values are constant except for rounding errors.

use glam::{Quat, Vec3};

/// The largest difference between a computed value and a constant that counts as rounding, as a fraction of the
/// constant's length: a few roundings of single precision.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

/// The value of a constant track. A track that was `constant` stays constant if its values differ only by rounding
/// errors. Any other track becomes constant only if all its values are equal, so that a slow motion is kept.
pub(super) fn constant_value<T: Copy + PartialEq>(
    values: &[T],
    constant: Option<T>,
    is_near: fn(T, T) -> bool,
) -> Option<T> {
    let first = *values.first()?;
    let are_near = |wanted: &T| values.iter().all(|value| is_near(*value, *wanted));
    match constant {
        Some(constant) => [constant, first].into_iter().find(are_near),
        None => values.iter().all(|value| *value == first).then_some(first),
    }
}

pub(super) fn is_near(value: Vec3, constant: Vec3) -> bool {
    value.distance(constant) <= ROUNDING * constant.length()
}

/// Whether two quaternions are the same rotation. A quaternion and its negative are the same rotation.
pub(super) fn is_same_rotation(value: Quat, constant: Quat) -> bool {
    let apart = (value - constant).length().min((value + constant).length());
    apart <= ROUNDING
}
