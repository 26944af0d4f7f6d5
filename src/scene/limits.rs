//! Limits on the memory for one file, and on numbers from files and callers.

use std::ops::RangeInclusive;

use crate::error::{Code, Diagnostic};
use crate::options::setters;
use crate::scene::Scene;

/// Upper bounds for file contents.
///
/// A reader compares every count in a file with these limits and with the remaining bytes, before it allocates. The
/// defaults are far above every motion file that we know.
///
/// ```
/// use mocap::{Importer, Limits};
///
/// let tight = Limits::new().max_nodes(2);
/// let text = b"HIERARCHY ROOT a { JOINT b { JOINT c { } } } MOTION Frames: 0 Frame Time: 0.1";
/// let error = Importer::new().limits(tight).read(text, "deep.bvh").unwrap_err();
/// assert_eq!(error.code().as_str(), "limit-exceeded");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Bytes of one input file. Default: 4 GiB.
    pub max_bytes: u64,
    /// Nodes of one scene: joints and end sites. Default: 65,536.
    pub max_nodes: usize,
    /// Nodes from a root to its deepest descendant. Default: 1,024.
    pub max_depth: usize,
    /// Bytes of one name. Default: 256.
    pub max_name_bytes: usize,
    /// Animated values of one file: frames times channels. Default: 2^30. A few bytes can state a long take. So the
    /// limit is also at most 4 million plus 256 for each byte of the file. For resampling it is at most 4 million plus
    /// 256 for each value of the motion.
    pub max_values: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_bytes: 4 << 30,
            max_nodes: 65_536,
            max_depth: 1_024,
            max_name_bytes: 256,
            max_values: 1 << 30,
        }
    }
}

setters! {
    Limits {
        max_bytes: u64,
        max_nodes: usize,
        max_depth: usize,
        max_name_bytes: usize,
        max_values: u64,
    }
}

impl Limits {
    /// The limit on values that expand from a smaller source. `stated` is the size of the source. For a format that
    /// states a long take in few bytes (curves or sparse keys), it is a number of bytes. For resampling, it is a number
    /// of values.
    ///
    /// The limit grows with the source, so that memory stays in proportion. 256 values per byte exceed the need of a
    /// file in which one joint of a hundred moves and the others have one key.
    #[doc(hidden)]
    pub fn expanded_values(&self, stated: u64) -> u64 {
        const ANY: u64 = 4 << 20;
        const EACH: u64 = 256;
        self.max_values.min(ANY.saturating_add(stated.saturating_mul(EACH)))
    }
}

/// The number of values that a motion may still allocate. Each number of each frame is one value.
///
/// Only [`FrameBudget::frames`] converts a stated time or count to frames, so that no count is used unchecked.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct FrameBudget {
    left: u64,
}

impl FrameBudget {
    /// The budget for a motion from `stated` bytes of a file, or from `stated` values by resampling.
    pub fn stated_by(limits: &Limits, stated: u64) -> Self {
        Self {
            left: limits.expanded_values(stated),
        }
    }

    /// The budget for a motion in memory, which may be as long as the caller wants.
    pub fn of_scene(limits: &Limits) -> Self {
        Self {
            left: limits.max_values,
        }
    }

    /// Takes the values of the frames 0 to `last` out of the budget. Returns the number of these frames.
    #[allow(
        clippy::result_large_err,
        reason = "every caller turns the diagnostic into an `Error`, which boxes it"
    )]
    pub fn frames(&mut self, last: f64, values_a_frame: usize) -> Result<usize, Diagnostic> {
        /// The largest number up to which a double represents every whole number: 53 bits.
        const WHOLE: f64 = (1_u64 << 53) as f64;
        let values = values_a_frame.max(1) as u64;
        let last = not_negative(Code::InvalidValue, "the number of the last frame", last)?.floor();
        let frames = (last as u64).saturating_add(1);
        let left = self.left.checked_sub(frames.saturating_mul(values));
        match left.filter(|_| last < WHOLE) {
            Some(left) => {
                self.left = left;
                Ok(frames as usize)
            }
            None => {
                let most = self.left / values;
                let expected = format!("at most {most} frames of {values} values, for a motion of this size");
                Err(limit_exceeded(expected, format!("{} frames", last + 1.0)).help(SHORTER))
            }
        }
    }

    /// Checks every animation of a scene against the budget, with one value for each node in each frame.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if a duration is negative or not finite, and [`Code::LimitExceeded`].
    pub fn check(mut self, scene: &Scene) -> crate::Result<()> {
        for animation in &scene.animations {
            self.frames(animation.duration.round(), scene.nodes.len())?;
        }
        Ok(())
    }
}

/// The remedy for a motion that is too long.
const SHORTER: &str = "correct the time or the frame rate, or trim the motion";

/// The largest distance of a joint from its parent, in the file's unit. Kinematics squares and adds such numbers, and
/// the results must still be finite in 32 bits.
#[doc(hidden)]
pub const FARTHEST: f64 = 1e18;

/// Whether kinematics can compute with a position or a matrix element: at most [`FARTHEST`], and not NaN.
#[doc(hidden)]
pub fn is_plausible(value: f64) -> bool {
    value.abs() <= FARTHEST
}

/// Whether a scale is not 0, but too small to have an inverse.
#[doc(hidden)]
pub fn is_degenerate_scale(scale: f64) -> bool {
    scale != 0.0 && scale.abs() < SMALLEST_SCALE
}

/// The smallest scale, other than 0, that has an inverse in 32 bits, also for a chain of such scales.
#[doc(hidden)]
pub const SMALLEST_SCALE: f64 = 1e-12;

/// The frame rates in frames per second that a file or a caller may state: from one frame in three hours to the fastest
/// camera. A rate outside of this range is damaged: 32-bit numbers cannot hold its times.
#[doc(hidden)]
pub const FRAME_RATES: RangeInclusive<f64> = 1e-4..=1e6;

/// `value`, if it is a valid frame rate. No other function has this rule.
#[allow(
    clippy::result_large_err,
    reason = "every caller turns the diagnostic into an `Error`, which boxes it"
)]
#[doc(hidden)]
pub fn frame_rate(code: Code, value: f64) -> Result<f64, Diagnostic> {
    let value = positive(code, "frame rate", value)?;
    if FRAME_RATES.contains(&value) {
        return Ok(value);
    }
    let (least, most) = (FRAME_RATES.start(), FRAME_RATES.end());
    Err(Diagnostic::new(
        code,
        format!("frame rate must be from {least} to {most} frames per second, got {value:e}"),
    ))
}

/// The diagnostic for a count or a size beyond the limits.
#[doc(hidden)]
pub fn limit_exceeded(expected: String, found: String) -> Diagnostic {
    Diagnostic::new(Code::LimitExceeded, "the file states more than the limits allow").expected_found(expected, found)
}

/// Limits the radius of a filter by the size of a motion. The radius follows from the frame rate, and a file may state
/// any frame rate. For every value, the filter visits all frames of its window.
#[allow(
    clippy::result_large_err,
    reason = "every caller turns the diagnostic into an `Error`, which boxes it"
)]
#[doc(hidden)]
pub fn filter_radius(frames: usize, values: usize) -> Result<usize, Diagnostic> {
    /// The radius in frames that any motion may have: two seconds at 240 Hz.
    const ANY: usize = 512;
    /// The largest product of radius and values, if the radius is above `ANY`: under 20 seconds in an unoptimised
    /// build.
    const VISITS: usize = 1 << 31;
    let most = ANY.max(VISITS / values.max(1));
    if frames <= most {
        return Ok(frames);
    }
    let message = "the step averages too many frames of this motion at once";
    Err(Diagnostic::new(Code::LimitExceeded, message)
        .expected_found(format!("at most {most} frames on either side"), frames.to_string())
        .help("resample the motion to a lower frame rate first, or state shorter times"))
}

/// `value`, if it is finite and not negative. `name` is for the message.
#[allow(
    clippy::result_large_err,
    reason = "every caller turns the diagnostic into an `Error`, which boxes it"
)]
#[doc(hidden)]
pub fn not_negative(code: Code, name: &str, value: f64) -> Result<f64, Diagnostic> {
    if value.is_finite() && value >= 0.0 {
        return Ok(value);
    }
    Err(Diagnostic::new(
        code,
        format!("{name} must be finite and not negative, got {value}"),
    ))
}

/// `value`, if it is finite and above 0. `name` is for the message.
#[allow(
    clippy::result_large_err,
    reason = "every caller turns the diagnostic into an `Error`, which boxes it"
)]
#[doc(hidden)]
pub fn positive(code: Code, name: &str, value: f64) -> Result<f64, Diagnostic> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(Diagnostic::new(
        code,
        format!("{name} must be finite and above 0, got {value}"),
    ))
}
