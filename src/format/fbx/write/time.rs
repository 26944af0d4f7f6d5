//! Frame rates, and FBX's units of time.

use crate::error::{Code, Result};
use crate::limits;
use crate::scene::Scene;

/// FBX's units of time in a second.
const SECOND: f64 = 46_186_158_000.0;

/// Frames per second of a file that holds no motion.
const POSE_FRAME_RATE: f64 = 30.0;

/// A frame rate.
#[derive(Clone, Copy)]
pub(super) struct Rate(f64);

impl Rate {
    /// That of the first clip.
    pub(super) fn of(scene: &Scene) -> Result<Self> {
        let rate = scene
            .animations
            .first()
            .map_or(POSE_FRAME_RATE, |animation| animation.ticks_per_second);
        Ok(Self(limits::frame_rate(Code::FrameTime, rate)?))
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
