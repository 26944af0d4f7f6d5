//! A few poses of a motion, to look at instead of all of it.

use crate::pose::{Binding, Pose};
use crate::scene::Scene;

/// The number of frames examined, spread evenly over the motion.
const FRAMES: usize = 16;

/// Poses spread over the first animation, or the rest pose without one.
pub(super) fn poses(scene: &Scene) -> Vec<Pose> {
    let mut pose = Pose::rest(scene);
    let Some(animation) = scene.animations.first() else {
        return vec![pose];
    };
    let binding = Binding::new(scene, animation);
    let at = |sample: usize| animation.duration * sample as f64 / (FRAMES - 1) as f64;
    let mut posed = |sample| {
        pose.sample(&binding, animation, at(sample).round());
        pose.clone()
    };
    (0..FRAMES).map(&mut posed).collect()
}
