//! Which way a foot is turned when it stands on its sole, seen in the motion.
//!
//! Rest poses of motion files are drawn by programs, not by feet: a foot may point down there, or anywhere. A foot that is
//! low and slow stands on its sole.

use glam::{Quat, Vec3};

use super::rotations::rotation_of;
use crate::pose::{Binding, Pose};
use crate::scene::{Animation, NodeId, Scene};

/// Frames of all animations that are examined at most.
const FRAMES: usize = 400;

/// The share of frames in which a foot is lowest and slowest.
const SHARE: f32 = 0.4;

/// The fewest frames that show how a foot stands.
const FEWEST: usize = 8;

/// The largest difference of the middle half of these frames, in radians.
const SPREAD: f32 = 0.15;

/// The smallest pitch that counts, in radians.
const SMALLEST: f32 = 0.02;

/// A foot of the reference pose.
pub(super) struct Foot {
    pub(super) joint: NodeId,
    /// From the world to the axes of the figure.
    pub(super) world_to_frame: Quat,
    /// The inverse of the joint's rotation in the T-pose.
    pub(super) joint_to_frame: Quat,
}

/// How far a foot of the reference pose points up where it stands in the motion, in radians. Positive where the toes of
/// the motion are higher than those of the reference pose.
pub(super) fn pitch(scene: &Scene, foot: &Foot, largest: f32) -> Option<f32> {
    let mut samples = samples(scene, foot);
    let limit = |mut values: Vec<f32>| {
        values.sort_by(f32::total_cmp);
        values.get((values.len() as f32 * SHARE) as usize).copied()
    };
    let height = limit(samples.iter().map(|sample| sample.height).collect())?;
    let speed = limit(samples.iter().map(|sample| sample.speed).collect())?;
    samples.retain(|sample| sample.height <= height && sample.speed <= speed);
    let mut pitches: Vec<f32> = samples.iter().map(|sample| sample.pitch).collect();
    pitches.sort_by(f32::total_cmp);
    let at = |share: f32| pitches[((pitches.len() - 1) as f32 * share) as usize];
    if pitches.len() < FEWEST || at(0.75) - at(0.25) > SPREAD {
        return None;
    }
    Some(at(0.5)).filter(|pitch| (SMALLEST..=largest).contains(&pitch.abs()))
}

struct Sample {
    height: f32,
    speed: f32,
    pitch: f32,
}

fn samples(scene: &Scene, foot: &Foot) -> Vec<Sample> {
    let joint = foot.joint;
    let frames: usize = scene.animations.iter().map(Animation::frame_count).sum();
    let step = frames.div_ceil(FRAMES).max(1);
    let (mut pose, mut next) = (Pose::rest(scene), Pose::rest(scene));
    let mut samples = Vec::new();
    for animation in &scene.animations {
        let binding = Binding::new(scene, animation);
        for frame in (0..animation.frame_count().saturating_sub(1)).step_by(step) {
            pose.sample(&binding, animation, frame as f64);
            next.sample(&binding, animation, frame as f64 + 1.0);
            let Some(matrix) = pose.node_to_world.get(joint.index()) else {
                continue;
            };
            let turned: Quat = foot.world_to_frame * rotation_of(matrix) * foot.joint_to_frame;
            let way = next.position(joint) - pose.position(joint);
            samples.push(Sample {
                height: (foot.world_to_frame * pose.position(joint)).y,
                speed: way.length() * animation.ticks_per_second as f32,
                pitch: (turned * Vec3::Z).y.clamp(-1.0, 1.0).asin(),
            });
        }
    }
    samples.retain(|sample| sample.height.is_finite() && sample.speed.is_finite() && sample.pitch.is_finite());
    samples
}
