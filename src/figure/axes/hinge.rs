//! Finds the bending axis of an elbow or a knee. The axis is given in the coordinate frames of the upper joint and of
//! the lower joint.

use std::collections::BTreeMap;

use glam::Vec3;
use mocap_scene::math::directions::rotation_of;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

use super::{FEWEST, LIMBS};
use crate::hierarchy::Hierarchy;

/// The sine of the smallest bend that shows the axis of a hinge: 12 degrees.
const BENT: f32 = 0.2;

/// If a hinge axis deviates from its mean by at most this angle in radians, it is fixed in the coordinate frame of the
/// lower joint. It is not fixed if the elbow joint also twists the forearm.
const FIXED: f32 = 0.21;

/// If the axes deviate from their mean by more than this angle in radians (52 degrees), they are random. This happens
/// for knees whose joints have a random roll.
const WIDEST: f32 = 0.9;

/// An axis at this angle to the mean axis, in radians, has half its weight in the mean.
const HALF_WEIGHT: f32 = 0.15;

/// The cosine of 18 degrees. If an axis of a joint's coordinate frame is within this angle of the bone, the frame lies
/// along the bone.
const ALONG: f32 = 0.95;

/// The cosine of 8 degrees. A hinge within this angle of a coordinate axis of its joint is on that axis. In fixtures
/// whose coordinate frames lie along the bones, knees deviate by up to 8 degrees, and elbows by up to 6.
const ON_AXIS: f32 = 0.99;

/// The cosine of 2 degrees. It replaces [`ON_AXIS`] for a lower joint that also twists its shin or forearm.
const LOWER_ON_AXIS: f32 = 0.9994;

/// The largest angle between a bone and the mirrored bone of the other side, in the coordinate frames of their joints,
/// in radians.
const MIRRORED: f32 = 0.1;

/// The largest angle in radians between the axis of one side and the mirrored axis of the other at which they agree.
const AGREES: f32 = 0.6;

/// Consecutive frames show one bend of the joint. This number of such frames counts as one observation.
const ALIKE: f32 = 20.0;

/// The axis of a hinge in the coordinate frame of a joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hinge {
    pub(super) axis: Vec3,
    /// The mean deviation of the axis from its mean, in radians.
    spread: f32,
    /// The uncertainty of the mean axis, in radians. Other frames of the motion would give another mean.
    pub(super) error: f32,
}

/// The coordinate axis nearest to a direction, if the cosine of the angle is at least `cosine`.
pub(super) fn nearest_axis(direction: Vec3, cosine: f32) -> Option<Vec3> {
    let direction = direction.try_normalize()?;
    let axes = Vec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    let nearest = axes.max_by(|a, b| a.dot(direction).total_cmp(&b.dot(direction)))?;
    (nearest.dot(direction) >= cosine).then_some(nearest)
}

/// Whether an axis of a joint's coordinate frame lies along its bone. A program that aligns one axis with the bone
/// aligns the other two axes with the body.
pub(super) fn is_laid_along(bone: Vec3) -> bool {
    nearest_axis(bone, ALONG).is_some()
}

/// If coordinate frames lie along at least this fraction of the bones, the program aligned them with the bones. Random
/// coordinate frames lie along one bone in seven.
const LAID: f32 = 0.6;

/// Whether a program aligned the coordinate frames of joints with their bones. A single joint may be aligned by chance.
pub(super) fn are_laid_along(scene: &Scene, hierarchy: &Hierarchy, bones: &BTreeMap<Bone, NodeId>) -> bool {
    let mut joints = bones.values().map(|joint| joint.index()).collect::<Vec<_>>();
    joints.sort_unstable();
    let to_child = |joint: &usize| {
        let child = joints.iter().find(|child| hierarchy.parents[**child] == Some(*joint));
        let child = child
            .copied()
            .or_else(|| Some(hierarchy.only_child(NodeId::new(*joint))?.index()))?;
        scene.nodes[child].transform.w_axis.truncate().try_normalize()
    };
    let along: Vec<Vec3> = joints.iter().filter_map(to_child).collect();
    let laid = along.iter().filter(|line| is_laid_along(**line)).count();
    laid as f32 >= LAID * along.len() as f32
}

/// Two bones with a hinge between them.
pub(super) struct Limb {
    pub(super) bones: [Bone; 3],
    joints: [NodeId; 3],
    /// The last joint of the upper bone, and the lower joint.
    pub(super) turned: [NodeId; 2],
    /// The directions of the bones in the coordinate frames of these joints; `None` if other joints are between its
    /// ends.
    along: [Option<Vec3>; 2],
    /// Whether the coordinate frames of its joints lie along its bones.
    is_laid: bool,
    /// The axis in the coordinate frames of these joints, weighted by the bend of the hinge.
    seen: [Vec<(Vec3, f32)>; 2],
}

impl Limb {
    fn new(scene: &Scene, bones: [Bone; 3], hierarchy: &Hierarchy, known: &BTreeMap<Bone, NodeId>) -> Option<Self> {
        let joint = |bone: Bone| known.get(&bone).copied();
        let joints = [joint(bones[0])?, joint(bones[1])?, joint(bones[2])?];
        let above = hierarchy.parents[joints[1].index()].map(NodeId::new);
        let last = above.filter(|above| hierarchy.is_below(*above, joints[0]));
        let turned = [last.unwrap_or(joints[0]), joints[1]];
        let along = |from: NodeId, to: NodeId| {
            let node = &scene.nodes[to.index()];
            (node.parent == Some(from)).then(|| node.transform.w_axis.truncate())
        };
        Some(Self {
            bones,
            joints,
            turned,
            along: [along(turned[0], joints[1]), along(joints[1], joints[2])],
            is_laid: false,
            seen: [Vec::new(), Vec::new()],
        })
    }

    /// The limbs of a body. Coordinate frames may lie along the bones in the whole skeleton, in both legs only, or in
    /// both arms only.
    pub(super) fn all(
        scene: &Scene,
        hierarchy: &Hierarchy,
        known: &BTreeMap<Bone, NodeId>,
        all_are_laid: bool,
    ) -> Vec<Self> {
        let limbs = LIMBS.into_iter();
        let mut limbs: Vec<Self> = limbs
            .filter_map(|limb| Self::new(scene, limb, hierarchy, known))
            .collect();
        let kind = |limb: &Self| limb.bones[0].on(Side::Left);
        let is_along = |limb: &Self| limb.along.iter().all(|bone| bone.is_some_and(is_laid_along));
        let laid = |limb: &Self| {
            let mut both = limbs.iter().filter(|other| kind(other) == kind(limb));
            all_are_laid || both.clone().count() == 2 && both.all(is_along)
        };
        let laid: Vec<bool> = limbs.iter().map(laid).collect();
        limbs.iter_mut().zip(laid).for_each(|(limb, laid)| limb.is_laid = laid);
        limbs
    }

    pub(super) fn see(&mut self, pose: &Pose) {
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

    /// The hinge in the coordinate frame of the upper bone, and in the coordinate frame of the lower bone if it is
    /// fixed there.
    pub(super) fn hinges(&self) -> [Option<Hinge>; 2] {
        let at = |segment: usize| {
            let hinge = hinge(&self.seen[segment])?;
            let cosine = [ON_AXIS, LOWER_ON_AXIS][segment];
            let of_joint = self.axis_of_joint(segment, hinge.axis, cosine);
            let exact = |axis: Vec3| Hinge {
                axis,
                error: 0.0,
                ..hinge
            };
            Some(of_joint.map_or(hinge, exact))
        };
        [
            at(0).filter(|hinge| hinge.spread <= WIDEST),
            at(1).filter(|hinge| hinge.spread <= FIXED),
        ]
    }

    /// The axis of the upper (0) or lower (1) joint that is across the bone and nearest to `axis`. `None` unless the
    /// joint's coordinate frame lies along the bone. This axis does not depend on the examined frames.
    pub(super) fn axis_of_joint(&self, segment: usize, axis: Vec3, cosine: f32) -> Option<Vec3> {
        let along = nearest_axis(self.along[segment].filter(|_| self.is_laid)?, ALONG)?;
        nearest_axis(axis.reject_from_normalized(along), 0.0).filter(|nearest| nearest.dot(axis) >= cosine)
    }

    /// The mirror image of `axis`, an axis of a joint of the `other` side, in the joint of this side. If the bones lie
    /// along an axis, there are two solutions, half a turn apart.
    pub(super) fn mirrored(&self, other: &Self, segment: usize, axis: Vec3) -> Vec<Vec3> {
        // Coordinate frames of both sides are mirrored in the body, and some axes may be negated.
        const MIRRORS: [Vec3; 4] = [
            Vec3::new(-1.0, 1.0, 1.0),
            Vec3::new(1.0, -1.0, 1.0),
            Vec3::new(1.0, 1.0, -1.0),
            Vec3::NEG_ONE,
        ];
        let Some((bone, along)) = self.along[segment].zip(other.along[segment]) else {
            return Vec::new();
        };
        let fits = |mirror: &Vec3| (*mirror * along).angle_between(bone) < MIRRORED;
        MIRRORS.into_iter().filter(fits).map(|mirror| -mirror * axis).collect()
    }

    /// Whether the coordinate frames of left and right are mirror images, but the hinges are not.
    pub(super) fn contradicts(&self, other: &Self, segment: usize, axis: Vec3, of_other: Vec3) -> bool {
        let mirrored = self.mirrored(other, segment, of_other);
        !mirrored.is_empty() && mirrored.iter().all(|here| here.angle_between(axis) > AGREES)
    }
}

/// A robust mean of weighted axes, in which outliers have little weight; `None` if there is no clear mean.
fn hinge(seen: &[(Vec3, f32)]) -> Option<Hinge> {
    /// The number of iterations of the robust mean. Each iteration moves the mean less.
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
    let spread = off.sum::<f32>() / all;
    Some(Hinge {
        axis: mean,
        spread,
        error: spread * (ALIKE / seen.len() as f32).sqrt(),
    })
}
