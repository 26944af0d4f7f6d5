//! Repairs the depth of an estimate from one camera. Along the axis of the camera, the body jitters and wavers several
//! times as much as in other directions. Jitter is noise from frame to frame, and wavering is slower.
//!
//! The axis is the direction in which the jitter is far larger than in other directions. Wavering moves the whole body
//! with both feet, so the slower foot shows it. A movement that lasts for seconds is kept, because it may be a walk.

use glam::{DMat3, DVec2, DVec3, Mat4};
use mocap_scene::math::median::{MEDIAN_OF_NORMAL, median};

use super::noise::without_noise;
use super::pace::Bank;
use super::smoother::Positions;
use crate::floor::{Feet, axes};
use crate::frames::tracks;
use crate::work::Work;

/// The order of the difference that shows noise. In the fourth difference, the share of the motion is small.
const ORDER: usize = 4;

/// The factor by which the difference of this order multiplies the variance of white noise: 8! / (4!)^2.
const OF_WHITE: f64 = 70.0;

/// The least ratio of noise along the axis to noise across it. Rotations alone cause a smaller ratio.
const TIMES: f64 = 2.5;

/// The smallest jitter along the axis that is removed, in metres. Estimates from video have more jitter, and markers
/// have less.
const LEAST_JITTER: f64 = 6e-3;

/// The largest speed of the wavering, in m/s. If the slower foot is faster, the figure walks.
const FASTEST: f64 = 0.6;

/// The largest speed of the slower foot across the axis, in m/s. Wavering moves a foot in stance only along the axis.
const ACROSS: f64 = 0.15;

/// The smallest length of the horizontal part of the axis, as a fraction. If the camera looks down more steeply, feet
/// do not show the wavering.
const LEVEL: f64 = 0.7;
/// The least fraction of the frames in which a foot must be in stance.
const STANDING: f64 = 0.4;
/// The longest motion that counts as wavering, in seconds. A longer motion is a walk or a drift.
const SLOWEST: f64 = 3.0;
/// The least standard deviation of the depth that counts as wavering, in metres.
const LEAST_WAVER: f64 = 0.012;

/// The speed below which the slower foot is in stance after the repair, in m/s: half of a slow step.
const STILL: f64 = 0.2;

/// The least fraction of the frames in which the slower foot must be in stance after the repair. The slower foot is
/// always in stance in a walk, and mostly in a dance.
const STANDS: f64 = 0.65;
/// The time in seconds over which the correction is smoothed, because it jumps when the other foot becomes the slower
/// one.
const SMOOTH: f64 = 0.08;

/// Removes the jitter along the axis. Returns its standard deviation in metres, and stores the axis in `work`.
pub(super) fn steady(work: &mut Work<'_>, bank: &Bank) -> Option<f64> {
    let carrier = work.carrier()?;
    let node = work.frames.nodes()[carrier];
    let metres = f64::from(work.metres);
    let track: Vec<DVec3> = tracks(&work.frames, work.scene, &[node])
        .swap_remove(0)
        .iter()
        .map(|position| position.as_dvec3() * metres)
        .collect();
    let axis = noisiest(&track)?;
    // The smoother takes vectors, so the coordinate along the axis is repeated on all three axes.
    let along: Vec<DVec3> = track.iter().map(|position| DVec3::splat(position.dot(axis))).collect();
    let is_noise = |noise: f64| noise >= work.weights.least_distance;
    let (smooth, noise) = without_noise::<Positions>(&along, &work.missing, work.frames.rate, bank, true, is_noise)?;
    let shifts: Vec<DVec3> = smooth
        .iter()
        .zip(&along)
        .map(|(to, from)| axis * (to.x - from.x) / metres)
        .collect();
    shift(work, carrier, &shifts);
    work.depth = Some(axis);
    Some(noise)
}

fn shift(work: &mut Work<'_>, carrier: usize, shifts: &[DVec3]) {
    work.carry(carrier, |frame| {
        Mat4::from_translation(shifts[frame.min(shifts.len() - 1)].as_vec3())
    });
}

/// The direction in which a track has far more noise than in other directions. `None` if there is no such direction.
fn noisiest(track: &[DVec3]) -> Option<DVec3> {
    let mut differences = track.to_vec();
    for _ in 0..ORDER {
        for index in 0..differences.len().saturating_sub(1) {
            differences[index] = differences[index + 1] - differences[index];
        }
        differences.pop();
    }
    differences.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    // The largest differences come from footsteps and jumps, not from noise.
    let calm = &differences[..differences.len() * 7 / 10];
    let outer = |d: &DVec3| DMat3::from_cols(*d * d.x, *d * d.y, *d * d.z);
    let spread = calm.iter().map(outer).fold(DMat3::ZERO, |sum, one| sum + one);
    // The power method (von Mises). It converges fast, because the largest eigenvalue is far larger than the others.
    let mut axis = DVec3::new(0.6, 0.5, 0.62);
    for _ in 0..64 {
        axis = (spread * axis).try_normalize()?;
    }
    let noise = |direction: DVec3| {
        let mut sizes: Vec<f64> = differences.iter().map(|d| d.dot(direction).abs()).collect();
        median(&mut sizes).unwrap_or_default() / MEDIAN_OF_NORMAL / OF_WHITE.sqrt()
    };
    let (one, other) = axis.any_orthonormal_pair();
    let along = noise(axis);
    (along > LEAST_JITTER && along > TIMES * noise(one).max(noise(other))).then_some(axis)
}

/// Removes the wavering along the axis of the jitter. Returns the largest displacement of the body, in metres.
pub(super) fn still(work: &mut Work<'_>) -> Option<f64> {
    let carrier = work.carrier()?;
    let [x, y, _] = axes(work.up).map(glam::Vec3::as_dvec3);
    let depth = work.depth?;
    // If the camera looks down, its axis is nearly vertical, so wavering along the axis does not move the feet over the
    // ground.
    let best = DVec2::new(depth.dot(x), depth.dot(y));
    let best = (best.length() > LEVEL).then(|| best.normalize())?;
    let feet = Feet::new(work);
    let ground = feet.ground(FASTEST);
    if (ground.iter().flatten().count() as f64) < STANDING * ground.len() as f64 {
        return None;
    }
    let wavers = |direction: DVec2| {
        let across = direction.perp();
        let along = ground.iter().map(|velocity| {
            let velocity = (*velocity)?.truncate();
            (velocity.dot(across).abs() < ACROSS).then(|| velocity.dot(direction))
        });
        of_seconds(along.collect(), work.frames.rate)
    };
    let drift = wavers(best);
    let size = (drift.iter().map(|at| at * at).sum::<f64>() / drift.len().max(1) as f64).sqrt();
    if size < LEAST_WAVER {
        return None;
    }
    let axis = (x * best.x + y * best.y) / f64::from(work.metres);
    let shifts: Vec<DVec3> = drift.iter().map(|at| -axis * *at).collect();
    let old = work.frames.clone();
    shift(work, carrier, &shifts);
    // A foot that was in the air, such as a runner's, must not be in stance after the repair.
    let stands = Feet::new(work).ground(STILL).iter().flatten().count() as f64;
    if stands < STANDS * drift.len() as f64 {
        work.frames = old;
        return None;
    }
    Some(drift.iter().fold(0.0, |most: f64, at| most.max(at.abs())))
}

/// The displacement that the speeds cause in each frame, without movements that last for seconds. Unknown speeds are
/// interpolated.
fn of_seconds(speeds: Vec<Option<f64>>, rate: f64) -> Vec<f64> {
    let mut at = 0.0;
    let mut drift = Vec::with_capacity(speeds.len());
    let known: Vec<(usize, f64)> = speeds
        .iter()
        .enumerate()
        .filter_map(|(frame, speed)| Some((frame, (*speed)?)))
        .collect();
    let mut next = 0;
    for frame in 0..speeds.len() {
        while next < known.len() && known[next].0 < frame {
            next += 1;
        }
        let after = known.get(next).copied();
        let before = next.checked_sub(1).map(|last| known[last]);
        let speed = match (before, after) {
            (Some((from, a)), Some((to, b))) => a + (b - a) * (frame - from) as f64 / (to - from) as f64,
            (Some((_, only)), None) | (None, Some((_, only))) => only,
            (None, None) => 0.0,
        };
        at += speed / rate;
        drift.push(at);
    }
    let slow = smooth(&drift, (0.5 * SLOWEST * rate) as usize);
    let drift: Vec<f64> = drift.iter().zip(slow).map(|(drift, slow)| drift - slow).collect();
    smooth(&drift, (SMOOTH * rate).round() as usize)
}

/// The value at each frame of a line of least squares through the frames within `radius`.
fn smooth(values: &[f64], radius: usize) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |frame: usize| {
        // Near an end of the motion, fewer frames are on one side. A line fits such frames better than a mean.
        let around = frame.saturating_sub(radius)..=(frame + radius).min(last);
        let (mut sums, count) = ([0.0; 4], around.clone().count() as f64);
        for other in around {
            let t = other as f64 - frame as f64;
            let terms = [t, values[other], t * t, t * values[other]];
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let [t, v, tt, tv] = sums;
        let spread = count * tt - t * t;
        let slope = if spread > 0.0 {
            (count * tv - t * v) / spread
        } else {
            0.0
        };
        (v - slope * t) / count
    };
    (0..values.len()).map(at).collect()
}
