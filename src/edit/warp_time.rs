//! Makes parts of a motion faster or slower.

use std::fmt;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::frames::Frames;

/// The report of a [`Warp`](crate::Warp) by `moments` or by `speed`.
///
/// [`Warp`](crate::Warp) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WarpTimeReport {
    /// The duration of the motion before the step, in seconds.
    pub seconds_before: f64,
    /// The duration of the motion after the step, in seconds. It is a whole number of frames: the step drops a part of
    /// a frame at the end.
    pub seconds: f64,
    /// The lowest playback speed, as a factor. 1 means that the speed did not change.
    pub slowest: f64,
    /// The highest playback speed, as a factor. 1 means that the speed did not change.
    pub fastest: f64,
}

impl fmt::Display for WarpTimeReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.2} s long, now {:.2} s; speed between {:.2} and {:.2} times the original",
            self.seconds_before, self.seconds, self.slowest, self.fastest,
        )
    }
}

pub(super) fn warp_time(scene: &mut Scene, animation: usize, moments: &[(f64, f64)]) -> Result<WarpTimeReport> {
    let is_time = |time: f64| time.is_finite() && time >= 0.0;
    let increase = moments
        .windows(2)
        .all(|pair| pair[0].0 < pair[1].0 && pair[0].1 < pair[1].1);
    if !increase || !moments.iter().all(|(from, to)| is_time(*from) && is_time(*to)) {
        let message = "the times of a warp must be finite, at least 0, and in increasing order";
        let diagnostic = Diagnostic::new(Code::InvalidValue, message);
        let found = format!("{moments:?}");
        return Err(diagnostic.expected_found("pairs of times in seconds", found).into());
    }
    let frames = Frames::new(scene, animation, &[])?;
    let last = (frames.len() - 1) as f64 / frames.rate;
    let moments = &anchored(moments);
    let inverse: Vec<(f64, f64)> = moments.iter().map(|(from, to)| (*to, *from)).collect();
    let seconds = map(moments, last).max(0.0);
    let count = frames.up_to(seconds * frames.rate + 1e-6, &[])?;
    let old_frame = |frame: usize| {
        let tick = map(&inverse, frame as f64 / frames.rate) * frames.rate;
        // Rounding errors may change a whole frame number a little, so the number is rounded.
        if (tick - tick.round()).abs() < 1e-6 {
            tick.round()
        } else {
            tick
        }
    };
    let taken: Vec<_> = (0..count).map(|frame| (&frames, old_frame(frame))).collect();
    let rows = taken.iter().map(|(frames, tick)| frames.row_at(*tick)).collect();
    // After the last pair, the playback speed is 1.
    let as_before = moments.last().is_none_or(|(from, _)| *from < last).then_some(1.0);
    let speeds = moments
        .windows(2)
        .map(|pair| (pair[1].0 - pair[0].0) / (pair[1].1 - pair[0].1))
        .chain(as_before);
    let (slowest, fastest) = speeds
        .fold(None, |range: Option<(f64, f64)>, speed| {
            Some(range.map_or((speed, speed), |(low, high)| (low.min(speed), high.max(speed))))
        })
        .unwrap_or((1.0, 1.0));
    frames.with_rows_of(rows, &taken).write_all(scene, animation);
    Ok(WarpTimeReport {
        seconds_before: last,
        seconds: (count - 1) as f64 / frames.rate,
        slowest,
        fastest,
    })
}

/// The pairs. If the pair (0, 0) for the start of the motion is missing, the function adds it before the first pair.
/// Without this pair, a first pair such as (0.3, 0.6) would need a motion before the start.
fn anchored(moments: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let start = moments.first().filter(|(from, to)| *from > 0.0 && *to > 0.0);
    let start = start.map(|_| (0.0, 0.0));
    start.into_iter().chain(moments.iter().copied()).collect()
}

/// Maps a time by a piecewise linear function.
fn map(moments: &[(f64, f64)], time: f64) -> f64 {
    let (Some(first), Some(last)) = (moments.first(), moments.last()) else {
        return time;
    };
    if time <= first.0 {
        return time + first.1 - first.0;
    }
    if time >= last.0 {
        return time + last.1 - last.0;
    }
    let after = moments.partition_point(|moment| moment.0 < time);
    let (from, to) = (moments[after - 1], moments[after]);
    from.1 + (time - from.0) / (to.0 - from.0) * (to.1 - from.1)
}
