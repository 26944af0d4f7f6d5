//! Defines times in a motion, and the time range of a motion to keep.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::options::as_text;
use mocap_scene::scene::Animation;

/// A time in the motion.
///
/// [`Conversion::trim`](crate::Conversion::trim) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Moment {
    /// Seconds from the start, not negative. The nearest frame is used.
    Seconds(f64),
    /// The frame with this number in the file. The first frame has the number 0.
    Frame(u64),
}

impl Moment {
    /// Refuses seconds that are negative or not a number.
    pub(super) fn check(self) -> Result<()> {
        match self {
            Self::Seconds(seconds) if seconds.is_nan() || seconds < 0.0 => {
                let message = format!("a time must be at least 0 seconds, got {seconds}");
                Err(Diagnostic::new(Code::InvalidValue, message).into())
            }
            _ => Ok(()),
        }
    }

    fn tick(self, ticks_per_second: f64) -> f64 {
        match self {
            Self::Seconds(seconds) => (seconds * ticks_per_second).round(),
            Self::Frame(frame) => frame as f64,
        }
    }
}

/// A time range of a motion. Both ends belong to the range.
///
/// ```
/// use mocap::convert::{Moment, TimeRange};
///
/// let range: TimeRange = "1.5..480f".parse().unwrap();
/// assert_eq!((range.first, range.last), (Some(Moment::Seconds(1.5)), Some(Moment::Frame(480))));
/// assert_eq!(range.to_string(), "1.5..480f");
/// assert_eq!("1.5s..480f".parse(), Ok(range));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TimeRange {
    /// The first time. Default: the beginning.
    pub first: Option<Moment>,
    /// The last time. Default: the end.
    pub last: Option<Moment>,
}

as_text!(TimeRange);

impl TimeRange {
    #[cfg(feature = "schema")]
    const TAKES: &str = "A..B in seconds, or Af..Bf in frames; either end is optional";

    /// Whether the range ends before it begins. This is known only if both ends are times, or if both are frames.
    fn ends_before_it_begins(self) -> bool {
        match (self.first, self.last) {
            (Some(Moment::Seconds(first)), Some(Moment::Seconds(last))) => last < first,
            (Some(Moment::Frame(first)), Some(Moment::Frame(last))) => last < first,
            _ => false,
        }
    }
}

/// The message for a part that ends before it begins.
const ENDS_BEFORE: &str = "the part to keep ends before it begins";

impl FromStr for TimeRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "not A..B, as in 1.5s..4s (seconds) or 120f..480f (frames)".to_owned();
        let moment = |text: &str| -> Result<Option<Moment>, String> {
            if text.is_empty() {
                return Ok(None);
            }
            let moment = match text.strip_suffix('f') {
                Some(frame) => frame.parse().ok().map(Moment::Frame),
                None => text
                    .strip_suffix('s')
                    .unwrap_or(text)
                    .parse()
                    .ok()
                    .filter(|time: &f64| time.is_finite() && *time >= 0.0)
                    .map(Moment::Seconds),
            };
            moment.map(Some).ok_or_else(wrong)
        };
        let (first, last) = text.split_once("..").ok_or_else(wrong)?;
        let range = Self {
            first: moment(first)?,
            last: moment(last)?,
        };
        match range.ends_before_it_begins() {
            true => Err(ENDS_BEFORE.to_owned()),
            false => Ok(range),
        }
    }
}

impl fmt::Display for TimeRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let moment = |moment| match moment {
            None => String::new(),
            Some(Moment::Seconds(seconds)) => seconds.to_string(),
            Some(Moment::Frame(frame)) => format!("{frame}f"),
        };
        write!(f, "{}..{}", moment(self.first), moment(self.last))
    }
}

/// The first and the last tick of the part from `first` to `last`, without the ticks before `start`. The last tick may
/// be after the end of the motion, and is infinite without `last`.
///
/// # Errors
/// [`Code::InvalidValue`] if the part begins after the end of `animation`, or ends before it begins.
#[doc(hidden)]
pub fn part_ticks(
    animation: Option<&Animation>,
    first: Option<Moment>,
    last: Option<Moment>,
    start: f64,
) -> Result<(f64, f64)> {
    for moment in [first, last].into_iter().flatten() {
        moment.check()?;
    }
    let rate = animation.map_or(1.0, |animation| animation.ticks_per_second);
    let first_tick = first.map_or(start, |moment| moment.tick(rate).max(start));
    let last_tick = last.map_or(f64::INFINITY, |moment| moment.tick(rate));
    if first.is_some() || last.is_some() {
        check_within(animation, first_tick, "the part to keep begins after the last frame")?;
    }
    if last_tick < first_tick {
        let diagnostic = Diagnostic::new(Code::InvalidValue, ENDS_BEFORE).expected_found(
            format!("frame {first_tick} or a later one"),
            format!("frame {last_tick}"),
        );
        return Err(diagnostic.into());
    }
    Ok((first_tick, last_tick))
}

/// Refuses a tick after the last tick. Without a motion, every tick is accepted.
pub(super) fn check_within(animation: Option<&Animation>, tick: f64, message: &str) -> Result<()> {
    match animation {
        Some(animation) if tick > animation.duration => {
            let last = animation.duration;
            let seconds = last / animation.ticks_per_second;
            let diagnostic = Diagnostic::new(Code::InvalidValue, message).expected_found(
                format!("at most frame {last}, {seconds:.3} seconds from the start"),
                format!("frame {tick}"),
            );
            Err(diagnostic.into())
        }
        _ => Ok(()),
    }
}
