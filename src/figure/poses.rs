//! Chooses a few poses of a motion, which are examined instead of all frames.

use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{Animation, Node, Scene};

/// The number of frames examined, spread evenly over the motion.
const FRAMES: usize = 16;

/// The largest number of frames of all animations that are examined for the roll of bones.
const SAMPLED: usize = 400;

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

/// Calls `see` with some poses of all animations, evenly spaced.
pub(super) fn sample(scene: &Scene, mut see: impl FnMut(&Pose)) {
    let frames: usize = scene.animations.iter().map(Animation::frame_count).sum();
    let step = frames.div_ceil(SAMPLED).max(1);
    let mut pose = Pose::rest(scene);
    for animation in &scene.animations {
        let binding = Binding::new(scene, animation);
        for frame in (0..animation.frame_count()).step_by(step) {
            pose.sample(&binding, animation, frame as f64);
            see(&pose);
        }
    }
}

/// Whether the nodes of two scenes have the same rest pose, so that they share one T-pose.
#[doc(hidden)]
pub fn is_at_rest_alike(scene: &Scene, other: &Scene) -> bool {
    let rest = |node: &Node| node.transform;
    scene.nodes.iter().map(rest).eq(other.nodes.iter().map(rest))
}
