//! Changes the frame rate.

use glam::{Quat, Vec3};

use crate::scene::{Animation, AppliedStep, Keys, Scene};
use crate::skeleton;

/// How near, in ticks, a cut may be to a new frame for the two to be one key.
const SAME_TICK: f64 = 1e-6;

/// Gives every animation `frames_per_second` frames per second.
///
/// Positions are interpolated linearly, rotations by slerp. The rest after the last whole new frame, less than one
/// frame, is lost. A [cut](skeleton::cuts) is not interpolated: no value is taken from inside it, and the frames on
/// both sides become keys at their own, uneven ticks.
///
/// Rounded frame times are corrected where the new frames then coincide with old ones: in a file with 0.0083333, which
/// means 1/120, every fourth frame becomes a frame at 30 per second.
///
/// A rate that is not above 0 changes nothing.
pub fn resample(scene: &mut Scene, frames_per_second: f64) {
    if !(frames_per_second.is_finite() && frames_per_second > 0.0) {
        return;
    }
    for index in 0..scene.animations.len() {
        let cuts = skeleton::cuts(scene, index);
        resample_animation(&mut scene.animations[index], frames_per_second, &cuts);
    }
    scene.metadata.steps.push(AppliedStep::Resample { frames_per_second });
}

fn resample_animation(animation: &mut Animation, frames_per_second: f64, cuts: &[usize]) {
    let old_per_new = skeleton::rate_before(animation.ticks_per_second, frames_per_second) / frames_per_second;
    let last = (animation.duration / old_per_new + SAME_TICK).floor();
    let mut moments: Vec<_> = (0..=last as u64)
        .map(|frame| Moment::new(frame as f64, old_per_new))
        .collect();
    if !cuts.is_empty() {
        let inside = |old: f64| {
            cuts.iter()
                .map(|&cut| old - cut as f64)
                .any(|after| SAME_TICK < after && after < 1.0 - SAME_TICK)
        };
        moments.retain(|moment| !inside(moment.old));
        let edges = cuts.iter().flat_map(|&cut| [cut as f64, cut as f64 + 1.0]);
        moments.extend(edges.map(|old| Moment {
            old,
            new: old / old_per_new,
        }));
        // Whole new ticks before edges at the same tick, so that the whole ticks are kept.
        moments.sort_by(|a, b| a.old.total_cmp(&b.old));
        moments.dedup_by(|later, earlier| later.old - earlier.old < SAME_TICK);
    }
    for channel in &mut animation.channels {
        resample_keys(&mut channel.position_keys, &moments, Keys::<Vec3>::sample);
        resample_keys(&mut channel.rotation_keys, &moments, Keys::<Quat>::sample);
        resample_keys(&mut channel.scaling_keys, &moments, Keys::<Vec3>::sample);
    }
    animation.ticks_per_second = frames_per_second;
    animation.duration = moments.last().map_or(last, |moment| moment.new);
}

/// A tick before resampling, and the same moment as a tick after it.
struct Moment {
    old: f64,
    new: f64,
}

impl Moment {
    fn new(new: f64, old_per_new: f64) -> Self {
        Self {
            old: new * old_per_new,
            new,
        }
    }
}

fn resample_keys<T: Copy>(keys: &mut Keys<T>, moments: &[Moment], sample: fn(&Keys<T>, f64) -> Option<T>) {
    if keys.len() > 1 {
        let values = moments.iter().filter_map(|moment| sample(keys, moment.old)).collect();
        *keys = Keys::at_ticks(values, moments.iter().map(|moment| moment.new).collect());
    }
}
