//! Infers the roll of bones from the motion.
//!
//! The positions of a bone's ends show the direction of the bone, but not its roll. A standing rest pose shows the
//! roll. Without a standing rest pose, the motion shows the roll:
//!
//! - An elbow and a knee are hinges. Their bending axis is at right angles to both bones, and constant in the frames of
//!   both joints. The axis is the mean of the cross products of upper and lower bone, over the frames in which the limb
//!   is bent. In a T-pose that faces +Z, a shin bends back and a forearm bends forward. So the axis is +X for a knee,
//!   -Y for the left elbow and +Y for the right elbow. If a joint's coordinate frame lies along its bone, and the axis
//!   is near a coordinate axis, that coordinate axis is used.
//! - A limb that never bends gets the mirrored hinge of the other side, if the coordinate frames of both sides are
//!   mirror images.
//! - Pelvis, spine, neck and head face in the average heading of hips and shoulders, over the frames in which the body
//!   stands. A person does not look aside all the time, so this average is forward. If the coordinate frame of such a
//!   joint has an axis along the spine, it has the axes of the body.
//! - An upper arm or a thigh that never bends gets the smallest average roll against the trunk. A hand gets the
//!   smallest average roll against its forearm.
//! - Feet, toes, hands and fingers get their average rotation relative to their parents. Knuckles get their average
//!   rotation relative to the hand.

mod average;
mod hinge;

use std::collections::{BTreeMap, BTreeSet};

use glam::{Mat4, Quat, Vec3};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

use self::average::{AverageRotation, Knuckle, Lines, Mean, TrunkAngle, nearest_exchange};
use self::hinge::{Limb, are_laid_along, is_laid_along, nearest_axis};
use super::hierarchy::Hierarchy;
use super::knuckles::Knuckles;
use super::poses::sample;

/// The smallest number of frames that show an axis or an average.
const FEWEST: usize = 5;

/// A loose hinge is a knee or an elbow whose joint also twists the lower bone. If its axis is within this angle of the
/// expected axis, in radians, the lower bone gets the roll of the upper bone.
const FARTHEST: f32 = 1.05;

/// The error of a hinge in radians above which the hinge is uncertain: 3 degrees.
const VAGUE: f32 = 0.05;

/// The cosine of 25 degrees. If a coordinate axis of the lower joint is within this angle of the average hinge axis, it
/// is clear which coordinate axis is the hinge.
const CLEAR: f32 = 0.906;

/// The largest average angle between the coordinate frame of a joint and the axes of the body, in radians: 34 degrees.
/// Up to this angle, a joint with an axis along the trunk has exactly the axes of the body.
const AGREES: f32 = 0.6;

/// The value that replaces [`AGREES`] for a head, because heads look around, in radians: 46 degrees.
const HEAD_AGREES: f32 = 0.8;

/// The cosine of 8 degrees. An axis of the pelvis within this angle of the line through the hip joints lies along this
/// line.
const PELVIS_ALONG: f32 = 0.99;

/// The evidence for a bone's roll in the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Evidence {
    /// The hinge of the bone.
    Hinge,
    /// The hinge of the bone, although the hinge of the other side is not its mirror image.
    UnlikeOtherSide,
    /// The mirrored hinge of the other side.
    OtherSide,
    /// The bone's average rotation relative to its parent bone.
    Average,
}

/// What the motion of a body shows about the rolls of its bones.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    /// For each bone with a hinge: the joint that turns with the bone at the hinge, and the hinge axis in the
    /// coordinate frame of this joint.
    hinges: BTreeMap<Bone, (NodeId, Vec3)>,
    /// Bones whose hinge is not the mirror image of the hinge of the other side.
    contradicted: BTreeSet<Bone>,
    /// Bones with an uncertain hinge: other frames of the motion could give another axis.
    vague: BTreeSet<Bone>,
    /// For a bone that never bends: the joint, and the axes that mirror the hinge of the other side, in the coordinate
    /// frame of this joint.
    mirrored: BTreeMap<Bone, (NodeId, Vec<Vec3>)>,
    /// For a shin or a forearm whose joint also twists it: the joint, and the hinge of the bone above, in the
    /// coordinate frame of this joint. The flag states whether the hinge is clearly one of the joint's coordinate axes.
    loose_hinges: BTreeMap<Bone, (NodeId, Vec3, bool)>,
    /// For each joint of the trunk and each first joint of a limb: the rotation from its coordinate frame to the axes
    /// of the body (left, up, forward).
    averages: BTreeMap<NodeId, Quat>,
    /// Joints of the trunk whose coordinate frames have the axes of the body. The average confirms them, but is not
    /// used as their rotation.
    exact: BTreeSet<NodeId>,
    /// For each hand: the joint of its forearm, and the average rotation from the hand to this joint.
    hands: BTreeMap<Bone, (NodeId, Quat)>,
    /// Joints of the pelvis, the spine, the neck and the head, from the bottom up.
    pub(super) trunk: Vec<NodeId>,
    /// Average transforms of feet, toes, hands and fingers relative to their parents.
    pub(super) usual: Vec<(NodeId, Mat4)>,
    /// For each knuckle, its hand, and its average offset in the axes of the hand.
    knuckles: BTreeMap<NodeId, (NodeId, Vec3)>,
}

/// The limbs with a hinge: upper bone, lower bone, end.
const LIMBS: [[Bone; 3]; 4] = [
    [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot],
    [Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot],
    [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
    [Bone::RightUpperArm, Bone::RightLowerArm, Bone::RightHand],
];

/// The axis about which a bone bends at its hinge, in the coordinate frame of the T-pose. `None` for a bone without a
/// hinge.
pub fn bend_axis(bone: Bone) -> Option<Vec3> {
    let is_left = bone.side() != Some(Side::Right);
    match bone.on(Side::Left) {
        Bone::LeftUpperLeg | Bone::LeftLowerLeg => Some(Vec3::X),
        Bone::LeftUpperArm | Bone::LeftLowerArm if is_left => Some(Vec3::NEG_Y),
        Bone::LeftUpperArm | Bone::LeftLowerArm => Some(Vec3::Y),
        _ => None,
    }
}

impl Shown {
    /// Examines some frames of all animations. `up` is the up axis of the world.
    pub(super) fn new(
        scene: &Scene,
        hierarchy: &Hierarchy,
        bones: &BTreeMap<Bone, NodeId>,
        of_hands: &Knuckles,
        up: Vec3,
    ) -> Self {
        let is_laid = are_laid_along(scene, hierarchy, bones);
        let limbs = Limb::all(scene, hierarchy, bones, is_laid).into_iter();
        let mut limbs: Vec<(Limb, Mean)> = limbs.map(|limb| (limb, Mean::default())).collect();
        let trunk = trunk(hierarchy, bones);
        let mut averages = against_trunk(&trunk, bones);
        let mut hands = hands(bones);
        let mut usual = usual(scene, bones);
        let mut knuckles: Vec<Knuckle> = of_hands
            .with_hands(bones)
            .map(|(node, hand)| Knuckle::new(node, hand))
            .collect();
        sample(scene, |pose| {
            let rotation = |node: NodeId| rotation_of(&pose.node_to_world[node.index()]);
            for (limb, lower) in &mut limbs {
                limb.see(pose);
                let [above, below] = limb.turned;
                lower.add(rotation(above).inverse() * rotation(below));
            }
            for (_, hand, forearm, mean) in &mut hands {
                mean.add(rotation(*forearm).inverse() * rotation(*hand));
            }
            if let Some(lines) = Lines::new(pose, bones, up) {
                averages.iter_mut().for_each(|joint| joint.see(pose, &lines));
            }
            usual.iter_mut().for_each(|joint| joint.see(pose));
            knuckles.iter_mut().for_each(|knuckle| knuckle.see(pose));
        });
        let laid_along = match is_laid {
            true => laid_along(scene, hierarchy, &trunk, bones),
            false => BTreeSet::new(),
        };
        let head = bones.get(&Bone::Head);
        let mut exact = BTreeSet::new();
        let average = |joint: &TrunkAngle| {
            let average = joint.value()?;
            let limit = if Some(&joint.node) == head { HEAD_AGREES } else { AGREES };
            let of_body = nearest_exchange(average, limit).filter(|_| laid_along.contains(&joint.node));
            exact.extend(of_body.map(|_| joint.node));
            Some((joint.node, of_body.unwrap_or(average)))
        };
        let averages: BTreeMap<NodeId, Quat> = averages.iter().filter_map(average).collect();
        let mut shown = Self {
            averages,
            exact,
            hands: hands
                .into_iter()
                .filter_map(|(bone, _, forearm, mean)| Some((bone, (forearm, mean.value()?))))
                .collect(),
            trunk,
            usual: usual
                .iter()
                .filter_map(|joint| Some((joint.node, joint.value()?)))
                .collect(),
            knuckles: knuckles
                .iter()
                .filter_map(|knuckle| Some((knuckle.node, (knuckle.hand, knuckle.value()?))))
                .collect(),
            ..Self::default()
        };
        for (limb, lower) in &limbs {
            shown.take(limb, lower);
        }
        for (limb, _) in &limbs {
            let other = limbs.iter().find(|(other, _)| {
                other.bones[0] != limb.bones[0] && other.bones[0].on(Side::Left) == limb.bones[0].on(Side::Left)
            });
            if let Some((other, _)) = other {
                shown.compare(limb, other);
            }
        }
        shown
    }

    /// Adds what a limb shows. `lower` is the mean rotation of its lower joint relative to its upper joint.
    fn take(&mut self, limb: &Limb, lower: &Mean) {
        let [upper_hinge, lower_hinge] = limb.hinges();
        let at = |index: usize, axis: Vec3| (limb.bones[index], (limb.turned[index], axis));
        for (bone, hinge) in std::iter::zip(limb.bones, [upper_hinge, lower_hinge]) {
            self.vague
                .extend(hinge.filter(|hinge| hinge.error > VAGUE).map(|_| bone));
        }
        self.hinges.extend(upper_hinge.map(|hinge| at(0, hinge.axis)));
        self.hinges.extend(lower_hinge.map(|hinge| at(1, hinge.axis)));
        if let (Some(upper), None, Some(lower)) = (upper_hinge, lower_hinge, lower.value()) {
            let axis = lower.inverse() * upper.axis;
            let of_joint = |cosine: f32| limb.axis_of_joint(1, axis, cosine);
            let loose = (limb.turned[1], of_joint(0.0).unwrap_or(axis), of_joint(CLEAR).is_some());
            self.loose_hinges.insert(limb.bones[1], loose);
        }
    }

    /// Compares a limb with the limb of the other side.
    fn compare(&mut self, limb: &Limb, other: &Limb) {
        for index in 0..2 {
            let bone = limb.bones[index];
            let Some(&(_, of_other)) = self.hinges.get(&other.bones[index]) else {
                continue;
            };
            match self.hinges.get(&bone) {
                Some((_, axis)) if limb.contradicts(other, index, *axis, of_other) => {
                    self.contradicted.insert(bone);
                }
                Some(_) => {}
                None => {
                    let axes = limb.mirrored(other, index, of_other);
                    self.mirrored.insert(bone, (limb.turned[index], axes));
                    self.vague
                        .extend(self.vague.contains(&other.bones[index]).then_some(bone));
                }
            }
        }
    }

    /// The rotation about `along` that gives a bone the roll that the motion shows. `along` is the direction of the
    /// bone in the world. `axes` rotates the coordinate frame of the T-pose to the world. `rotation` is the current
    /// world rotation of a joint of the bone. `above` is the world rotation of a forearm's joint in the T-pose.
    pub(super) fn roll(
        &self,
        bone: Bone,
        joint: NodeId,
        axes: Quat,
        along: Vec3,
        rotation: impl Fn(NodeId) -> Quat,
        above: impl Fn(NodeId) -> Quat,
    ) -> Option<(Quat, Evidence)> {
        let along = along.try_normalize()?;
        let about = |angle: f32, evidence: Evidence| (Quat::from_axis_angle(along, angle), evidence);
        let to_hinge = |node: NodeId, axis: Vec3| angle_about(along, rotation(node) * axis, axes * bend_axis(bone)?);
        if let Some((node, axis)) = self.hinges.get(&bone) {
            let evidence = match self.contradicted.contains(&bone) {
                true => Evidence::UnlikeOtherSide,
                false => Evidence::Hinge,
            };
            return Some(about(to_hinge(*node, *axis)?, evidence));
        }
        if let Some((node, axis, is_clear)) = self.loose_hinges.get(&bone) {
            // A forearm rotates relative to its elbow by up to a quarter turn. A larger rotation means that the joints'
            // axes differ.
            let angle = to_hinge(*node, *axis)?;
            return (*is_clear || angle.abs() > FARTHEST).then(|| about(angle, Evidence::Average));
        }
        let average = match (bone.on(Side::Left), self.hands.get(&bone)) {
            (_, Some((forearm, average))) => Some(above(*forearm) * *average),
            (Bone::LeftUpperLeg | Bone::LeftUpperArm, None) => self.averages.get(&joint).map(|mean| axes * *mean),
            _ => None,
        };
        // The rotation from the T-pose to the average, reduced to a twist about the bone.
        let average = average.map(|average| {
            let moved = average * rotation(joint).inverse();
            let sine = Vec3::new(moved.x, moved.y, moved.z).dot(along);
            2.0 * sine.atan2(moved.w)
        });
        let average = average.filter(|angle| angle.is_finite());
        if let Some((node, candidates)) = self.mirrored.get(&bone) {
            let angles = candidates.iter().filter_map(|axis| to_hinge(*node, *axis));
            let off = |angle: &f32| (1.0 - (angle - average.unwrap_or(0.0)).cos()).abs();
            if let Some(angle) = angles.min_by(|a, b| off(a).total_cmp(&off(b))) {
                return Some(about(angle, Evidence::OtherSide));
            }
        }
        average.map(|angle| about(angle, Evidence::Average))
    }

    /// The world rotation of a hand that has its average rotation relative to the forearm. `forearm_rotation` gives the
    /// world rotation of the forearm's joint.
    pub(super) fn hand(&self, bone: Bone, forearm_rotation: impl Fn(NodeId) -> Quat) -> Option<Quat> {
        let (forearm, average) = self.hands.get(&bone)?;
        let hand = forearm_rotation(*forearm) * *average;
        hand.is_finite().then_some(hand)
    }

    /// The offset from a hand's joint to a knuckle, if the hand has the world rotation `rotation`.
    pub(super) fn to_knuckle(&self, node: NodeId, rotation: impl Fn(NodeId) -> Quat) -> Option<Vec3> {
        let (hand, offset) = self.knuckles.get(&node)?;
        Some(rotation(*hand) * *offset)
    }

    /// Whether the hinge of a bone is uncertain: other frames of the motion could give another axis.
    pub(super) fn is_vague(&self, bone: Bone) -> bool {
        self.vague.contains(&bone)
    }

    /// Whether the coordinate frame of a joint of the trunk has the axes of the body.
    pub(super) fn is_exact(&self, node: NodeId) -> bool {
        self.exact.contains(&node)
    }

    /// The world rotation of a joint of the trunk in the T-pose.
    pub(super) fn of_trunk(&self, node: NodeId, axes: Quat) -> Option<Quat> {
        let rotation = axes * *self.averages.get(&node).filter(|_| self.trunk.contains(&node))?;
        rotation.is_finite().then_some(rotation)
    }
}

/// The angle about a direction from one vector to another, in radians.
pub fn angle_about(along: Vec3, from: Vec3, to: Vec3) -> Option<f32> {
    let from = from.reject_from_normalized(along).try_normalize()?;
    let to = to.reject_from_normalized(along).try_normalize()?;
    let angle = along.dot(from.cross(to)).atan2(from.dot(to));
    angle.is_finite().then_some(angle)
}

/// The joints of the trunk from the hips to the head, from the top of the hierarchy down.
fn trunk(hierarchy: &Hierarchy, bones: &BTreeMap<Bone, NodeId>) -> Vec<NodeId> {
    let joint = |bone: Bone| bones.get(&bone).copied();
    let (Some(hips), Some(top)) = (joint(Bone::Hips), joint(Bone::Head).or(joint(Bone::Neck))) else {
        return Vec::new();
    };
    let Some(between) = hierarchy.path(hips, top) else {
        return Vec::new();
    };
    [hips].into_iter().chain(between).chain([top]).collect()
}

/// Both hands: the bone, its joint, the joint of the forearm, and the mean rotation of the hand relative to the
/// forearm.
fn hands(bones: &BTreeMap<Bone, NodeId>) -> Vec<(Bone, NodeId, NodeId, Mean)> {
    let sides = [Side::Left, Side::Right].into_iter();
    let hand = |side: Side| {
        let (hand, forearm) = (Bone::LeftHand.on(side), Bone::LeftLowerArm.on(side));
        Some((hand, *bones.get(&hand)?, *bones.get(&forearm)?, Mean::default()))
    };
    sides.filter_map(hand).collect()
}

/// The joints whose rotation relative to the trunk is averaged, each with its fraction of the distance from hips to
/// shoulders.
fn against_trunk(trunk: &[NodeId], bones: &BTreeMap<Bone, NodeId>) -> Vec<TrunkAngle> {
    let joint = |bone: Bone| bones.get(&bone).copied();
    let neck = joint(Bone::Neck).or(joint(Bone::Head));
    let spine = trunk.iter().position(|node| Some(*node) == neck).unwrap_or(trunk.len());
    let fraction = |index: usize| (index as f32 / spine.saturating_sub(1).max(1) as f32).min(1.0);
    let mut all: Vec<_> = trunk
        .iter()
        .enumerate()
        .map(|(index, node)| TrunkAngle::new(*node, fraction(index)))
        .collect();
    let limbs = [
        (Bone::LeftUpperLeg, 0.0),
        (Bone::RightUpperLeg, 0.0),
        (Bone::LeftUpperArm, 1.0),
        (Bone::RightUpperArm, 1.0),
    ];
    all.extend(
        limbs
            .into_iter()
            .filter_map(|(bone, fraction)| Some(TrunkAngle::new(joint(bone)?, fraction))),
    );
    all
}

/// The joints of the trunk whose coordinate frames have an axis along the trunk. For the pelvis, this is the line of
/// the hip joints. For the head, it is the line to its only child, and for other joints the spine.
fn laid_along(
    scene: &Scene,
    hierarchy: &Hierarchy,
    trunk: &[NodeId],
    bones: &BTreeMap<Bone, NodeId>,
) -> BTreeSet<NodeId> {
    let place_in = |joint: NodeId, node: NodeId| {
        let node = &scene.nodes[node.index()];
        (node.parent == Some(joint)).then(|| node.transform.w_axis.truncate())
    };
    let is_pelvis_laid = |pelvis: NodeId| {
        let hip = |bone: Bone| place_in(pelvis, *bones.get(&bone)?);
        let line = hip(Bone::LeftUpperLeg).zip(hip(Bone::RightUpperLeg));
        line.is_some_and(|(left, right)| nearest_axis(left - right, PELVIS_ALONG).is_some())
    };
    let is_laid = |index: usize| {
        let joint = trunk[index];
        if index == 0 {
            return is_pelvis_laid(joint);
        }
        let next = trunk.get(index + 1).copied().or_else(|| hierarchy.only_child(joint));
        next.and_then(|next| place_in(joint, next)).is_some_and(is_laid_along)
    };
    (0..trunk.len())
        .filter(|index| is_laid(*index))
        .map(|index| trunk[index])
        .collect()
}

/// The joints of feet, toes, hands and fingers, whose rotations relative to their parents are averaged.
fn usual(scene: &Scene, bones: &BTreeMap<Bone, NodeId>) -> Vec<AverageRotation> {
    let is_end = |bone: Bone| {
        let of_limb = matches!(bone.on(Side::Left), Bone::LeftFoot | Bone::LeftToes | Bone::LeftHand);
        of_limb || bone.is_finger()
    };
    let ends = bones.iter().filter(|(bone, _)| is_end(**bone));
    ends.map(|(_, node)| AverageRotation::new(scene, *node)).collect()
}
