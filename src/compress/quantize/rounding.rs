//! Rounding to integers without function calls, which `f32::floor` and `f32::round` are on x86-64 without SSE4.1.

/// The largest integer that is not above `value`.
pub(super) fn floor(value: f32) -> i32 {
    let towards_zero = value as i32;
    towards_zero - i32::from(towards_zero as f32 > value)
}

/// The nearest integer, halves away from zero, as meshoptimizer rounds in its filters.
#[inline(always)]
pub(super) fn round(value: f32) -> i32 {
    (value + 0.5f32.copysign(value)) as i32
}
