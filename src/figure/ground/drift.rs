//! Measures height drift: the ground seems to rise or fall under the feet over a motion. Inertial suits cause this.

use std::iter::repeat_n;

use glam::Vec3;
use mocap_scene::math::median::median;

/// The largest speed of a foot in contact with a drifting ground, in m/s.
const SLOW: f32 = 0.4;

/// Half of the time over which the speed of a foot is measured, in seconds. Over a shorter time, noise would add speed.
const AROUND: f64 = 0.05;

/// The shortest stance in seconds, as in running.
const SHORTEST: f64 = 0.1;

/// The longest part of a stance, in seconds. A longer stance is split into several parts.
const PART: f64 = 0.25;

/// The shortest time in seconds between two parts whose heights are compared.
const APART: f32 = 0.15;

/// The largest number of parts. It is limited, because all pairs of parts are compared.
const PARTS: usize = 400;

/// The largest speed of a drift, in m/s. Stairs rise faster.
const FASTEST: f32 = 0.2;

/// At this drift speed, in m/s, and above, the ground drifts only if the feet in contact also rise or sink. On a hill
/// or on stairs, a foot in contact keeps its height.
const HILL: f32 = 0.08;

/// The smallest vertical speed of a foot in contact with a drifting ground, as a fraction of the ground's speed.
const CARRIED: f32 = 0.4;

/// The height drift of the ground in metres, from the median slope between stances (Theil and Sen). `kinds` has the
/// positions of the ankles and of the balls of the feet, frame by frame. `metres` is the length of one unit of these
/// positions, in metres. `None` if there are too few stances.
pub fn height_drift<T: AsRef<[Vec3]>>(kinds: &[Vec<T>], up: Vec3, metres: f32, rate: f64) -> Option<f64> {
    let balls = kinds.get(1).filter(|balls| !balls.is_empty());
    let (mut parts, mut speeds) = (Vec::new(), Vec::new());
    for track in balls.or(kinds.first())? {
        let track = track.as_ref();
        let height = |frame: usize| track[frame].dot(up) * metres;
        for [from, to] in stances(track, metres, rate) {
            // In the first fifth of the stance, the foot comes to rest. In the last fifth, it rolls off.
            let rolls = (to - from) / 5;
            let [from, to] = [from + rolls, to - rolls];
            let seconds = (to - from) as f64 / rate;
            let count = ((seconds / PART) as usize).max(1);
            for part in 0..count {
                let [start, end] = [part, part + 1].map(|part| from + (to + 1 - from) * part / count);
                let heights: f32 = (start..end).map(height).sum();
                let time = 0.5 * (start + end - 1) as f64 / rate;
                parts.push((time as f32, heights / (end - start) as f32));
            }
            speeds.extend(repeat_n(
                (height(to) - height(from)) / seconds.max(1.0 / rate) as f32,
                count,
            ));
        }
    }
    let parts: Vec<_> = parts.iter().step_by(parts.len().div_ceil(PARTS).max(1)).collect();
    let mut slopes = Vec::new();
    for (index, one) in parts.iter().enumerate() {
        let apart = parts[..index].iter().filter(|other| (one.0 - other.0).abs() > APART);
        slopes.extend(apart.map(|other| (one.1 - other.1) / (one.0 - other.0)));
    }
    let (ground, foot) = (median(&mut slopes)?, median(&mut speeds)?);
    let ends = parts.iter().map(|part| part.0);
    let seconds = ends.clone().reduce(f32::max)? - ends.reduce(f32::min)?;
    // An ankle rises in every footstep, so only balls of the feet show that the ground carries the foot.
    let is_carried = ground.abs() < HILL || balls.is_none() || foot * ground.signum() > CARRIED * ground.abs();
    let is_drift = is_carried && ground.abs() < FASTEST;
    Some(if is_drift {
        f64::from(ground.abs() * seconds)
    } else {
        0.0
    })
}

/// The first and the last frame of each stance of a point. In a stance, the point is slow.
fn stances(track: &[Vec3], metres: f32, rate: f64) -> Vec<[usize; 2]> {
    let half = ((AROUND * rate).round() as usize).max(1);
    let shortest = (SHORTEST * rate).ceil().max(2.0) as usize;
    let farthest = SLOW * (2 * half) as f32 / rate as f32;
    let is_slow = |frame: &usize| metres * track[*frame + half].distance(track[*frame - half]) < farthest;
    let slow: Vec<usize> = (half..track.len().saturating_sub(half)).filter(is_slow).collect();
    let runs = slow.chunk_by(|a, b| a + 1 == *b);
    runs.filter(|run| run.len() >= shortest)
        .map(|run| [run[0], run[run.len() - 1]])
        .collect()
}
