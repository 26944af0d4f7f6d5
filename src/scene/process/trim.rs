//! Trims a motion.

use glam::{Quat, Vec3};

use crate::scene::report::AppliedStep;
use crate::scene::{Keys, Scene};

impl Scene {
    /// Keeps the interval between two ticks, both included, of every animation. `first` becomes tick 0.
    ///
    /// Ticks outside of the motion are moved to its ends. A `last` before `first` is moved to `first`, so that one
    /// frame remains. If a tick is between two keys, the value there becomes a key.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// scene.trim(2.0, 5.0);
    /// assert_eq!(scene.animations[0].frame_count(), 4);
    /// // The lecture's posKey 2 of Shoulder.
    /// assert!((scene.animations[0].channels[0].position_keys.values[0].x - 0.3).abs() < 1e-6);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[doc(hidden)]
    pub fn trim(&mut self, first: f64, last: f64) {
        let end = self
            .animations
            .iter()
            .map(|animation| animation.duration)
            .fold(0.0, f64::max);
        // NaN means the start, as when a pose is sampled.
        let first = first.min(end).max(0.0);
        let last = last.min(end).max(first);
        // A clip that ends earlier has no frames after its own end.
        let part_of = |end: f64| (first.min(end), last.min(end));
        let has_points = self.has_points();
        let ends: Vec<f64> = self.animations.iter().map(|animation| animation.duration).collect();
        for animation in &mut self.animations {
            let (first, last) = part_of(animation.duration);
            let frames: Vec<(f64, f64)> = match has_points {
                true => (0..=(last - first).floor() as u64)
                    .map(|frame| (frame as f64, first + frame as f64))
                    .collect(),
                false => Vec::new(),
            };
            for channel in &mut animation.channels {
                match has_points {
                    true => channel.position_keys = channel.position_keys.of_point_at(&frames),
                    false => trim_keys(&mut channel.position_keys, first, last, Keys::<Vec3>::sample),
                }
                trim_keys(&mut channel.rotation_keys, first, last, Keys::<Quat>::sample);
                trim_keys(&mut channel.scaling_keys, first, last, Keys::<Vec3>::sample);
            }
            animation.duration = last - first;
        }
        for animations in self.weight_keys() {
            for (keys, end) in animations.iter_mut().zip(&ends) {
                let (first, last) = part_of(*end);
                trim_keys(keys, first, last, Keys::<f32>::sample);
            }
        }
        self.metadata.steps.push(AppliedStep::Trim { first, last });
    }
}

fn trim_keys<T: Copy>(keys: &mut Keys<T>, first: f64, last: f64, sample: fn(&Keys<T>, f64) -> Option<T>) {
    if keys.len() <= 1 {
        return;
    }
    let between = (0..keys.len()).filter(|&key| first < keys.tick(key) && keys.tick(key) < last);
    let mut kept: Vec<_> = between.map(|key| (keys.tick(key), keys.values[key])).collect();
    if let Some(value) = sample(keys, first) {
        kept.insert(0, (first, value));
    }
    if last > first
        && let Some(value) = sample(keys, last)
    {
        kept.push((last, value));
    }
    *keys = Keys::at_ticks(
        kept.iter().map(|(_, value)| *value).collect(),
        kept.iter().map(|(tick, _)| tick - first).collect(),
    );
}
