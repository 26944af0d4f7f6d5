//! Frame rates, and FBX's units of time.

use mocap_scene::error::{Code, Result};
use mocap_scene::limits;
use mocap_scene::scene::Scene;

use super::FbxOptions;
use crate::fbx::whole_rate;

/// FBX's units of time in a second, as `KTime` has them.
pub const SECOND: f64 = 46_186_158_000.0;

/// Frames per second of a file that holds no motion.
const POSE_FRAME_RATE: f64 = 30.0;

/// A frame rate.
#[derive(Clone, Copy)]
pub(super) struct Rate(f64);

impl Rate {
    /// That of the fastest clip: a file has one rate, and a reader that samples at it misses no key of the others whose
    /// rate divides it.
    pub(super) fn of(scene: &Scene, options: &FbxOptions) -> Result<Self> {
        let rates = scene.animations.iter().map(|animation| animation.ticks_per_second);
        Self::new(rates.max_by(f64::total_cmp).unwrap_or(POSE_FRAME_RATE), options)
    }

    /// A rate, made whole where that is wanted and next to it.
    pub(super) fn new(ticks_per_second: f64, options: &FbxOptions) -> Result<Self> {
        let rate = limits::frame_rate(Code::FrameTime, ticks_per_second)?;
        let whole = whole_rate(rate).filter(|_| options.whole_rate);
        Ok(Self(whole.unwrap_or(rate)))
    }

    pub(super) fn frames_per_second(self) -> f64 {
        self.0
    }

    /// FBX's number of a usual rate; 14 for another one, which stands in a property of its own.
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

/// The moment of a tick.
pub(super) fn time(tick: f64, rate: f64) -> i64 {
    (tick * SECOND / rate).round() as i64
}

/// The moment at which a clip ends.
///
/// # Errors
/// [`Code::LimitExceeded`] where FBX has no number for it.
pub fn end(duration: f64, rate: f64) -> Result<i64> {
    /// Six years, in seconds.
    const LONGEST: f64 = i64::MAX as f64 / SECOND;
    let seconds = duration / rate;
    if seconds < LONGEST {
        return Ok(time(duration, rate));
    }
    let diagnostic = limits::limit_exceeded(format!("at most {LONGEST:.0} s in FBX"), format!("{seconds:.0} s"));
    Err(diagnostic
        .help("take a part of the motion, or state its frame rate")
        .into())
}

/// The moments of keys, each later than the one before. None is later than its tick, so that a position that jumps at a
/// tick has jumped there. There may be only a few hundred of FBX's units between the two keys of a jump.
pub fn key_times(ticks: &[f64], rate: f64) -> impl Iterator<Item = i64> {
    /// In FBX's units: what the product of a tick and the length of one is off.
    const ROUNDING: f64 = 1e-3;
    let mut earliest = i64::MIN;
    ticks.iter().map(move |tick| {
        let time = ((tick * SECOND / rate + ROUNDING).floor() as i64).max(earliest);
        earliest = time.saturating_add(1);
        time
    })
}
