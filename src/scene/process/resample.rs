//! Changes the frame rate.

use glam::{Quat, Vec3};

use super::rate::rate_before;
use crate::error::{Code, Result};
use crate::limits::{self, FrameBudget, Limits};
use crate::scene::report::AppliedStep;
use crate::scene::{Animation, Keys, Scene};

/// The largest difference in ticks between a cut and a new frame that share a key.
const SAME_TICK: f64 = 1e-6;

impl Scene {
    /// Resamples every animation to `frames_per_second`.
    ///
    /// Positions are interpolated linearly, rotations by slerp. The remainder after the last whole new frame, less than
    /// one frame, is dropped. Resampling does not interpolate across a [cut](Scene::cuts). A new frame within the cut
    /// has the value of the nearer side, and the frames on both sides become keys at their own, uneven ticks.
    ///
    /// Rounded frame times are corrected if the new frames then coincide with old ones. For example, 0.0083333 means
    /// 1/120, so at 30 frames per second every fourth frame of the file is a new frame.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the rate is not possible. [`Code::LimitExceeded`] if the new frames would have more
    /// values than [`Limits::max_values`] allows. After an error, `scene` is unchanged.
    #[doc(hidden)]
    pub fn resample(&mut self, frames_per_second: f64, limits: &Limits) -> Result<()> {
        limits::frame_rate(Code::InvalidValue, frames_per_second)?;
        check_size(self, frames_per_second, limits)?;
        for index in 0..self.animations.len() {
            let cuts = self.cuts(index);
            let has_points = self.has_points();
            let moments = resample_animation(&mut self.animations[index], frames_per_second, &cuts, has_points);
            for keys in self.weight_keys().filter_map(|animations| animations.get_mut(index)) {
                resample_keys(keys, &moments, Keys::<f32>::sample);
            }
        }
        self.metadata.steps.push(AppliedStep::Resample { frames_per_second });
        Ok(())
    }
}

/// The caller's frame rate decides the memory, so check the size before allocating.
fn check_size(scene: &Scene, frames_per_second: f64, limits: &Limits) -> Result<()> {
    let mut values = 0_u64;
    let mut asked = Vec::with_capacity(scene.animations.len());
    for (index, animation) in scene.animations.iter().enumerate() {
        let weights = scene.weights_in(index).filter_map(|(_, keys)| keys);
        let keys = animation.channels.iter().flat_map(|channel| {
            let (positions, scales) = (channel.position_keys.len(), channel.scaling_keys.len());
            [(positions, 3), (channel.rotation_keys.len(), 4), (scales, 3)]
        });
        // Each frame also needs one value for its tick.
        let mut values_a_frame = 1;
        for (keys, width) in keys.chain(weights.map(|keys| (keys.len(), 1))) {
            values = values.saturating_add((keys * width) as u64);
            if keys > 1 {
                values_a_frame += width;
            }
        }
        let last = (animation.duration / old_per_new(animation, frames_per_second) + SAME_TICK).floor();
        asked.push((last, values_a_frame));
    }
    let mut budget = FrameBudget::stated_by(limits, values);
    for (last, values_a_frame) in asked {
        budget.frames(last, values_a_frame).map_err(|mut refusal| {
            let frames = refusal.found.unwrap_or_default();
            refusal.found = Some(format!("{frames} at {frames_per_second} frames per second"));
            refusal.help("choose a lower frame rate, or trim the motion")
        })?;
    }
    Ok(())
}

/// The number of old frames per new frame.
fn old_per_new(animation: &Animation, frames_per_second: f64) -> f64 {
    rate_before(animation.ticks_per_second, frames_per_second) / frames_per_second
}

/// Returns the times that have keys afterwards.
fn resample_animation(
    animation: &mut Animation,
    frames_per_second: f64,
    cuts: &[usize],
    has_points: bool,
) -> Vec<Moment> {
    let old_per_new = old_per_new(animation, frames_per_second);
    let last = (animation.duration / old_per_new + SAME_TICK).floor();
    let mut moments: Vec<_> = (0..=last as u64)
        .map(|frame| Moment::new(frame as f64, old_per_new))
        .collect();
    if !cuts.is_empty() {
        for moment in &mut moments {
            if cuts.binary_search(&(moment.old as usize)).is_ok() {
                moment.old = moment.old.round();
            }
        }
        let edges = cuts.iter().flat_map(|&cut| [cut as f64, cut as f64 + 1.0]);
        moments.extend(edges.map(|old| Moment {
            old,
            new: old / old_per_new,
        }));
        moments.sort_by(|a, b| a.new.total_cmp(&b.new));
        moments.dedup_by(|later, earlier| {
            let is_one = (later.new - earlier.new) * old_per_new < SAME_TICK;
            if is_one && later.new.fract() == 0.0 {
                std::mem::swap(later, earlier);
            }
            is_one
        });
    }
    let frames: Vec<(f64, f64)> = match has_points {
        true => moments.iter().map(|moment| (moment.new, moment.old)).collect(),
        false => Vec::new(),
    };
    for channel in &mut animation.channels {
        match has_points {
            true => channel.position_keys = channel.position_keys.of_point_at(&frames),
            false => resample_keys(&mut channel.position_keys, &moments, Keys::<Vec3>::sample),
        }
        resample_keys(&mut channel.rotation_keys, &moments, Keys::<Quat>::sample);
        resample_keys(&mut channel.scaling_keys, &moments, Keys::<Vec3>::sample);
    }
    animation.ticks_per_second = frames_per_second;
    animation.duration = moments.last().map_or(last, |moment| moment.new);
    moments
}

/// A time, as the tick before resampling and the tick after resampling.
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
