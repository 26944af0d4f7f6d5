//! Feet, head and shoulders of a T-pose, as the motion shows them.

use glam::{Quat, Vec3};

use super::builder::Builder;
use super::stance::{self, Foot};
use super::{TPoseReason, TPoseSource};
use crate::scene::{Confidence, HumanoidBone as Bone, NodeId, Scene};

/// The largest angle by which a foot of a rest pose that stands may be off its sole, in radians, and of any other.
const LEVELLED: f32 = 0.5;
const LEVELLED_WITHOUT_REST: f32 = 1.2;

/// The cosine of the largest angle between a head and the chest, on the average of a motion, that a T-pose may leave.
const TIPPED_HEAD: f32 = 0.7;

/// The largest angle between a shoulder and the chest, likewise, in radians: in clips of bodies that stand at rest the
/// mean is at most 20 degrees.
const TURNED_SHOULDER: f32 = 0.35;

/// The smallest angle of a foot that counts, in radians.
const SMALLEST_LEVELLED: f32 = 0.02;

/// The smallest angle by which both feet of a rest pose that stands may be rolled, in radians, and by how much they may
/// differ. In motions whose rest pose has flat feet they are rolled by up to 0.09, and one by 0.25.
const SMALLEST_ROLL: f32 = 0.1;
const UNEQUAL_ROLL: f32 = 0.1;

impl Builder {
    /// Levels feet, and where the rest pose does not stand, head and shoulders.
    pub(super) fn level(&mut self, scene: &Scene) {
        self.level_feet(scene);
        if self.source != TPoseSource::RestPose {
            self.level_head(scene);
            self.level_shoulders(scene);
        }
    }

    /// Up in the world.
    fn up(&self) -> Vec3 {
        self.axes * Vec3::Y
    }

    fn reference_to_t_pose(&self, bone: Bone) -> Quat {
        self.turns.get(&bone).map_or(Quat::IDENTITY, |turn| turn.rotation)
    }

    fn frame_to_joint(&self, bone: Bone, joint: NodeId) -> Quat {
        (self.axes.inverse() * self.reference_to_t_pose(bone) * self.rotations[joint.index()]).normalize()
    }

    /// Notes that the motion says how a bone is turned.
    fn because(&mut self, bone: Bone, reason: TPoseReason) {
        if let Some(turn) = self.turns.get_mut(&bone) {
            (turn.reason, turn.confidence) = (reason, Confidence::Likely);
        }
    }

    /// Puts the feet of the reference pose on their soles, as the motion shows them: both by the same angle. Where the
    /// rest pose does not stand, the reference pose says nothing about how the feet roll. Where it stands with its legs
    /// apart, as that of CMU's database, its feet may be rolled outwards with them.
    fn level_feet(&mut self, scene: &Scene) {
        let stands = self.source == TPoseSource::RestPose;
        let largest = if stands { LEVELLED } else { LEVELLED_WITHOUT_REST };
        let bones = [Bone::LeftFoot, Bone::RightFoot];
        let feet: Vec<Foot> = bones
            .into_iter()
            .filter_map(|bone| {
                let joint = self.joint(bone)?;
                Some(Foot {
                    joint,
                    world_to_frame: self.axes.inverse(),
                    joint_to_frame: self.frame_to_joint(bone, joint).inverse(),
                })
            })
            .collect();
        let [Some(left), Some(right)] = stance::stances(scene, &feet)[..] else {
            return;
        };
        let counts = |pitch: &f32| (SMALLEST_LEVELLED..=largest).contains(&pitch.abs());
        let is_pitched = [left.pitch, right.pitch].iter().all(counts);
        let pitch = Some(0.5 * (left.pitch + right.pitch)).filter(|_| is_pitched);
        let rolls = match (stands, left.roll, right.roll) {
            (false, left, right) => [left, right],
            (true, Some(left), Some(right)) if is_mirrored(left, right) => {
                let roll = 0.5 * (left - right);
                [Some(roll), Some(-roll)]
            }
            (true, ..) => [None, None],
        };
        for (foot, roll) in bones.into_iter().zip(rolls) {
            let Some(&ankle) = self.bones.get(&foot) else { continue };
            let pitch = Quat::from_rotation_x(-pitch.unwrap_or(0.0));
            let turn = pitch * Quat::from_rotation_z(roll.unwrap_or(0.0));
            self.turn(foot, ankle, turn);
            if pitch != Quat::IDENTITY || roll.is_some() {
                self.because(foot, TPoseReason::StandsInMotion);
            }
            if roll.is_some() {
                // The toes of a foot that is rolled point aside of where they point on the ground.
                let (up, forward) = (self.up(), self.axes * Vec3::Z);
                let facing = self.turn_to_face(up, forward);
                let rotation = self.foot(ankle, foot, facing, up, forward).normalize();
                let toes = if foot == Bone::LeftFoot {
                    Bone::LeftToes
                } else {
                    Bone::RightToes
                };
                for bone in [foot, toes] {
                    self.turns.entry(bone).and_modify(|turn| turn.rotation = rotation);
                }
            }
        }
    }

    /// Turns a head that the motion shows tipped over against the chest all the time: the bones of a rest pose that had
    /// to be computed say nothing about how its joint is turned.
    fn level_head(&mut self, scene: &Scene) {
        let (Some(head), Some((chest, chest_joint))) = (self.joint(Bone::Head), self.chest()) else {
            return;
        };
        // With a head as the root, a turn of it would be one of the whole body.
        if !self.hierarchy.is_below(head, chest_joint) {
            return;
        }
        let to_frame = |bone: Bone, joint: NodeId| self.frame_to_joint(bone, joint).inverse();
        let turned = stance::mean_turn(
            scene,
            (head, to_frame(Bone::Head, head)),
            (chest_joint, to_frame(chest, chest_joint)),
        );
        let is_tipped = |turn: &Quat| (*turn * Vec3::Y).y < TIPPED_HEAD;
        let Some(turned) = turned.filter(is_tipped) else { return };
        self.turn(Bone::Head, head, turned);
        self.because(Bone::Head, TPoseReason::AverageOfMotion);
    }

    /// Turns shoulders that the motion shows turned against the chest all the time, likewise. The arms keep their
    /// T-pose.
    fn level_shoulders(&mut self, scene: &Scene) {
        let Some((chest, chest_joint)) = self.chest() else {
            return;
        };
        for bone in [Bone::LeftShoulder, Bone::RightShoulder] {
            let Some(shoulder) = self
                .joint(bone)
                .filter(|joint| self.hierarchy.is_below(*joint, chest_joint))
            else {
                continue;
            };
            let turned = stance::mean_turn(
                scene,
                (shoulder, self.frame_to_joint(bone, shoulder).inverse()),
                (chest_joint, self.frame_to_joint(chest, chest_joint).inverse()),
            );
            let is_turned = |turn: &Quat| turn.angle_between(Quat::IDENTITY) > TURNED_SHOULDER;
            if let (Some(turned), Some(turn)) = (turned.filter(is_turned), self.turns.get_mut(&bone)) {
                turn.rotation = (self.axes * turned * self.axes.inverse() * turn.rotation).normalize();
                self.because(bone, TPoseReason::AverageOfMotion);
            }
        }
    }

    /// The highest bone of the spine, and its joint.
    fn chest(&self) -> Option<(Bone, NodeId)> {
        [Bone::UpperChest, Bone::Chest, Bone::Spine]
            .into_iter()
            .find_map(|bone| Some((bone, self.joint(bone)?)))
    }

    /// Turns the joint of a bone about itself in the reference pose, with all nodes below it; `turn` is in the bone's
    /// frame.
    fn turn(&mut self, bone: Bone, joint: NodeId, turn: Quat) {
        let axes = self.reference_to_t_pose(bone).inverse() * self.axes;
        let turn = axes * turn * axes.inverse();
        let here = self.positions[joint.index()];
        for index in joint.index()..self.hierarchy.parents.len() {
            if index == joint.index() || self.hierarchy.is_below(NodeId::new(index), joint) {
                self.positions[index] = here + turn * (self.positions[index] - here);
                self.rotations[index] = (turn * self.rotations[index]).normalize();
            }
        }
    }
}

/// Whether two feet that stand are rolled by the same angle, inwards or outwards, more than feet are that stand on
/// their soles.
fn is_mirrored(left: f32, right: f32) -> bool {
    (left + right).abs() <= UNEQUAL_ROLL && (SMALLEST_ROLL..=LEVELLED).contains(&(0.5 * (left - right)).abs())
}
