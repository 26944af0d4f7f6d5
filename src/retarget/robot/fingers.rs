//! Fingers of a robot bend like the source's fingers, from open to a fist.
//!
//! Hands of robots have fewer joints than human hands, and other axes. A joint below a hand that bends only to one
//! side, by its limits, is a finger joint. It moves through its range as the finger of the source moves through the
//! human range.

use glam::Vec3;
use mocap_figure::Humanoid;
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::robot::{JointKind, Robot};
use mocap_scene::scene::{Animation, HumanoidBone as Bone, NodeId, Scene, Side};

use super::kinematics::Kinematics;
use super::motion::RobotMotion;
use super::twin::StandIn;

/// The ranges of a finger's joints in degrees: knuckle, middle and end (American Academy of Orthopaedic Surgeons, Joint
/// Motion, 1965).
pub const FINGER: [f64; 3] = [90.0, 100.0, 90.0];

/// The ranges of a thumb's joints in degrees, from the same source.
const THUMB: [f64; 3] = [15.0, 50.0, 80.0];

/// The bones of each finger, and the words for this finger in a robot's file.
const FINGERS: [([Bone; 3], &[&str]); 5] = [
    (
        [
            Bone::LeftThumbMetacarpal,
            Bone::LeftThumbProximal,
            Bone::LeftThumbDistal,
        ],
        &["thumb"],
    ),
    (
        [
            Bone::LeftIndexProximal,
            Bone::LeftIndexIntermediate,
            Bone::LeftIndexDistal,
        ],
        &["index"],
    ),
    (
        [
            Bone::LeftMiddleProximal,
            Bone::LeftMiddleIntermediate,
            Bone::LeftMiddleDistal,
        ],
        &["middle"],
    ),
    (
        [Bone::LeftRingProximal, Bone::LeftRingIntermediate, Bone::LeftRingDistal],
        &["ring"],
    ),
    (
        [
            Bone::LeftLittleProximal,
            Bone::LeftLittleIntermediate,
            Bone::LeftLittleDistal,
        ],
        &["little", "pinky"],
    ),
];

/// A joint bends only to one side if its limit on this side is this multiple of the other limit.
const ONE_SIDED: f64 = 3.0;

/// The largest speed of a finger, in rad/s: below the threshold of a jump.
const FASTEST: f64 = 13.0;

/// A finger joint of the robot.
#[derive(Clone, Debug)]
pub struct Joint {
    pub position: usize,
    /// The position in an open hand, and in a fist.
    pub open: f64,
    pub bent: f64,
    /// The fingers of the source that the joint follows, by side and index.
    pub follows: Vec<(Side, usize)>,
    /// The largest speed, in radians per second.
    pub fastest: f64,
}

/// A joint of the source with its neighbours, and its range in radians. The bend is the angle between both bones,
/// because rest poses of hands are rarely flat.
#[derive(Clone, Debug)]
pub struct FingerBend {
    pub before: NodeId,
    pub at: NodeId,
    pub after: NodeId,
    pub range: f64,
}

/// The fingers of a robot and of the source.
#[derive(Clone, Debug)]
pub struct Fingers {
    pub joints: Vec<Joint>,
    /// The joints of the source, for each side and finger.
    pub source: [Vec<Vec<FingerBend>>; 2],
}

impl Fingers {
    pub(super) fn new(
        robot: &Robot,
        kinematics: &Kinematics,
        twin: &StandIn,
        source: &Scene,
        bones: &Humanoid,
    ) -> Self {
        let source = Side::ALL.map(|side| {
            let fingers = FINGERS.iter().enumerate().map(|(finger, (found, _))| {
                let ranges = if finger == 0 { THUMB } else { FINGER };
                let joint = |index: usize| bones.joint(found.get(index)?.on(side));
                let joints = (0..found.len()).filter_map(|index| {
                    let at = joint(index)?;
                    let below = || {
                        let mut nodes = (0..source.nodes.len()).map(NodeId::new);
                        nodes.find(|node| source.nodes[node.index()].parent == Some(at))
                    };
                    // The metacarpal of a thumb points across the hand.
                    let is_across = finger == 0 && index == 0;
                    (!is_across).then_some(FingerBend {
                        before: source.nodes[at.index()].parent?,
                        at,
                        after: joint(index + 1).or_else(below)?,
                        range: ranges[index].to_radians(),
                    })
                });
                joints.collect()
            });
            fingers.collect::<Vec<Vec<FingerBend>>>()
        });
        let mut joints = Vec::new();
        for side in Side::ALL {
            joints.extend(joints_of(robot, kinematics, twin, side, &source[side as usize]));
        }
        Self { joints, source }
    }

    /// Whether the robot has no finger joints.
    pub(super) fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// The wanted positions of finger joints in a pose of the source.
    pub fn wanted(&self, pose: &Pose) -> Vec<f64> {
        let curls = Side::ALL.map(|side| {
            let fingers = self.source[side as usize].iter();
            fingers.map(|joints| curl(joints, pose)).collect::<Vec<f64>>()
        });
        let wanted = self.joints.iter().map(|joint| {
            let sum: f64 = joint
                .follows
                .iter()
                .map(|(side, finger)| curls[*side as usize][*finger])
                .sum();
            joint.open + (joint.bent - joint.open) * sum / joint.follows.len() as f64
        });
        wanted.collect()
    }

    /// Moves the finger positions of a frame towards the wanted positions, within their speeds.
    pub fn bend(&self, wanted: &[f64], before: Option<&[f64]>, fps: f64, positions: &mut [f64]) {
        for (joint, wanted) in self.joints.iter().zip(wanted) {
            let most = joint.fastest / fps;
            positions[joint.position] = match before {
                Some(before) => {
                    let was = before[joint.position];
                    wanted.clamp(was - most, was + most)
                }
                None => *wanted,
            };
        }
    }

    /// Bends the fingers of a whole motion.
    pub(super) fn apply(
        &self,
        kinematics: &Kinematics,
        source: &Scene,
        animation: &Animation,
        motion: &mut RobotMotion,
    ) {
        if self.is_empty() {
            return;
        }
        let (binding, mut pose) = (Binding::new(source, animation), Pose::rest(source));
        let (count, mut robot) = (motion.dof_names.len(), kinematics.rest());
        for frame in 0..motion.frames() {
            pose.sample(&binding, animation, frame as f64);
            let (before, here) = motion.dof_pos.split_at_mut(frame * count);
            let before = &*before;
            let before = frame.checked_sub(1).map(|frame| &before[frame * count..]);
            self.bend(&self.wanted(&pose), before, motion.fps, &mut here[..count]);
            if !kinematics.followers.is_empty() {
                motion.set(frame, kinematics, &mut robot);
                motion.dof_pos[frame * count..(frame + 1) * count].copy_from_slice(&robot.positions);
            }
        }
    }
}

/// The bend of a finger, from 0 to 1 in a fist.
pub fn curl(joints: &[FingerBend], pose: &Pose) -> f64 {
    let bent = joints.iter().map(|joint| {
        let [before, at, after] = [joint.before, joint.at, joint.after].map(|node| pose.position(node));
        let (first, second) = ((at - before).normalize_or_zero(), (after - at).normalize_or_zero());
        match first == Vec3::ZERO || second == Vec3::ZERO {
            true => 0.0,
            false => f64::from(first.angle_between(second)),
        }
    });
    let range: f64 = joints.iter().map(|joint| joint.range).sum();
    (bent.sum::<f64>() / range.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0)
}

/// The finger joints of one hand. They are below its link, or below the link of the forearm. They belong to no bone,
/// and bend only to one side.
fn joints_of(
    robot: &Robot,
    kinematics: &Kinematics,
    twin: &StandIn,
    side: Side,
    source: &[Vec<FingerBend>],
) -> Vec<Joint> {
    let hand = [Bone::LeftHand, Bone::LeftLowerArm].map(|bone| twin.bone(bone.on(side)));
    let Some(hand) = hand.into_iter().flatten().next() else {
        return Vec::new();
    };
    let hand = kinematics.body_of(hand.link).0;
    let carries = twin.bones.iter().flat_map(|bone| &bone.joints);
    let carries: Vec<usize> = carries.map(|joint| kinematics.body_of(*joint).0).collect();
    let known: Vec<(Side, usize)> = (0..source.len())
        .filter(|finger| !source[*finger].is_empty())
        .map(|finger| (side, finger))
        .collect();
    let moving = robot.moving_joints();
    let mut joints = Vec::new();
    for (position, &link) in moving.iter().enumerate() {
        let body = &kinematics.bodies[position + 1];
        let is_follower = kinematics
            .followers
            .iter()
            .any(|follower| follower.position == position);
        let is_below = body.chain.contains(&hand) && position + 1 != hand;
        if !is_below || is_follower || body.kind != JointKind::Hinge || carries.contains(&(position + 1)) {
            continue;
        }
        let (low, high) = (body.limits.lower, body.limits.upper);
        let bent = if high > ONE_SIDED * low.abs() {
            high
        } else if -low > ONE_SIDED * high.abs() {
            low
        } else {
            continue;
        };
        let names = [&robot.links[link].name, &robot.links[link].joint.name].map(|name| name.to_lowercase());
        let named = FINGERS.iter().position(|(_, words)| {
            let mut words = words.iter();
            words.any(|word| names.iter().any(|name| name.contains(*word)))
        });
        // A finger without a name, or that the source lacks, gets the mean bend of the other fingers.
        let own = known.iter().filter(|(_, finger)| Some(*finger) == named);
        let others = known.iter().filter(|(_, finger)| named != Some(0) && *finger != 0);
        let own: Vec<(Side, usize)> = own.copied().collect();
        let follows = if own.is_empty() { others.copied().collect() } else { own };
        if follows.is_empty() || !bent.is_finite() {
            continue;
        }
        joints.push(Joint {
            position,
            open: 0.0_f64.max(low).min(high),
            bent,
            follows,
            fastest: body
                .limits
                .velocity
                .filter(|most| *most > 0.0)
                .map_or(FASTEST, |most| most.min(FASTEST)),
        });
    }
    joints
}
