//! Motions that play too fast or too slow, according to gravity or to an implausible frame rate.
//!
//! A body in the air accelerates downwards by 9.81 m/s^2. If the motion plays too fast by a factor f, the acceleration
//! is f^2 times as large. No body accelerates downwards faster than in free fall, because legs push and do not pull.

use mocap_scene::math::median::median;

use super::{Findings, confidence, ramp};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::WrongRate;

/// The acceleration of gravity in m/s^2.
const GRAVITY: f32 = 9.81;

/// The lowest and the highest plausible rate of a recording, in frames per second.
const RATES: [f64; 2] = [5.0, 1000.0];

/// Half the window over which accelerations are computed, in seconds. Noise of 1 mm then causes an error of 3 m/s^2. In
/// a walk played five times too fast, a step takes 0.1 s.
const HALF: f64 = 0.03;

/// The least fraction of all frames in which the hips must fall too fast. A single fast fall is another defect.
const OFTEN: f32 = 0.1;

/// The height above which a foot is in the air, in metres.
const OFF: f32 = 0.04;

/// The shortest flight to measure, in seconds.
const FLIGHT: f64 = 0.1;

/// The largest deviation of a flight from a parabola, as a fraction of the height of the flight.
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
        findings.add(WrongRate, whole, None, times, confidence(times, 1.3));
    }
}

/// The factor by which the hips fall too fast in a tenth of the frames.
fn too_fast(motion: &Motion, body: &Body) -> f32 {
    let half = motion.frames_in(HALF);
    let frames = motion.starts + half..motion.frames.saturating_sub(half);
    let mut falls: Vec<f32> = frames.map(|frame| -motion.rise(frame, body.hips(), half)).collect();
    falls.sort_by(|a, b| b.total_cmp(a));
    let fall = falls.get((OFTEN * falls.len() as f32) as usize).copied();
    (fall.unwrap_or(0.0).max(0.0) / GRAVITY).sqrt()
}

/// The factor by which the body in the air falls too slowly: the median of at least two flights along parabolas.
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
