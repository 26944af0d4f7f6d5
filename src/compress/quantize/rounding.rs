//! Rounds to integers inline. `f32::floor` and `f32::round` are function calls on x86-64 without SSE4.1.

/// The largest integer at or below `value`.
pub(super) fn floor(value: f32) -> i32 {
    let towards_zero = value as i32;
    towards_zero - i32::from(towards_zero as f32 > value)
}

/// The nearest integer, with halves away from zero, as meshoptimizer's filters round.
#[inline(always)]
pub(super) fn round(value: f32) -> i32 {
    (value + 0.5f32.copysign(value)) as i32
}
