//! Infers the frame rate from a rounded frame time.

use crate::scene::Confidence;
use crate::scene::report::Guess;

/// Frame rates of cameras, displays and capture systems. If a rounded frame time fits two rates, the likelier rate
/// comes first.
const RATES: [f64; 19] = [
    30.0,
    60.0,
    120.0,
    24.0,
    25.0,
    50.0,
    100.0,
    240.0,
    200.0,
    90.0,
    72.0,
    144.0,
    180.0,
    300.0,
    360.0,
    480.0,
    15.0,
    30_000.0 / 1001.0,
    60_000.0 / 1001.0,
];

/// The true rate of a motion of `ticks_per_second`, for resampling to `frames_per_second`. A rounded frame time is
/// corrected only if the correction makes the new frames coincide with old frames. For example, the rate 1 / 0.0083333
/// counts as 120 for resampling to 30.
#[doc(hidden)]
pub fn rate_before(ticks_per_second: f64, frames_per_second: f64) -> f64 {
    let fall_together = |rate: f64| {
        let ratio = f64::max(rate / frames_per_second, frames_per_second / rate);
        (ratio - ratio.round()).abs() < 1e-9
    };
    match frame_rate(ticks_per_second) {
        Some(meant) if !fall_together(ticks_per_second) && fall_together(meant.value) => meant.value,
        _ => ticks_per_second,
    }
}

/// The rate whose rounded frame time is 1 / `ticks_per_second`.
#[doc(hidden)]
pub fn frame_rate(ticks_per_second: f64) -> Option<Guess<f64>> {
    let frame_time = ticks_per_second.recip();
    let is_near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
    if is_near(ticks_per_second, ticks_per_second.round()) {
        return None;
    }
    for decimals in (3..=9).rev() {
        let scale = 10_f64.powi(decimals);
        let rounds_to_it = |rate: &&f64| is_near((scale / **rate).round() / scale, frame_time);
        if let Some(&value) = RATES.iter().find(rounds_to_it) {
            let reason = format!("the frame time {frame_time:.9} is 1/{value} rounded to {decimals} decimals");
            return Some(Guess {
                value,
                confidence: Confidence::Sure,
                reason,
            });
        }
    }
    None
}
