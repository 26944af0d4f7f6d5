//! The frames in which a step has an effect: a time range of a motion, with times before and after it in which the
//! effect fades in and out.

use mocap_figure::convert::{TimeRange, part_ticks};
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::not_negative;
use mocap_scene::scene::Animation;

use super::frames::Frames;
use super::inertia::ease;

/// The frames in which a step has its full effect. Also the frames before and after them, in which the effect fades in
/// and out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// The first and the last frame with the full effect.
    pub(super) first: usize,
    pub(super) last: usize,
    /// The number of frames over which the effect fades in and fades out. With 0, the effect starts and ends
    /// immediately.
    ease_in: f64,
    ease_out: f64,
}

impl Window {
    /// The window for a time range of `animation`. The two durations of fading are in seconds.
    pub(super) fn new(
        animation: &Animation,
        frames: &Frames,
        range: TimeRange,
        [ease_in, ease_out]: [f64; 2],
    ) -> Result<Self> {
        let (first, last) = part_ticks(Some(animation), range.first, range.last, 0.0)?;
        let frame = |tick: f64| (tick.round() as usize).min(frames.len() - 1);
        Ok(Self {
            first: frame(first),
            last: frame(last),
            ease_in: not_negative(Code::InvalidValue, "ease-in", ease_in)? * frames.rate,
            ease_out: not_negative(Code::InvalidValue, "ease-out", ease_out)? * frames.rate,
        })
    }

    /// A window for each run of frames for which `is_inside` is true. The effect fades in and out over `ease` frames.
    /// If two runs are near each other, the effect fades out in the first half of the gap between them, and fades in
    /// during the second half.
    pub(super) fn of_runs(is_inside: &[bool], ease: f64) -> Vec<Self> {
        let mut windows: Vec<Self> = Vec::new();
        for frame in (0..is_inside.len()).filter(|frame| is_inside[*frame]) {
            match windows.last_mut().filter(|last| last.last + 1 == frame) {
                Some(last) => last.last = frame,
                None => {
                    let before = windows.last_mut().map(|before| {
                        let gap = (frame - before.last) as f64;
                        before.ease_out = before.ease_out.min(0.5 * gap);
                        before.ease_out
                    });
                    windows.push(Self {
                        first: frame,
                        last: frame,
                        ease_in: before.map_or(ease, |before| before.min(ease)),
                        ease_out: ease,
                    });
                }
            }
        }
        windows
    }

    /// The fraction of the effect in a frame, from 0 to 1. Over time, its first and second derivatives do not jump.
    pub(super) fn weight(&self, frame: usize) -> f32 {
        let away = |frames: usize, within: f64| match frames as f64 / within {
            _ if frames == 0 => 1.0,
            part if part < 1.0 => 1.0 - ease(part as f32),
            _ => 0.0,
        };
        let before = self.first.saturating_sub(frame);
        let after = frame.saturating_sub(self.last);
        away(before, self.ease_in) * away(after, self.ease_out)
    }

    /// The frames in which the effect is not 0, each with the fraction of the effect. The motion has `count` frames.
    pub(super) fn frames(&self, count: usize) -> impl Iterator<Item = (usize, f32)> + use<'_> {
        let all = (0..count).map(|frame| (frame, self.weight(frame)));
        all.filter(|(_, weight)| *weight > 0.0)
    }
}
