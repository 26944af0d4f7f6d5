//! Limits on the memory that one file may take, and on numbers: those of files, and those that a caller passes.

use std::ops::RangeInclusive;

use crate::error::{Code, Diagnostic};
use crate::options::setters;
use crate::scene::Scene;

/// Upper bounds for what a reader accepts, each checked before anything is allocated for it.
///
/// A reader compares every count in a file with these limits and with the bytes that follow, before it allocates. The
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
    /// Animated values of one file: frames times channels. Default: 2^30. Few bytes can state a long take, so the limit
    /// is at most 4 million and 256 more for each byte of the file. At another frame rate it is at most 4 million and
    /// 256 more for each value of the motion.
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
    /// The limit on values that are made of less. They are made of `stated` bytes, in formats in which few bytes can
    /// state a long take (curves, or keys far apart). Or they are made of `stated` values, at another frame rate.
    ///
    /// The limit grows with what is there, so that memory stays in proportion to it. 256 values per byte are more than
    /// a file needs in which one joint of a hundred moves and the others have one key.
    #[doc(hidden)]
    pub fn expanded_values(&self, stated: u64) -> u64 {
        const ANY: u64 = 4 << 20;
        const EACH: u64 = 256;
        self.max_values.min(ANY.saturating_add(stated.saturating_mul(EACH)))
    }
}

/// The values that a motion may still have: each number of each frame is one.
///
/// Frames come from a stated time or count by [`FrameBudget::frames`] alone, so that none is used unchecked.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct FrameBudget {
    left: u64,
}

impl FrameBudget {
    /// For a motion that `stated` bytes of a file state, or `stated` values at another frame rate.
    pub fn stated_by(limits: &Limits, stated: u64) -> Self {
        Self {
            left: limits.expanded_values(stated),
        }
    }

    /// For a motion in memory, which may be as long as a caller wants.
    pub fn of_scene(limits: &Limits) -> Self {
        Self {
            left: limits.max_values,
        }
    }

    /// Takes the values of the frames from 0 to `last` out of the budget. Returns the number of these frames.
    #[allow(
        clippy::result_large_err,
        reason = "every caller makes an error of it, which is boxed"
    )]
    pub fn frames(&mut self, last: f64, values_a_frame: usize) -> Result<usize, Diagnostic> {
        /// Whole numbers up to here have no gaps: the number of values of 53 bits, which a double has.
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

    /// Holds every animation of a scene against the budget, with a value for each node at each frame.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] where a duration is negative or not finite, and [`Code::LimitExceeded`].
    pub fn check(mut self, scene: &Scene) -> crate::Result<()> {
        for animation in &scene.animations {
            self.frames(animation.duration.round(), scene.nodes.len())?;
        }
        Ok(())
    }
}

/// What helps against a motion that is too long.
const SHORTER: &str = "correct the time or the frame rate, or take a part of the motion";

/// The farthest a joint may be from its parent, in the file's unit: kinematics squares and adds such numbers, and the
/// results must still be finite in 32 bits.
#[doc(hidden)]
pub const FARTHEST: f64 = 1e18;

/// Whether kinematics can compute with a position or a matrix element: [`FARTHEST`] at most, and not NaN.
#[doc(hidden)]
pub fn is_plausible(value: f64) -> bool {
    value.abs() <= FARTHEST
}

/// Whether a scale is neither 0 nor of a size that still has an inverse.
#[doc(hidden)]
pub fn is_degenerate_scale(scale: f64) -> bool {
    scale != 0.0 && scale.abs() < SMALLEST_SCALE
}

/// The smallest scale, other than 0, that has an inverse in 32 bits, also below other such scales.
#[doc(hidden)]
pub const SMALLEST_SCALE: f64 = 1e-12;

/// Frames per second that a file may state, and that a caller may ask for: from one in three hours to those of the
/// fastest camera. A rate beyond them is damage, and makes times that 32-bit numbers cannot hold.
#[doc(hidden)]
pub const FRAME_RATES: RangeInclusive<f64> = 1e-4..=1e6;

/// `value`, if it is a frame rate that a file may have: the only statement of that rule.
#[allow(
    clippy::result_large_err,
    reason = "every caller makes an error of it, which is boxed"
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

/// Holds the frames on either side that a filter averages against the size of a motion: the filter visits each of
/// `values` once for each of them. A frame rate that a file states decides how many they are.
#[allow(
    clippy::result_large_err,
    reason = "every caller makes an error of it, which is boxed"
)]
#[doc(hidden)]
pub fn filter_radius(frames: usize, values: usize) -> Result<usize, Diagnostic> {
    /// Frames that any motion may have: two seconds at 240 Hz.
    const ANY: usize = 512;
    /// Visits of a filter with more frames: under 20 seconds in an unoptimised build.
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

/// `value`, if it is finite and not negative. `name` says what it is.
#[allow(
    clippy::result_large_err,
    reason = "every caller makes an error of it, which is boxed"
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

/// `value`, if it is finite and above 0. `name` says what it is.
#[allow(
    clippy::result_large_err,
    reason = "every caller makes an error of it, which is boxed"
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
