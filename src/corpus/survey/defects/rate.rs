//! Motions that are played too fast or too slow, by gravity and by what a rate can be.
//!
//! A body that is off the ground falls by 9.81 m/s^2. Played so many times too fast, it falls by the square of that. No
//! body falls faster, since legs push and do not pull.

use mocap_scene::math::median::median;

use super::{Findings, confidence, ramp};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::WrongRate;

/// The acceleration of gravity in m/s^2.
const GRAVITY: f32 = 9.81;

/// Frames per second below which nothing that moves is recorded, and above which nothing that moves is.
const RATES: [f64; 2] = [5.0, 1000.0];

/// Half the time over which accelerations are computed, in seconds. Noise of a millimetre is then 3 m/s^2. A step of a
/// walk that plays five times too fast takes 0.1 s.
const HALF: f64 = 0.03;

/// The fraction of all frames in which the hips must fall so fast: a single fall is another defect.
const OFTEN: f32 = 0.1;

/// The height in metres from which on both feet are in the air.
const OFF: f32 = 0.04;

/// The shortest flight that is judged, in seconds.
const FLIGHT: f64 = 0.1;

/// The fraction of the height of a flight by which its path may be off a parabola.
const PARABOLA: f32 = 0.1;

pub(super) fn find(motion: &Motion, findings: &mut Findings<'_>) {
    findings.look_for(&[WrongRate]);
    let by_rate = (RATES[0] / motion.rate).max(motion.rate / RATES[1]) as f32;
    let by_gravity = motion
        .body
        .as_ref()
        .map_or(0.0, |body| too_fast(motion, body).max(too_slow(motion, body)));
    let times = by_rate.max(by_gravity);
    if times > 1.0 {
        let whole = [motion.first, motion.frames - 1];
        findings.add(WrongRate, whole, None, times, confidence(times, 1.25));
    }
}

/// How many times too fast the hips fall, in a tenth of the frames.
fn too_fast(motion: &Motion, body: &Body) -> f32 {
    let half = motion.frames_in(HALF);
    let frames = motion.starts + half..motion.frames.saturating_sub(half);
    let mut falls: Vec<f32> = frames.map(|frame| -motion.rise(frame, body.hips(), half)).collect();
    falls.sort_by(|a, b| b.total_cmp(a));
    let fall = falls.get((OFTEN * falls.len() as f32) as usize).copied();
    (fall.unwrap_or(0.0).max(0.0) / GRAVITY).sqrt()
}

/// How many times too slow bodies in the air fall, by the median of at least two flights along parabolas.
fn too_slow(motion: &Motion, body: &Body) -> f32 {
    let at = |frame: usize| motion.at(frame, body.hips()).y;
    let is_off = |frame: usize| frame >= motion.starts && body.lowest_foot(frame) > OFF;
    let fall = |[from, to]: [usize; 2]| {
        let seconds = (to - from) as f32 / motion.rate as f32;
        let middle = (from + to) / 2;
        let sag = at(middle) - 0.5 * (at(from) + at(to));
        let of_parabola = |frame: usize| {
            let along = (frame - from) as f32 / (to - from) as f32;
            at(from) + (at(to) - at(from)) * along + 4.0 * sag * along * (1.0 - along)
        };
        let off = (from..=to)
            .map(|frame| (at(frame) - of_parabola(frame)).abs())
            .fold(0.0, f32::max);
        let is_flight = f64::from(seconds) >= FLIGHT && sag > 0.01 && off < PARABOLA * sag;
        is_flight.then(|| 8.0 * sag / (seconds * seconds))
    };
    let mut falls: Vec<f32> = spans(motion.frames, is_off).into_iter().filter_map(fall).collect();
    let count = falls.len() as f32;
    let usual = median(&mut falls).unwrap_or(GRAVITY);
    (GRAVITY / usual).sqrt() * ramp(count, 1.0, 2.0)
}
