//! Levels feet, head and shoulders of a T-pose by the motion.

use glam::{Quat, Vec3};
use mocap_scene::scene::{Confidence, HumanoidBone as Bone, NodeId, Scene, Side};

use super::builder::Builder;
use super::stance::{self, Foot};
use super::{TPoseReason, TPoseSource};

/// The largest angle in radians by which a foot of a standing rest pose may be off its sole: 40 degrees, for high
/// heels.
const LEVELLED: f32 = 0.7;

/// The largest angle in radians by which a foot of any other rest pose may be off its sole: 69 degrees, for a foot that
/// points along the shin.
const LEVELLED_WITHOUT_REST: f32 = 1.2;

/// The smallest cosine of the average angle between head and chest in a motion at which the T-pose keeps the head.
const TIPPED_HEAD: f32 = 0.7;

/// The largest average angle between a shoulder and the chest at which the T-pose keeps the shoulder, in radians. In
/// clips of bodies that stand at rest, the mean angle is at most 20 degrees.
const TURNED_SHOULDER: f32 = 0.35;

/// The smallest angle, in radians, by which a foot of a standing rest pose is corrected. In fixtures whose rest pose
/// stands on its soles, the feet of the motion differ from the rest pose by up to 13 degrees.
const SMALLEST_LEVELLED: f32 = 0.26;

/// The smallest angle, in radians, by which a foot of any other rest pose is corrected. It is larger than rounding
/// errors.
const SMALLEST_WITHOUT_REST: f32 = 0.02;

/// The smallest sideways angle of each leg in a rest pose that stands with its legs apart, in radians. In CMU's
/// database, this angle is 20 degrees, and the feet are rolled with the legs.
const SMALLEST_APART: f32 = 0.1;

/// Feet are rolled with the legs if the motion shows this fraction of the legs' angle as roll. Clips of CMU's database
/// show 0.7 to 1.6. Feet of a rest pose with flat soles are unchanged.
const ROLLED_WITH_LEGS: std::ops::RangeInclusive<f32> = 0.3..=2.0;

impl Builder {
    /// Levels the feet. If the figure does not stand in its rest pose, also levels head and shoulders.
    pub(super) fn level(&mut self, scene: &Scene) {
        self.level_feet(scene);
        if self.source != TPoseSource::RestPose {
            self.level_head(scene);
            self.level_shoulders(scene);
        }
    }

    /// The up direction in the world.
    fn up(&self) -> Vec3 {
        self.axes * Vec3::Y
    }

    fn reference_to_t_pose(&self, bone: Bone) -> Quat {
        self.to_t_pose.get(&bone).map_or(Quat::IDENTITY, |found| found.rotation)
    }

    fn frame_to_joint(&self, bone: Bone, joint: NodeId) -> Quat {
        (self.axes.inverse() * self.reference_to_t_pose(bone) * self.rotations[joint.index()]).normalize()
    }

    /// Records that the motion determines a bone's rotation, with low confidence for averages.
    fn because(&mut self, bone: Bone, reason: TPoseReason) {
        let confidence = match reason {
            TPoseReason::AverageOfMotion => Confidence::Unsure,
            _ => Confidence::Likely,
        };
        if let Some(to_t_pose) = self.to_t_pose.get_mut(&bone) {
            (to_t_pose.reason, to_t_pose.confidence) = (reason, confidence);
        }
    }

    /// A foot of the reference pose, for the search of its stance in the motion.
    fn sees(&self, bone: Bone) -> Option<Foot> {
        let joint = self.joint(bone)?;
        let toes = self.joint(Bone::LeftToes.on(bone.side()?));
        let toes = toes.filter(|toes| self.hierarchy.is_below(*toes, joint));
        let ball = toes.or_else(|| self.hierarchy.only_child(joint));
        Some(Foot {
            joint,
            ball,
            tip: ball.and_then(|ball| self.hierarchy.only_child(ball)),
            world_to_frame: self.axes.inverse(),
            joint_to_frame: self.frame_to_joint(bone, joint).inverse(),
        })
    }

    /// The sideways angle of each leg in the reference pose, in radians, if both are similar.
    fn legs_apart(&self) -> Option<f32> {
        let aside = |side: Side| {
            let at = |bone: Bone| Some(self.position(self.joint(bone.on(side))?));
            let leg = self.axes.inverse() * (at(Bone::LeftFoot)? - at(Bone::LeftUpperLeg)?);
            Some(leg.x.atan2(-leg.y))
        };
        let (left, right) = (aside(Side::Left)?, aside(Side::Right)?);
        let is_mirrored = (left + right).abs() < SMALLEST_APART;
        let apart = 0.5 * (left - right);
        (is_mirrored && (SMALLEST_APART..=LEVELLED).contains(&apart)).then_some(apart)
    }

    /// Puts the feet of the reference pose on their soles, as the motion shows them. Both feet are rotated by the same
    /// angle. If the rest pose does not stand, the reference pose does not show the roll of the feet. If the rest pose
    /// stands with its legs apart, as in CMU's database, its feet may be rolled outwards with the legs.
    fn level_feet(&mut self, scene: &Scene) {
        let stands = self.source == TPoseSource::RestPose;
        let levelled = match stands {
            true => SMALLEST_LEVELLED..=LEVELLED,
            false => SMALLEST_WITHOUT_REST..=LEVELLED_WITHOUT_REST,
        };
        let bones = [Bone::LeftFoot, Bone::RightFoot];
        let feet: Vec<Foot> = bones.into_iter().filter_map(|bone| self.sees(bone)).collect();
        let Some(stance) = stance::stance(scene, &feet).filter(|_| feet.len() == bones.len()) else {
            return;
        };
        let pitch = stance.pitch.filter(|pitch| levelled.contains(&pitch.abs()));
        let [left, right] = [stance.rolls[0], stance.rolls[1]];
        let rolls = match self.legs_apart().filter(|_| stands) {
            Some(apart) if rolled_with_legs(apart, left.0, right.0) => [Some(-apart), Some(apart)],
            _ if stands => [None, None],
            _ => [left, right].map(|(roll, agrees)| agrees.then_some(roll)),
        };
        for (foot, roll) in bones.into_iter().zip(rolls) {
            let Some(&ankle) = self.bones.get(&foot) else { continue };
            let pitch = Quat::from_rotation_x(-pitch.unwrap_or(0.0));
            let level = pitch * Quat::from_rotation_z(roll.unwrap_or(0.0));
            self.rotate(foot, ankle, level);
            if pitch != Quat::IDENTITY || roll.is_some() {
                self.because(foot, TPoseReason::StandsInMotion);
            }
            if roll.is_some() {
                // The toes of a rolled foot point to the side of their direction on the ground.
                let (up, forward) = (self.up(), self.axes * Vec3::Z);
                let facing = self.turn_to_face(up, forward);
                let rotation = self.foot(ankle, foot, facing, up, forward).normalize();
                let toes = if foot == Bone::LeftFoot {
                    Bone::LeftToes
                } else {
                    Bone::RightToes
                };
                for bone in [foot, toes] {
                    self.to_t_pose.entry(bone).and_modify(|found| found.rotation = rotation);
                }
            }
        }
    }

    /// Rotates a head that the motion shows tipped against the chest all the time. If the rest pose was computed, its
    /// bones do not show the rotation of the head's joint.
    fn level_head(&mut self, scene: &Scene) {
        let (Some(head), Some((chest, chest_joint))) = (self.joint(Bone::Head), self.chest()) else {
            return;
        };
        // If the head is the root, its rotation would rotate the whole body.
        if !self.hierarchy.is_below(head, chest_joint) {
            return;
        }
        let to_frame = |bone: Bone, joint: NodeId| self.frame_to_joint(bone, joint).inverse();
        let turned = stance::mean_turn(
            scene,
            (head, to_frame(Bone::Head, head)),
            (chest_joint, to_frame(chest, chest_joint)),
        );
        let is_tipped = |rotation: &Quat| (*rotation * Vec3::Y).y < TIPPED_HEAD;
        let Some(turned) = turned.filter(is_tipped) else { return };
        self.rotate(Bone::Head, head, turned);
        self.because(Bone::Head, TPoseReason::AverageOfMotion);
    }

    /// Rotates shoulders that the motion shows rotated against the chest all the time. The arms keep their T-pose.
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
            let is_turned = |rotation: &Quat| rotation.angle_between(Quat::IDENTITY) > TURNED_SHOULDER;
            if let (Some(turned), Some(to_t_pose)) = (turned.filter(is_turned), self.to_t_pose.get_mut(&bone)) {
                to_t_pose.rotation = (self.axes * turned * self.axes.inverse() * to_t_pose.rotation).normalize();
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

    /// Rotates the joint of a bone in the reference pose, with all its descendants. `rotation` is in the bone's frame.
    fn rotate(&mut self, bone: Bone, joint: NodeId, rotation: Quat) {
        let axes = self.reference_to_t_pose(bone).inverse() * self.axes;
        let rotation = axes * rotation * axes.inverse();
        let here = self.positions[joint.index()];
        for index in joint.index()..self.hierarchy.parents.len() {
            if index == joint.index() || self.hierarchy.is_below(NodeId::new(index), joint) {
                self.positions[index] = here + rotation * (self.positions[index] - here);
                self.rotations[index] = (rotation * self.rotations[index]).normalize();
            }
        }
    }
}

/// Whether feet in stance are rolled against the reference pose by the angle of its legs.
fn rolled_with_legs(apart: f32, left: f32, right: f32) -> bool {
    ROLLED_WITH_LEGS.contains(&(0.5 * (right - left) / apart))
}
