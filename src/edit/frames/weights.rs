//! The weights of morph targets in every frame.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{FrameBudget, Limits};
use mocap_scene::scene::{Keys, Scene};

use super::Frames;
use crate::inertia::fade;

/// The weights of all morph targets of a scene, in the order of [`Scene::weight_keys`].
#[derive(Clone, Default)]
pub(super) struct Weights {
    targets: Vec<Target>,
}

#[derive(Clone)]
struct Target {
    at_rest: f32,
    /// The weight in every frame. Empty if the animation has no keys.
    values: Vec<f32>,
}

impl Target {
    /// The weight at a fractional frame. Before the first frame, the weight of the first frame; after the last frame,
    /// the weight of the last frame.
    fn at(&self, frame: f64) -> f32 {
        let Some(last) = self.values.len().checked_sub(1) else {
            return self.at_rest;
        };
        let frame = frame.clamp(0.0, last as f64);
        let (before, part) = (frame.floor() as usize, frame.fract() as f32);
        let (from, to) = (self.values[before], self.values[(before + 1).min(last)]);
        from + part * (to - from)
    }
}

impl Weights {
    /// # Errors
    /// [`Code::LimitExceeded`] if the animation has far too many frames for its number of keys.
    pub(super) fn new(scene: &Scene, animation: usize, ticks: &[f64]) -> Result<Self> {
        let keys = || scene.weights_in(animation).filter_map(|(_, keys)| keys);
        let stated: usize = keys().map(Keys::len).sum();
        FrameBudget::stated_by(&Limits::default(), stated as u64).frames(ticks.len() as f64, keys().count())?;
        let target = |(at_rest, keys): (f32, Option<&Keys<f32>>)| {
            let at = |tick: &f64| keys.and_then(|keys| keys.sample(*tick)).unwrap_or(at_rest);
            let values = keys.map(|_| ticks.iter().map(at).collect());
            Target {
                at_rest,
                values: values.unwrap_or_default(),
            }
        };
        Ok(Self {
            targets: scene.weights_in(animation).map(target).collect(),
        })
    }

    /// The weights of the first `count` frames. Further frames repeat the weights of the last frame.
    pub(super) fn with_frames(&self, count: usize) -> Self {
        self.taken((0..count).map(|frame| (self, frame as f64)))
    }

    /// The weights of frames that come from this motion and from other motions. If a motion lacks a morph target, its
    /// frames have the weight of the target at rest.
    pub(super) fn taken<'a>(&self, frames: impl Iterator<Item = (&'a Self, f64)> + Clone) -> Self {
        let target = |(index, own): (usize, &Target)| {
            let of = |motion: &'a Self| {
                let is_alike = motion.targets.len() == self.targets.len();
                motion.targets.get(index).filter(|_| is_alike)
            };
            let has_keys = |(motion, _)| of(motion).is_some_and(|target| !target.values.is_empty());
            let at = |(motion, frame)| of(motion).map_or(own.at_rest, |target| target.at(frame));
            let values = frames.clone().any(has_keys).then(|| frames.clone().map(at).collect());
            Target {
                at_rest: own.at_rest,
                values: values.unwrap_or_default(),
            }
        };
        Self {
            targets: self.targets.iter().enumerate().map(target).collect(),
        }
    }

    /// Writes these weights as the keys of an animation's morph targets.
    pub(super) fn write(&self, scene: &mut Scene, animation: usize, ticks: &[f64]) {
        let count = scene.animations.len();
        for (animations, target) in scene.weight_keys().zip(&self.targets) {
            let values = &target.values;
            if values.is_empty() && animations.get(animation).is_none_or(Keys::is_empty) {
                continue;
            }
            animations.resize(count.max(animations.len()), Keys::default());
            animations[animation] = match values.split_first() {
                Some((first, others)) if others.iter().all(|weight| weight == first) => Keys::constant(*first),
                _ => Keys::at_ticks(values.clone(), ticks.to_vec()),
            };
        }
    }
}

/// A warning if the second motion moves morph targets that the first motion lacks.
pub(crate) fn lost_weights(scene: &Scene, second: &Scene) -> Option<Diagnostic> {
    let curves = second.weight_curves();
    let is_alike = scene.weights_in(0).count() == second.weights_in(0).count();
    (curves > 0 && !is_alike).then(|| {
        let message =
            format!("the second motion moves morph targets that the first motion lacks; dropped curves: {curves}");
        Diagnostic::new(Code::Unrepresentable, message).help("take both motions from one character")
    })
}

impl Frames<'_> {
    /// Fades out the jump of morph weights between a frame of one motion and a frame of another, within `steps` frames
    /// after `seam`.
    pub(crate) fn fade_weights(&mut self, seam: usize, [from, to]: [(&Self, f64); 2], steps: usize) {
        let is_alike = |motion: &Self| motion.weights.targets.len() == self.weights.targets.len();
        if !(is_alike(from.0) && is_alike(to.0)) {
            return;
        }
        for (index, target) in self.weights.targets.iter_mut().enumerate() {
            let [at_seam, next] = [from, to].map(|(motion, frame)| motion.weights.targets[index].at(frame));
            let offset = Vec3::splat(at_seam - next);
            for (frame, weight) in target.values.iter_mut().skip(seam).enumerate() {
                match frame {
                    0 => *weight = at_seam,
                    _ => *weight += fade(offset, Vec3::ZERO, frame, steps).x,
                }
            }
        }
    }

    /// Blends the morph weights of two motions. For each frame, `taken` has a frame of both motions and the weight of
    /// the second motion.
    pub(crate) fn mix_weights(&mut self, (first, second): (&Self, &Self), frames: &[(f64, f64, f32)]) {
        let one = first.weights.taken(frames.iter().map(|(a, ..)| (&first.weights, *a)));
        let two = first
            .weights
            .taken(frames.iter().map(|(_, b, _)| (&second.weights, *b)));
        for (index, target) in self.weights.targets.iter_mut().enumerate() {
            let (one, two) = (&one.targets[index], &two.targets[index]);
            let mixed = frames.iter().enumerate().map(|(frame, (_, _, part))| {
                let (from, to) = (one.at(frame as f64), two.at(frame as f64));
                from + part * (to - from)
            });
            let is_still = one.values.is_empty() && two.values.is_empty();
            target.values = if is_still { Vec::new() } else { mixed.collect() };
        }
    }
}
