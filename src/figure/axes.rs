//! How bones are turned about themselves, as the motion shows it.
//!
//! Where a bone points is seen in the positions of its ends; how it is turned about that line is not. A rest pose that
//! stands says it. Where none does, the motion does:
//!
//! - An elbow and a knee are hinges. The axis about which they bend is at right angles to both bones, and is constant
//!   in the frames of both joints: the mean of the cross products of upper and lower bone, over the frames in which
//!   they are bent. In a T-pose that faces +Z a shin would go back and a forearm forward, so the axis is +X for a
//!   knee, -Y for the left and +Y for the right elbow.
//! - Pelvis, spine, neck and head are turned as hips and shoulders on the average: nobody looks aside all the time.
//! - An upper arm or a thigh that never bends is turned about itself by as little as can be on the average, against
//!   the trunk; so is a hand, against its forearm.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;

use glam::{Mat3, Quat, Vec3};

use super::hierarchy::Hierarchy;
use crate::math::directions::rotation_of;
use crate::pose::{Binding, Pose};
use crate::scene::{Animation, HumanoidBone as Bone, NodeId, Scene, Side};

/// Frames of all animations that are examined at most.
const FRAMES: usize = 400;

/// The sine of the smallest bend that shows the axis of a hinge: 12 degrees.
const BENT: f32 = 0.2;

/// The fewest frames that show an axis or an average.
const FEWEST: usize = 5;

/// How far the axis of a hinge may be from its mean, in radians, that is fixed in the frame of the lower joint. That
/// of an elbow whose joint turns the forearm too is not.
const FIXED: f32 = 0.21;

/// The largest angle between the axis of a hinge that is not fixed and where it belongs, in radians, with which a
/// lower bone is turned as the upper one.
const FARTHEST: f32 = 1.05;

/// The angle at which an axis counts half in the mean, in radians.
const HALF_WEIGHT: f32 = 0.15;

/// The largest angle between a joint of the trunk, or of the head, and its average in the motion, in radians, with
/// which the rest pose is believed.
const AGREES: f32 = 0.44;
const HEAD_AGREES: f32 = 0.7;

/// The axis of a hinge in the frame of a joint.
#[derive(Clone, Copy, Debug)]
struct Hinge {
    axis: Vec3,
    /// How far the axis is from its mean, in the mean, in radians.
    spread: f32,
}

/// How the motion shows a bone's rotation about itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Evidence {
    /// By its hinge.
    Hinge,
    /// By its average against the trunk.
    Average,
}

/// What the motion of a body shows.
#[derive(Clone, Debug, Default)]
pub(super) struct Shown {
    /// The joint that turns with the bone at its hinge, and the axis in its frame.
    hinges: BTreeMap<Bone, (NodeId, Hinge)>,
    /// Likewise of lower bones whose joint turns them about themselves too.
    loose_hinges: BTreeMap<Bone, (NodeId, Hinge)>,
    /// From joints to left, up and forward of the trunk, on the average.
    averages: BTreeMap<NodeId, Quat>,
    /// From hands to the joints of their forearms, on the average.
    hands: BTreeMap<Bone, (NodeId, Quat)>,
    head: Option<NodeId>,
    /// Joints of the pelvis, the spine, the neck and the head, from below.
    pub(super) trunk: Vec<NodeId>,
}

/// The limbs with a hinge: upper bone, lower bone, end.
const LIMBS: [[Bone; 3]; 4] = [
    [Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot],
    [Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot],
    [Bone::LeftUpperArm, Bone::LeftLowerArm, Bone::LeftHand],
    [Bone::RightUpperArm, Bone::RightLowerArm, Bone::RightHand],
];

/// The axis about which a bone bends at its hinge, in the frame of the T-pose; `None` for bones without a hinge.
pub(crate) fn bend_axis(bone: Bone) -> Option<Vec3> {
    let is_left = bone.side() != Some(Side::Right);
    match bone.on(Side::Left) {
        Bone::LeftUpperLeg | Bone::LeftLowerLeg => Some(Vec3::X),
        Bone::LeftUpperArm | Bone::LeftLowerArm if is_left => Some(Vec3::NEG_Y),
        Bone::LeftUpperArm | Bone::LeftLowerArm => Some(Vec3::Y),
        _ => None,
    }
}

impl Shown {
    /// Examines some frames of all animations.
    pub(super) fn new(scene: &Scene, hierarchy: &Hierarchy, bones: &BTreeMap<Bone, NodeId>) -> Self {
        let limbs = LIMBS.into_iter().filter_map(|limb| Limb::new(limb, hierarchy, bones));
        let mut limbs: Vec<Limb> = limbs.collect();
        let trunk = trunk(hierarchy, bones);
        let mut averages: Vec<(NodeId, f32, Mean)> = against_trunk(&trunk, bones);
        let mut hands = hands(bones);
        sample(scene, |pose| {
            for limb in &mut limbs {
                limb.see(pose);
            }
            let rotation = |node: NodeId| rotation_of(&pose.node_to_world[node.index()]);
            for (_, hand, forearm, mean) in &mut hands {
                mean.add(rotation(*forearm).inverse() * rotation(*hand));
            }
            let lines = Lines::new(pose, bones);
            for (node, share, mean) in &mut averages {
                if let Some(trunk) = lines.as_ref().and_then(|lines| lines.frame(*share)) {
                    mean.add(trunk.inverse() * rotation(*node));
                }
            }
        });
        let averages = averages.into_iter();
        Self {
            hinges: limbs.iter().flat_map(|limb| limb.hinges(true)).collect(),
            loose_hinges: limbs.iter().flat_map(|limb| limb.hinges(false)).collect(),
            averages: averages
                .filter_map(|(node, _, mean)| Some((node, mean.value()?)))
                .collect(),
            hands: hands
                .into_iter()
                .filter_map(|(bone, _, forearm, mean)| Some((bone, (forearm, mean.value()?))))
                .collect(),
            head: bones.get(&Bone::Head).copied(),
            trunk,
        }
    }

    /// The rotation about `along`, the direction of a bone in the world, that turns it as the motion shows it. `axes`
    /// is the rotation from the frame of the T-pose to the world, `rotation` that of each joint of the bone as it is,
    /// and `forearm_rotation` that of the joint of a forearm in the T-pose.
    pub(super) fn roll(
        &self,
        bone: Bone,
        joint: NodeId,
        axes: Quat,
        along: Vec3,
        rotation: impl Fn(NodeId) -> Quat,
        forearm_rotation: impl Fn(NodeId) -> Quat,
    ) -> Option<(Quat, Evidence)> {
        let along = along.try_normalize()?;
        if let Some((node, hinge)) = self.hinges.get(&bone) {
            let angle = angle_about(along, rotation(*node) * hinge.axis, axes * bend_axis(bone)?)?;
            return Some((Quat::from_axis_angle(along, angle), Evidence::Hinge));
        }
        if let Some((node, hinge)) = self.loose_hinges.get(&bone) {
            // A forearm is turned against its elbow by up to a quarter turn; more is a joint frame that lies
            // otherwise.
            let angle = angle_about(along, rotation(*node) * hinge.axis, axes * bend_axis(bone)?)?;
            let quarters = (angle / FRAC_PI_2).round() * FRAC_PI_2;
            return (angle.abs() > FARTHEST).then(|| (Quat::from_axis_angle(along, quarters), Evidence::Average));
        }
        let average = match (bone.on(Side::Left), self.hands.get(&bone)) {
            (_, Some((forearm, average))) => forearm_rotation(*forearm) * *average,
            (Bone::LeftUpperLeg | Bone::LeftUpperArm, None) => axes * *self.averages.get(&joint)?,
            _ => return None,
        };
        // From the T-pose to the average, twisted about the bone.
        let moved = average * rotation(joint).inverse();
        let sine = Vec3::new(moved.x, moved.y, moved.z).dot(along);
        let angle = 2.0 * sine.atan2(moved.w);
        angle
            .is_finite()
            .then(|| (Quat::from_axis_angle(along, angle), Evidence::Average))
    }

    /// The rotation of a hand in the world that it has on the average of the motion, with that of the joint of its
    /// forearm.
    pub(super) fn hand(&self, bone: Bone, forearm_rotation: impl Fn(NodeId) -> Quat) -> Option<Quat> {
        let (forearm, average) = self.hands.get(&bone)?;
        let hand = forearm_rotation(*forearm) * *average;
        hand.is_finite().then_some(hand)
    }

    /// The rotation in the world of a joint of the trunk that is turned by `rotation`, where the motion shows another:
    /// a quarter or a half turn about `up`, if that suffices.
    pub(super) fn settle(&self, node: NodeId, axes: Quat, rotation: Quat) -> Option<Quat> {
        let shown = axes * *self.averages.get(&node)?;
        let limit = if Some(node) == self.head { HEAD_AGREES } else { AGREES };
        let quarter = |count: u8| Quat::from_axis_angle(axes * Vec3::Y, f32::from(count) * FRAC_PI_2);
        let turned = (0..4).map(|count| (quarter(count) * rotation, count));
        let off = |rotation: Quat| rotation.angle_between(shown);
        let (nearest, count) = turned.min_by(|a, b| off(a.0).total_cmp(&off(b.0)))?;
        match (off(nearest) <= limit, count) {
            (true, 0) => None,
            (true, _) => Some(quarter(count)),
            (false, _) if off(rotation) <= limit => None,
            (false, _) => Some((shown * rotation.inverse()).normalize()),
        }
        .filter(|turn| turn.is_finite())
    }
}

/// The angle about a direction from one vector to another, in radians.
pub(crate) fn angle_about(along: Vec3, from: Vec3, to: Vec3) -> Option<f32> {
    let from = from.reject_from_normalized(along).try_normalize()?;
    let to = to.reject_from_normalized(along).try_normalize()?;
    let angle = along.dot(from.cross(to)).atan2(from.dot(to));
    angle.is_finite().then_some(angle)
}

/// Two bones with a hinge between them.
struct Limb {
    bones: [Bone; 3],
    joints: [NodeId; 3],
    /// The last joint of the upper bone, and the lower joint.
    turned: [NodeId; 2],
    /// The axis in the frames of these joints, weighted by how far the hinge is bent.
    seen: [Vec<(Vec3, f32)>; 2],
}

impl Limb {
    fn new(bones: [Bone; 3], hierarchy: &Hierarchy, known: &BTreeMap<Bone, NodeId>) -> Option<Self> {
        let joint = |bone: Bone| known.get(&bone).copied();
        let joints = [joint(bones[0])?, joint(bones[1])?, joint(bones[2])?];
        let above = hierarchy.parents[joints[1].index()].map(NodeId::new);
        let last = above.filter(|above| hierarchy.is_below(*above, joints[0]));
        Some(Self {
            bones,
            joints,
            turned: [last.unwrap_or(joints[0]), joints[1]],
            seen: [Vec::new(), Vec::new()],
        })
    }

    fn see(&mut self, pose: &Pose) {
        let at = self.joints.map(|joint| pose.position(joint));
        let upper = (at[1] - at[0]).normalize_or_zero();
        let lower = (at[2] - at[1]).normalize_or_zero();
        let axis = upper.cross(lower);
        let sine = axis.length();
        if sine.is_nan() || sine <= BENT {
            return;
        }
        for (node, seen) in self.turned.iter().zip(&mut self.seen) {
            let in_joint = rotation_of(&pose.node_to_world[node.index()]).inverse() * (axis / sine);
            seen.push((in_joint, sine * sine));
        }
    }

    /// The hinge of the upper bone, and that of the lower one where it is fixed in its joint; or where it is not.
    fn hinges(&self, is_fixed: bool) -> impl Iterator<Item = (Bone, (NodeId, Hinge))> {
        let upper = hinge(&self.seen[0]).filter(|_| is_fixed);
        let lower = hinge(&self.seen[1]).filter(|hinge| (hinge.spread <= FIXED) == is_fixed);
        let of_joint = |at: usize, hinge: Option<Hinge>| Some((self.bones[at], (self.turned[at], hinge?)));
        [of_joint(0, upper), of_joint(1, lower)].into_iter().flatten()
    }
}

/// The mean of weighted axes, in which those far from it count little; `None` where they show none.
fn hinge(seen: &[(Vec3, f32)]) -> Option<Hinge> {
    const ROUNDS: usize = 8;
    if seen.len() < FEWEST {
        return None;
    }
    let all: f32 = seen.iter().map(|(_, weight)| weight).sum();
    let sum: Vec3 = seen.iter().map(|(axis, weight)| *axis * *weight).sum();
    if sum.length() < 0.3 * all {
        return None;
    }
    let mut mean = sum.try_normalize()?;
    for _ in 0..ROUNDS {
        let near = |axis: Vec3| (1.0 + (axis.angle_between(mean) / HALF_WEIGHT).powi(2)).recip();
        let sum: Vec3 = seen.iter().map(|(axis, weight)| *axis * *weight * near(*axis)).sum();
        mean = sum.try_normalize()?;
    }
    let off = seen.iter().map(|(axis, weight)| weight * axis.angle_between(mean));
    Some(Hinge {
        axis: mean,
        spread: off.sum::<f32>() / all,
    })
}

/// The joints of the trunk from the hips to the head, from above in the hierarchy.
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

/// Both hands: the bone, its joint, that of the forearm, and the mean of its rotation against that.
fn hands(bones: &BTreeMap<Bone, NodeId>) -> Vec<(Bone, NodeId, NodeId, Mean)> {
    let sides = [Side::Left, Side::Right].into_iter();
    let hand = |side: Side| {
        let (hand, forearm) = (Bone::LeftHand.on(side), Bone::LeftLowerArm.on(side));
        Some((hand, *bones.get(&hand)?, *bones.get(&forearm)?, Mean::default()))
    };
    sides.filter_map(hand).collect()
}

/// The joints whose average against the trunk is taken, each with its fraction of the distance from hips to shoulders.
fn against_trunk(trunk: &[NodeId], bones: &BTreeMap<Bone, NodeId>) -> Vec<(NodeId, f32, Mean)> {
    let joint = |bone: Bone| bones.get(&bone).copied();
    let neck = joint(Bone::Neck).or(joint(Bone::Head));
    let spine = trunk.iter().position(|node| Some(*node) == neck).unwrap_or(trunk.len());
    let share = |place: usize| (place as f32 / spine.saturating_sub(1).max(1) as f32).min(1.0);
    let mut all: Vec<_> = trunk
        .iter()
        .enumerate()
        .map(|(place, node)| (*node, share(place), Mean::default()))
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
            .filter_map(|(bone, share)| Some((joint(bone)?, share, Mean::default()))),
    );
    all
}

/// The lines of the trunk in a pose.
struct Lines {
    hips: Vec3,
    shoulders: Vec3,
    up: Vec3,
}

impl Lines {
    fn new(pose: &Pose, bones: &BTreeMap<Bone, NodeId>) -> Option<Self> {
        let at = |bone: Bone| bones.get(&bone).map(|joint| pose.position(*joint));
        let across = |left: Bone, right: Bone| (at(left)? - at(right)?).try_normalize();
        let hips = across(Bone::LeftUpperLeg, Bone::RightUpperLeg)?;
        let middle = 0.5 * (at(Bone::LeftUpperLeg)? + at(Bone::RightUpperLeg)?);
        Some(Self {
            hips,
            shoulders: across(Bone::LeftUpperArm, Bone::RightUpperArm).unwrap_or(hips),
            up: (at(Bone::Neck).or(at(Bone::Head))? - middle).try_normalize()?,
        })
    }

    /// Left, up and forward at a fraction of the distance from hips to shoulders, as a rotation to the world.
    fn frame(&self, share: f32) -> Option<Quat> {
        let left = self.hips.lerp(self.shoulders, share).try_normalize()?;
        let up = self.up.reject_from_normalized(left).try_normalize()?;
        let frame = Quat::from_mat3(&Mat3::from_cols(left, up, left.cross(up)));
        frame.is_finite().then_some(frame)
    }
}

/// The mean of rotations.
struct Mean {
    sum: Quat,
    count: usize,
}

impl Default for Mean {
    fn default() -> Self {
        Self {
            sum: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
            count: 0,
        }
    }
}

impl Mean {
    fn add(&mut self, rotation: Quat) {
        if rotation.is_finite() {
            // A rotation and its negative are one.
            let sign = if self.sum.dot(rotation) < 0.0 { -1.0 } else { 1.0 };
            self.sum += rotation * sign;
            self.count += 1;
        }
    }

    fn value(&self) -> Option<Quat> {
        let is_clear = self.count >= FEWEST && self.sum.length() > 0.5 * self.count as f32;
        is_clear.then(|| self.sum.normalize())
    }
}

/// Calls `see` with some poses, evenly spaced.
fn sample(scene: &Scene, mut see: impl FnMut(&Pose)) {
    let frames: usize = scene.animations.iter().map(Animation::frame_count).sum();
    let step = frames.div_ceil(FRAMES).max(1);
    let mut pose = Pose::rest(scene);
    for animation in &scene.animations {
        let binding = Binding::new(scene, animation);
        for frame in (0..animation.frame_count()).step_by(step) {
            pose.sample(&binding, animation, frame as f64);
            see(&pose);
        }
    }
}
