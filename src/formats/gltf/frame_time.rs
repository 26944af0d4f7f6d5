//! The frame time of an animation, and its keys at ticks.
//!
//! A file of this crate states its frame time. In other files, the frame time is the first of these that applies:
//!
//! 1. the distance between two keys, if it is constant
//! 2. the usual frame rate that has all keys on its frames
//! 3. the shortest distance between two keys
//!
//! Keys more than a tenth of a second apart are not frames. Then a whole number of frames, about thirty per second,
//! lies between them. Times within a float's rounding of a whole tick become that tick.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits;
use mocap_scene::scene::Keys;

use super::tracks::Track;
use crate::Failure;

/// The largest difference between a time and a whole tick that count as equal, as a fraction of the time: twice the
/// rounding of a float.
const TIME_ROUNDING: f64 = 1.2e-7;

/// Usual export frame rates, in frames per second.
const USUAL_RATES: [f64; 13] = [
    24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0, 23.976, 29.97,
];

/// The largest frame rate in frames per second, if the file states no rate and its keys follow none.
const MOST_FRAMES_PER_SECOND: f64 = 240.0;

/// The distance in seconds between keys above which the keys are not frames.
const SPARSE: f64 = 0.1;

/// Checks a frame time that this crate has written at `pointer`. The time 0 means that the scene had no motion; the
/// result is then `None`.
pub(super) fn valid_frame_time(time: f64, pointer: &str) -> Result<Option<f64>, Failure> {
    if time == 0.0 {
        return Ok(None);
    }
    limits::frame_rate(Code::FrameTime, time.recip())
        .map(|_| Some(time))
        .map_err(|diagnostic| {
            let diagnostic = diagnostic.at_pointer(format!("{pointer}/mocap/frame_time"));
            let name = pointer.trim_start_matches('/').replace('/', ".");
            Box::new(diagnostic.help(format!("remove {name}.mocap; the rate is then inferred from the keys")))
        })
}

/// Keeps only the first keys of a motion that is shorter than the smallest distance of two keys. No program could play
/// or write the other keys.
pub(super) fn keep_one_pose(tracks: &mut [Track], animation: usize) -> Option<Diagnostic> {
    let end = f64::from(end_of(tracks));
    let is_too_short = end > 0.0 && end < key_distance();
    is_too_short.then(|| {
        tracks.iter_mut().for_each(Track::keep_first);
        let message =
            format!("the motion ends after {end:e} s, which is shorter than any frame; only its first keys were read");
        Diagnostic::new(Code::FrameTime, message)
            .at_pointer(format!("/animations/{animation}"))
            .help("export it again with times in seconds")
    })
}

/// The time of the last key, in seconds.
pub(super) fn end_of(tracks: &[Track]) -> f32 {
    let ends = tracks.iter().filter_map(|track| track.times.last());
    ends.copied().fold(0.0, f32::max)
}

/// A single key holds for all time, whatever its tick.
pub(super) fn keys<T>(values: Vec<T>, ticks: Vec<f64>) -> Keys<T> {
    match ticks.len() {
        1 => Keys::every_tick(values),
        _ => Keys::at_ticks(values, ticks),
    }
}

/// Whether keys can have the frame time that the file states. If the motion is shorter than one frame, the file was
/// changed after it was written.
pub(super) fn fits(step: f64, tracks: &[Track]) -> bool {
    /// The rounding of times, as a fraction of a frame.
    const ROUNDING: f64 = 1e-3;
    let end = f64::from(end_of(tracks));
    end <= 0.0 || end >= step * (1.0 - ROUNDING)
}

/// The frame time in seconds of an animation in a file that states no frame time. If only morph targets move, the keys
/// of their weights determine the frame time.
pub(super) fn find_frame_time(tracks: &[Track], weights: &[&mut Keys<f32>]) -> f64 {
    let of_joints = tracks.iter().map(|track| track.key_times().to_vec());
    let times: Vec<Vec<f32>> = match tracks.is_empty() {
        true => weights.iter().map(|keys| times_of(keys)).collect(),
        false => of_joints.collect(),
    };
    let step = key_step(&times);
    let step = match step <= SPARSE {
        true => step,
        // A whole number of frames from key to key.
        false => step / (step * 30.0).round().max(1.0),
    };
    // The times in files are rounded, so a usual rate near the computed rate is meant.
    let is_usual = |rate: &&f64| tracks.is_empty() && (step * **rate - 1.0).abs() < 1e-6;
    USUAL_RATES.iter().find(is_usual).map_or(step, |rate| rate.recip())
}

/// The times of keys in seconds. Of two keys in one frame, as in a step, only the later time is listed.
fn times_of(keys: &Keys<f32>) -> Vec<f32> {
    let mut times: Vec<f32> = (0..keys.len()).map(|key| keys.tick(key) as f32).collect();
    let next: Vec<f32> = times.iter().skip(1).copied().chain([f32::INFINITY]).collect();
    let mut next = next.into_iter();
    times.retain(|time| next.next().is_none_or(|next| f64::from(next - time) >= key_distance()));
    times
}

/// The smallest distance of two keys in seconds: a tenth of a frame of the highest rate.
fn key_distance() -> f64 {
    MOST_FRAMES_PER_SECOND.recip() / 10.0
}

/// The time between two keys. It is the key distance of the track with the most keys, if this distance is constant.
/// Otherwise it is the frame time of the usual frame rate that has all keys on its frames, or else the shortest
/// distance. If no track has two keys, the time is a thirtieth of a second.
fn key_step(tracks: &[Vec<f32>]) -> f64 {
    let longest = tracks.iter().map(Vec::as_slice).max_by_key(|times| times.len());
    if let Some(times @ [first, .., last]) = longest {
        // The rounding of single steps is too coarse for a long take; their mean is precise.
        let mean = (f64::from(*last) - f64::from(*first)) / (times.len() - 1) as f64;
        let expected = (0..times.len()).map(|key| f64::from(*first) + key as f64 * mean);
        let is_even =
            std::iter::zip(times, expected).all(|(time, expected)| (f64::from(*time) - expected).abs() < 0.1 * mean);
        if is_even && mean >= key_distance() {
            return mean;
        }
    }
    let pairs = || tracks.iter().flat_map(|times| times.windows(2));
    let stands_on = |rate: &&f64| {
        let is_whole = |time: f32| {
            let frame = f64::from(time) * **rate;
            (frame - frame.round()).abs() < 0.01 + frame * TIME_ROUNDING
        };
        pairs().all(|pair| is_whole(pair[0]) && is_whole(pair[1]))
    };
    let shortest = pairs()
        .map(|pair| f64::from(pair[1]) - f64::from(pair[0]))
        .fold(f64::INFINITY, f64::min);
    if !shortest.is_finite() {
        return 1.0 / 30.0;
    }
    match USUAL_RATES.iter().find(stands_on) {
        Some(rate) => rate.recip(),
        None => shortest.max(MOST_FRAMES_PER_SECOND.recip()),
    }
}

/// Converts key times in seconds to ticks, and returns the last tick.
pub(super) fn put_at_ticks(keys: &mut Keys<f32>, step: f64) -> f64 {
    let times: Vec<f32> = (0..keys.len()).map(|key| keys.tick(key) as f32).collect();
    let ticks = ticks_of(&times, step);
    let last = ticks.last().copied().filter(|_| ticks.len() > 1).unwrap_or(0.0);
    *keys = self::keys(std::mem::take(&mut keys.values), ticks);
    last
}

/// The ticks for key times. Both the ticks and the times increase strictly.
pub(super) fn ticks_of(times: &[f32], step: f64) -> Vec<f64> {
    let mut ticks: Vec<f64> = times.iter().map(|time| tick_of(*time, step)).collect();
    for key in (1..ticks.len()).rev() {
        if ticks[key - 1] >= ticks[key] {
            let between = f64::from(times[key]) - f64::from(times[key - 1]);
            ticks[key - 1] = ticks[key] - between / step;
        }
    }
    ticks
}

pub(super) fn tick_of(time: f32, step: f64) -> f64 {
    let tick = f64::from(time) / step;
    let whole = tick.round();
    if (tick - whole).abs() <= whole.abs() * TIME_ROUNDING {
        whole
    } else {
        tick
    }
}
