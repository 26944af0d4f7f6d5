//! How a foot is turned when it stands on its sole, and a head on its neck, seen in the motion.
//!
//! Rest poses of motion files are drawn by programs, not by feet: a foot may point down there, or anywhere. A foot that
//! is low and slow stands on its sole.

use glam::{Quat, Vec3};

use crate::math::directions::rotation_of;
use crate::pose::{Binding, Pose};
use crate::scene::{Animation, NodeId, Scene};

/// Frames of all animations that are examined at most.
const FRAMES: usize = 400;

/// The fraction of frames in which a foot is lowest and slowest.
const SHARE: f32 = 0.4;

/// The fewest frames that show how a foot stands.
const FEWEST: usize = 8;

/// The largest difference of the middle half of these frames, in radians.
const SPREAD: f32 = 0.15;

/// A foot of the reference pose.
pub(super) struct Foot {
    pub(super) joint: NodeId,
    /// From the world to the axes of the figure.
    pub(super) world_to_frame: Quat,
    /// The inverse of the joint's rotation in the T-pose.
    pub(super) joint_to_frame: Quat,
}

/// How a foot of the reference pose is turned where it stands in the motion, in radians.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stance {
    /// Positive where the toes of the motion are higher than those of the reference pose.
    pub(super) pitch: f32,
    /// Positive where the left edge is higher; `None` where it differs.
    pub(super) roll: Option<f32>,
}

/// How each foot stands; `None` where the motion does not show it.
pub(super) fn stances(scene: &Scene, feet: &[Foot]) -> Vec<Option<Stance>> {
    samples(scene, feet).into_iter().map(stance).collect()
}

fn stance(mut samples: Vec<Sample>) -> Option<Stance> {
    let limit = |mut values: Vec<f32>| {
        values.sort_by(f32::total_cmp);
        values.get((values.len() as f32 * SHARE) as usize).copied()
    };
    let height = limit(samples.iter().map(|sample| sample.height).collect())?;
    let speed = limit(samples.iter().map(|sample| sample.speed).collect())?;
    samples.retain(|sample| sample.height <= height && sample.speed <= speed);
    let median = |mut angles: Vec<f32>| {
        angles.sort_by(f32::total_cmp);
        let at = |share: f32| angles[((angles.len() - 1) as f32 * share) as usize];
        // One who dances lifts a heel in some of these frames: the most frequent angle is not that of a flat foot.
        (angles.len() >= FEWEST && at(0.75) - at(0.25) <= SPREAD).then(|| at(0.5))
    };
    Some(Stance {
        pitch: median(samples.iter().map(|sample| sample.pitch).collect())?,
        roll: median(samples.iter().map(|sample| sample.roll).collect()),
    })
}

struct Sample {
    height: f32,
    speed: f32,
    pitch: f32,
    roll: f32,
}

/// How a joint is turned against another on the average, each given with the inverse of its rotation in the T-pose;
/// `None` where the motion does not show it.
pub(super) fn mean_turn(scene: &Scene, joint: (NodeId, Quat), other: (NodeId, Quat)) -> Option<Quat> {
    let (mut sum, mut count) = (Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), 0);
    sample(scene, |pose, _, _| {
        let turned = |(joint, joint_to_frame): (NodeId, Quat)| {
            let matrix = pose.node_to_world.get(joint.index())?;
            Some(rotation_of(matrix) * joint_to_frame)
        };
        let Some((joint, other)) = turned(joint).zip(turned(other)) else {
            return;
        };
        let turn = other.inverse() * joint;
        if turn.is_finite() {
            // A rotation and its negative are one.
            sum = sum + if sum.dot(turn) < 0.0 { -turn } else { turn };
            count += 1;
        }
    });
    (count >= FEWEST && sum.length() > 0.5 * count as f32).then(|| sum.normalize())
}

/// Those of each foot.
fn samples(scene: &Scene, feet: &[Foot]) -> Vec<Vec<Sample>> {
    let mut samples: Vec<Vec<Sample>> = feet.iter().map(|_| Vec::new()).collect();
    sample(scene, |pose, next, animation| {
        for (samples, foot) in samples.iter_mut().zip(feet) {
            let Some(matrix) = pose.node_to_world.get(foot.joint.index()) else {
                continue;
            };
            let turned: Quat = foot.world_to_frame * rotation_of(matrix) * foot.joint_to_frame;
            let way = next.position(foot.joint) - pose.position(foot.joint);
            let sample = Sample {
                height: (foot.world_to_frame * pose.position(foot.joint)).y,
                speed: way.length() * animation.ticks_per_second as f32,
                pitch: (turned * Vec3::Z).y.clamp(-1.0, 1.0).asin(),
                roll: (turned * Vec3::X).y.atan2((turned * Vec3::Y).y),
            };
            if [sample.height, sample.speed, sample.pitch, sample.roll]
                .iter()
                .all(|value| value.is_finite())
            {
                samples.push(sample);
            }
        }
    });
    samples
}

/// Calls `see` with some poses, evenly spaced, each with the one a tick later.
fn sample(scene: &Scene, mut see: impl FnMut(&Pose, &Pose, &Animation)) {
    let frames: usize = scene.animations.iter().map(Animation::frame_count).sum();
    let step = frames.div_ceil(FRAMES).max(1);
    let (mut pose, mut next) = (Pose::rest(scene), Pose::rest(scene));
    for animation in &scene.animations {
        let binding = Binding::new(scene, animation);
        for frame in (0..animation.frame_count().saturating_sub(1)).step_by(step) {
            pose.sample(&binding, animation, frame as f64);
            next.sample(&binding, animation, frame as f64 + 1.0);
            see(&pose, &next, animation);
        }
    }
}
