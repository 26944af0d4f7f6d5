//! Frame rates, and FBX's units of time.

use mocap_scene::error::{Code, Result};
use mocap_scene::limits;
use mocap_scene::scene::Scene;

use super::FbxOptions;
use crate::fbx::whole_rate;

/// FBX's time units (`KTime`) per second.
pub const SECOND: f64 = 46_186_158_000.0;

/// The frame rate of a file without motion, in frames per second.
const POSE_FRAME_RATE: f64 = 30.0;

/// A frame rate.
#[derive(Clone, Copy)]
pub(super) struct Rate(f64);

impl Rate {
    /// The rate of the fastest clip, because a file has only one rate. A reader that samples at this rate misses no key
    /// of clips whose rate divides this rate.
    pub(super) fn of(scene: &Scene, options: &FbxOptions) -> Result<Self> {
        let rates = scene.animations.iter().map(|animation| animation.ticks_per_second);
        Self::new(rates.max_by(f64::total_cmp).unwrap_or(POSE_FRAME_RATE), options)
    }

    /// A rate, rounded to a whole number if the options ask for it and the rate is almost whole.
    pub(super) fn new(ticks_per_second: f64, options: &FbxOptions) -> Result<Self> {
        let rate = limits::frame_rate(Code::FrameTime, ticks_per_second)?;
        let whole = whole_rate(rate).filter(|_| options.whole_rate);
        Ok(Self(whole.unwrap_or(rate)))
    }

    pub(super) fn frames_per_second(self) -> f64 {
        self.0
    }

    /// FBX's number of a common rate, or 14 for a custom rate, which has its own property.
    pub(super) fn mode(self) -> i32 {
        let usual = [
            (120.0, 1),
            (100.0, 2),
            (60.0, 3),
            (50.0, 4),
            (48.0, 5),
            (30.0, 6),
            (25.0, 10),
            (24.0, 11),
            (1000.0, 12),
            (96.0, 15),
            (72.0, 16),
        ];
        usual
            .into_iter()
            .find(|(rate, _)| *rate == self.0)
            .map_or(14, |(_, mode)| mode)
    }
}

/// The time of a tick, in FBX's units.
pub(super) fn time(tick: f64, rate: f64) -> i64 {
    (tick * SECOND / rate).round() as i64
}

/// The end of a clip, in FBX's units.
///
/// # Errors
/// [`Code::LimitExceeded`] if FBX cannot represent the time.
pub fn end(duration: f64, rate: f64) -> Result<i64> {
    /// The longest time in seconds: six years.
    const LONGEST: f64 = i64::MAX as f64 / SECOND;
    let seconds = duration / rate;
    if seconds < LONGEST {
        return Ok(time(duration, rate));
    }
    let diagnostic = limits::limit_exceeded(format!("at most {LONGEST:.0} s in FBX"), format!("{seconds:.0} s"));
    Err(diagnostic
        .help("write a part of the motion, or state its frame rate")
        .into())
}

/// The times of keys, strictly increasing. No key is later than its tick, so that a position that jumps at a tick has
/// its new value there. The two keys of a jump may be only some hundred FBX units apart.
pub fn key_times(ticks: &[f64], rate: f64) -> impl Iterator<Item = i64> {
    /// The rounding error of a tick times the length of a tick, in FBX's units.
    const ROUNDING: f64 = 1e-3;
    let mut earliest = i64::MIN;
    ticks.iter().map(move |tick| {
        let time = ((tick * SECOND / rate + ROUNDING).floor() as i64).max(earliest);
        earliest = time.saturating_add(1);
        time
    })
}
