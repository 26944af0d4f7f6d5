//! Finds from the motion the rotation of a standing foot, and the rotation of a head relative to the neck.
//!
//! In the rest pose of a motion file, the feet may point down or anywhere. A foot stands on its sole in the frames in
//! which its ankle and ball have their lowest heights.

use glam::{Quat, Vec3};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::math::median::percentile;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, Scene};

use crate::poses::sample;

/// The fraction of all positions of both feet that counts as the lowest positions.
const SHARE: f32 = 0.2;

/// The fraction of an ankle's positions that may be below its lowest height. They are noise.
const NOISE: f64 = 0.02;

/// The smallest number of frames that show the stance of a foot.
const FEWEST: usize = 8;

/// The largest range of the angles in the middle half of the frames that show the stance, in radians.
const SPREAD: f32 = 0.15;

/// The largest height of a standing foot's ankle or ball above its lowest height, as a fraction of the distance between
/// ankle and ball.
const HIGHEST: f32 = 0.35;

/// The smallest slope of a standing foot's toes, from ball to tip: 30 degrees down. With a lifted heel, the toes point
/// further down.
const LEAST_SLOPE: f32 = -0.5;

/// A foot of the reference pose.
pub(super) struct Foot {
    pub(super) joint: NodeId,
    /// The joint of the toes, or the node at the ball of the foot.
    pub(super) ball: Option<NodeId>,
    pub(super) tip: Option<NodeId>,
    /// The rotation from the world to the axes of the figure.
    pub(super) world_to_frame: Quat,
    /// The inverse of the joint's rotation in the T-pose.
    pub(super) joint_to_frame: Quat,
}

/// The rotation of the feet of the reference pose in stance in the motion, in radians.
#[derive(Clone, Debug)]
pub(super) struct Stance {
    /// The pitch of both feet, if the motion shows it. Positive if the toes are higher in the motion than in the
    /// reference pose.
    pub(super) pitch: Option<f32>,
    /// The median roll of each foot, and whether the frames agree. Positive if the left edge is higher.
    pub(super) rolls: Vec<(f32, bool)>,
}

/// The stance of the feet; `None` without a motion.
///
/// A foot stands in frames in which neither its ankle nor its ball can be lower. A lifted heel raises the ankle, and
/// lifted toes raise the ball. Both feet stand on one floor, and have the same shape.
pub(super) fn stance(scene: &Scene, feet: &[Foot]) -> Option<Stance> {
    let seen = samples(scene, feet);
    let least = |of: fn(&Sample) -> f32| {
        let least = seen
            .iter()
            .filter_map(|samples| percentile(samples.iter().map(of), NOISE, f64::floor));
        least.reduce(f32::min)
    };
    let (ankle, ball) = (least(|sample| sample.ankle)?, least(|sample| sample.ball)?);
    let above = |sample: &Sample| (sample.ankle - ankle).max(sample.ball - ball);
    let lowest = |samples: &mut Vec<&Sample>| {
        samples.sort_by(|a, b| above(a).total_cmp(&above(b)));
        samples.truncate(FEWEST.max((samples.len() as f32 * SHARE) as usize));
    };
    let mut standing: Vec<&Sample> = seen.iter().flatten().collect();
    lowest(&mut standing);
    let slope = percentile(standing.iter().filter_map(|sample| sample.slope), 0.5, f64::floor);
    let has_lifted_heels = slope.is_some_and(|slope| slope < LEAST_SLOPE);
    let is_low = standing.iter().all(|sample| above(sample) <= HIGHEST * sample.length);
    let is_clear = is_low && !has_lifted_heels;
    let roll = |samples: &Vec<Sample>| {
        let mut standing: Vec<&Sample> = samples.iter().collect();
        lowest(&mut standing);
        let rolls = || standing.iter().map(|sample| sample.roll);
        Some((
            percentile(rolls(), 0.5, f64::floor)?,
            is_clear && agreed(rolls()).is_some(),
        ))
    };
    Some(Stance {
        pitch: agreed(standing.iter().map(|sample| sample.pitch)).filter(|_| is_clear),
        rolls: seen.iter().map(roll).collect::<Option<_>>()?,
    })
}

/// The median of angles; `None` if the angles differ too much.
fn agreed(angles: impl Iterator<Item = f32>) -> Option<f32> {
    let angles: Vec<f32> = angles.collect();
    let at = |fraction: f64| percentile(angles.iter().copied(), fraction, f64::floor);
    (angles.len() >= FEWEST && at(0.75)? - at(0.25)? <= SPREAD).then(|| at(0.5))?
}

/// A foot in a pose: the heights of ankle and ball, the distance between them, and the rotation.
struct Sample {
    ankle: f32,
    ball: f32,
    length: f32,
    slope: Option<f32>,
    pitch: f32,
    roll: f32,
}

/// The average rotation of a joint relative to another joint. Each joint has the inverse of its rotation in the T-pose.
/// `None` if the motion does not show the rotation.
pub(super) fn mean_turn(scene: &Scene, joint: (NodeId, Quat), other: (NodeId, Quat)) -> Option<Quat> {
    let (mut sum, mut count) = (Quat::from_xyzw(0.0, 0.0, 0.0, 0.0), 0);
    sample(scene, |pose| {
        let turned = |(joint, joint_to_frame): (NodeId, Quat)| {
            let matrix = pose.node_to_world.get(joint.index())?;
            Some(rotation_of(matrix) * joint_to_frame)
        };
        let Some((joint, other)) = turned(joint).zip(turned(other)) else {
            return;
        };
        let turn = other.inverse() * joint;
        if turn.is_finite() {
            // A quaternion and its negative are the same rotation.
            sum = sum + if sum.dot(turn) < 0.0 { -turn } else { turn };
            count += 1;
        }
    });
    (count >= FEWEST && sum.length() > 0.5 * count as f32).then(|| sum.normalize())
}

/// The samples of each foot.
fn samples(scene: &Scene, feet: &[Foot]) -> Vec<Vec<Sample>> {
    let mut samples: Vec<Vec<Sample>> = feet.iter().map(|_| Vec::new()).collect();
    sample(scene, |pose| {
        for (samples, foot) in samples.iter_mut().zip(feet) {
            samples.extend(Sample::of(pose, foot));
        }
    });
    samples
}

impl Sample {
    fn of(pose: &Pose, foot: &Foot) -> Option<Self> {
        let matrix = pose.node_to_world.get(foot.joint.index())?;
        let turned: Quat = foot.world_to_frame * rotation_of(matrix) * foot.joint_to_frame;
        let at = |node: NodeId| foot.world_to_frame * pose.position(node);
        let ankle = at(foot.joint);
        let ball = foot.ball.map_or(ankle, at);
        let toes = foot.tip.and_then(|tip| (at(tip) - ball).try_normalize());
        let sample = Self {
            ankle: ankle.y,
            ball: ball.y,
            length: ankle.distance(ball),
            slope: toes.map(|toes| toes.y),
            pitch: (turned * Vec3::Z).y.clamp(-1.0, 1.0).asin(),
            roll: (turned * Vec3::X).y.atan2((turned * Vec3::Y).y),
        };
        let values = [sample.ankle, sample.ball, sample.pitch, sample.roll];
        values.iter().all(|value| value.is_finite()).then_some(sample)
    }
}
