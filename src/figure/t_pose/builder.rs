//! Builds the T-pose: rotates the bones from the reference pose, one by one.

use std::collections::BTreeMap;

use glam::{Mat3, Mat4, Quat, Vec3};
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{Animation, Confidence, HumanoidBone as Bone, NodeId, NodeKind, Scene, Side};

use super::pointing::{direction, next};
use super::{TPose, TPoseBone, TPoseReason, TPoseSource};
use crate::axes::{Evidence, Shown, angle_about};
use crate::hierarchy::Hierarchy;
use crate::knuckles::Knuckles;

/// If the facing of the rest pose differs from the nearest axis by at most this angle in radians, it was meant to be
/// along the axis. A larger angle is intended, and the figure is rotated to face along the axis.
const FACING_IS_INEXACT: f32 = 0.09;

/// If a foot points farther down than this fraction of its length, it does not stand on its sole in the rest pose.
const POINTED_FOOT: f32 = 0.9;

/// The largest angle in radians by which a bone may rotate from a standing rest pose to the T-pose, if its roll is to
/// be certain. Arms that hang down rotate by 90 degrees.
const SMALL_TURN: f32 = 1.05;

/// The roll of a palm that faces forward or back in a standing rest pose, in radians. A palm that is rolled further
/// faces up.
const SIDEWAYS_PALM: std::ops::RangeInclusive<f32> = 0.8..=2.2;

/// The direction of a thumb in the T-pose, seen along the hand. The thumbs of SOMA's and MakeHuman's bodies are 33 and
/// 21 degrees below the palm.
const THUMB: Vec3 = Vec3::new(0.0, -0.45, 0.89);

/// The rotation of a bone from the reference pose to the T-pose.
pub(super) struct TPoseRotation {
    pub(super) rotation: Quat,
    pub(super) confidence: Confidence,
    pub(super) reason: TPoseReason,
}

/// A T-pose while it is built.
pub(super) struct Builder {
    pub(super) source: TPoseSource,
    /// Whether the reference pose is the T-pose itself.
    pub(super) is_t_pose: bool,
    pub(super) knuckles: Knuckles,
    pub(super) axes: Quat,
    pub(super) bones: BTreeMap<Bone, NodeId>,
    pub(super) hierarchy: Hierarchy,
    /// What the motion shows, if the figure does not stand in its rest pose.
    pub(super) shown: Option<Shown>,
    /// The reference pose.
    pub(super) positions: Vec<Vec3>,
    pub(super) rotations: Vec<Quat>,
    /// The rotation of each bone from the reference pose to the T-pose.
    pub(super) to_t_pose: BTreeMap<Bone, TPoseRotation>,
}

impl Builder {
    pub(super) fn joint(&self, bone: Bone) -> Option<NodeId> {
        self.bones.get(&bone).copied()
    }

    pub(super) fn position(&self, node: NodeId) -> Vec3 {
        self.positions[node.index()]
    }

    pub(super) fn turn_bones(&mut self, axes: &Mat3) {
        if self.is_t_pose {
            let stands = || TPoseRotation {
                rotation: Quat::IDENTITY,
                confidence: Confidence::Sure,
                reason: TPoseReason::Stands,
            };
            self.to_t_pose = self.bones.keys().map(|bone| (*bone, stands())).collect();
            return;
        }
        let facing = self.turn_to_face(axes.y_axis, axes.z_axis);
        let mut turned: BTreeMap<Bone, TPoseRotation> = BTreeMap::new();
        for (&bone, &joint) in &self.bones {
            let above = std::iter::successors(bone.parent(), |bone| bone.parent())
                .find_map(|above| turned.get(&above))
                .map_or(facing, |found| found.rotation);
            turned.insert(bone, self.choose(bone, joint, facing, above, axes));
        }
        self.to_t_pose = turned;
    }

    /// Chooses the rotation of a bone to its T-pose, with the reason. `facing` rotates the whole figure forward.
    /// `above` is the rotation of the parent bone. `axes` has the directions left, up and forward in the world.
    fn choose(&self, bone: Bone, joint: NodeId, facing: Quat, above: Quat, axes: &Mat3) -> TPoseRotation {
        let (rotation, reason) = match (direction(bone), bone.on(Side::Left)) {
            (Some(direction), part) => {
                let start = match part {
                    Bone::LeftUpperArm | Bone::LeftUpperLeg => facing,
                    _ => above,
                };
                let next = next(&self.hierarchy, &self.bones, &self.knuckles, bone, joint);
                let along = next.map(|next| start * self.offset(joint, next));
                match along.filter(|along| along.length() > self.shortest(joint)) {
                    Some(along) => {
                        let to_t_pose = arc(along, self.axes * direction) * start;
                        self.palm_down(bone, joint, to_t_pose, direction)
                            .or_else(|| self.rolled(bone, joint, to_t_pose, direction, above))
                            .unwrap_or((to_t_pose, TPoseReason::ShortestArc))
                    }
                    None => self
                        .as_on_average(bone, joint, above)
                        .unwrap_or((start, TPoseReason::FollowsTheBoneAbove)),
                }
            }
            (None, Bone::LeftFoot) => (
                self.foot(joint, bone, facing, axes.y_axis, axes.z_axis),
                TPoseReason::OnItsSole,
            ),
            (None, Bone::LeftToes) => (above, TPoseReason::FollowsTheBoneAbove),
            _ if self.is_of_trunk_as_shown(joint) => (facing, TPoseReason::AverageOfMotion),
            _ => (facing, TPoseReason::Stands),
        };
        let is_small = rotation.angle_between(facing) <= SMALL_TURN;
        let is_exact = self.shown.as_ref().is_some_and(|shown| shown.is_exact(joint));
        let is_vague = self.shown.as_ref().is_some_and(|shown| shown.is_vague(bone));
        let is_shown = |reason| {
            matches!(
                reason,
                TPoseReason::Hinge | TPoseReason::OtherSide | TPoseReason::Knuckles
            )
        };
        TPoseRotation {
            rotation: rotation.normalize(),
            confidence: match self.source {
                TPoseSource::RestPose if is_small => Confidence::Sure,
                TPoseSource::RestPose | TPoseSource::FirstFrame => Confidence::Likely,
                TPoseSource::Computed if is_shown(reason) && !is_vague || is_exact => Confidence::Likely,
                TPoseSource::Computed => Confidence::Unsure,
            },
            reason,
        }
    }

    /// Whether a joint of the trunk is rotated in the reference pose as the motion shows.
    fn is_of_trunk_as_shown(&self, joint: NodeId) -> bool {
        let shown = self.shown.as_ref().and_then(|shown| shown.of_trunk(joint, self.axes));
        self.source == TPoseSource::Computed && shown.is_some()
    }

    /// The rotation of a bone that points along `direction` after `to_t_pose`, with the roll that the motion shows.
    /// `above` is the rotation of the parent bone.
    fn rolled(
        &self,
        bone: Bone,
        joint: NodeId,
        to_t_pose: Quat,
        direction: Vec3,
        above: Quat,
    ) -> Option<(Quat, TPoseReason)> {
        let rotation = |node: NodeId| to_t_pose * self.rotations[node.index()];
        let forearm = |node: NodeId| above * self.rotations[node.index()];
        let shown = self.shown.as_ref()?;
        let (roll, evidence) = shown.roll(bone, joint, self.axes, self.axes * direction, rotation, forearm)?;
        match evidence {
            Evidence::Hinge => Some((roll * to_t_pose, TPoseReason::Hinge)),
            Evidence::UnlikeOtherSide => Some((roll * to_t_pose, TPoseReason::HingeUnlikeOtherSide)),
            // A first frame in T-pose is better evidence than an average rotation or the hinge of the other side.
            _ if self.source == TPoseSource::FirstFrame => None,
            Evidence::OtherSide => Some((roll * to_t_pose, TPoseReason::OtherSide)),
            Evidence::Average => Some((roll * to_t_pose, TPoseReason::AverageOfMotion)),
        }
    }

    /// The vector from a joint to the node towards which it points, in the reference pose. If the reference pose is
    /// computed, knuckles have their average position in the hand.
    fn offset(&self, joint: NodeId, next: NodeId) -> Vec3 {
        let shown = self.shown.as_ref().filter(|_| self.source == TPoseSource::Computed);
        let knuckle = shown.and_then(|shown| shown.to_knuckle(next, |node| self.rotations[node.index()]));
        knuckle.unwrap_or_else(|| self.position(next) - self.position(joint))
    }

    /// The smallest length of a bone with a direction: a thousandth of its parent bone.
    fn shortest(&self, joint: NodeId) -> f32 {
        let above = self.hierarchy.parents[joint.index()].map(NodeId::new);
        above.map_or(0.0, |above| 1e-3 * self.position(joint).distance(self.position(above)))
    }

    /// The rotation of a hand without evidence of its own: its average rotation relative to the forearm. `above` is the
    /// rotation of the forearm.
    fn as_on_average(&self, bone: Bone, joint: NodeId, above: Quat) -> Option<(Quat, TPoseReason)> {
        let forearm = |node: NodeId| above * self.rotations[node.index()];
        let hand = self.shown.as_ref()?.hand(bone, forearm)?;
        let to_t_pose = hand * self.rotations[joint.index()].inverse();
        (self.source == TPoseSource::Computed).then_some((to_t_pose, TPoseReason::AverageOfMotion))
    }

    /// Rolls a hand that points along `direction` after `to_t_pose` until the palm is down. Then the knuckle of the
    /// index finger is in front of the knuckle of the little finger, or the thumb in front of the hand. In a standing
    /// rest pose, hands are not quite flat, so only palms that face forward, back or up are rolled. For a palm that
    /// faces up, the thumb must confirm it: the thumb begins on the side of the index finger. Otherwise fingers with
    /// names in the opposite order would turn the hand over.
    fn palm_down(&self, bone: Bone, joint: NodeId, to_t_pose: Quat, direction: Vec3) -> Option<(Quat, TPoseReason)> {
        let side = bone.side().filter(|side| bone.on(*side) == Bone::LeftHand.on(*side))?;
        let at = |finger: Bone| Some(self.offset(joint, self.knuckles.of(finger.on(side))?));
        let knuckles = at(Bone::LeftIndexProximal).zip(at(Bone::LeftLittleProximal));
        let thumb = || at(Bone::LeftThumbProximal);
        let (across, forward) = match knuckles {
            Some((index, little)) => (index - little, Vec3::Z),
            None => (thumb()?, THUMB),
        };
        let along = self.axes * direction;
        let angle = angle_about(along, to_t_pose * across, self.axes * forward)?;
        let is_up = || {
            let beside_index = thumb().is_some_and(|thumb| thumb.dot(across) > 0.0);
            angle.abs() > *SIDEWAYS_PALM.end() && knuckles.is_some() && beside_index
        };
        let counts = self.source == TPoseSource::Computed || SIDEWAYS_PALM.contains(&angle.abs()) || is_up();
        counts.then(|| (Quat::from_axis_angle(along, angle) * to_t_pose, TPoseReason::Knuckles))
    }

    /// The rotation about the up axis that makes the figure of the reference pose face along an axis.
    pub(super) fn turn_to_face(&self, up: Vec3, forward: Vec3) -> Quat {
        // A computed reference pose faces along the axis, whatever the rotation of its collar bones.
        if self.source == TPoseSource::Computed {
            return Quat::IDENTITY;
        }
        let across = |left: Bone, right: Bone| {
            let across = self.position(self.joint(left)?) - self.position(self.joint(right)?);
            (across - across.project_onto_normalized(up)).try_normalize()
        };
        let hips = across(Bone::LeftUpperLeg, Bone::RightUpperLeg).unwrap_or_default();
        let shoulders = across(Bone::LeftUpperArm, Bone::RightUpperArm).unwrap_or_default();
        let Some(seen) = (hips + shoulders).cross(up).try_normalize() else {
            return Quat::IDENTITY;
        };
        let angle = seen.cross(forward).dot(up).atan2(seen.dot(forward));
        if angle.abs() < FACING_IS_INEXACT {
            return Quat::IDENTITY;
        }
        Quat::from_axis_angle(up, angle)
    }

    /// Rotates the heading of a foot that stands on its sole in the reference pose, so that the foot points forward.
    pub(super) fn foot(&self, joint: NodeId, bone: Bone, facing: Quat, up: Vec3, forward: Vec3) -> Quat {
        let side = bone.side().unwrap_or(Side::Left);
        let toes = self.joint(Bone::LeftToes.on(side));
        let toes = toes.or_else(|| self.hierarchy.only_child(joint));
        let along = toes.and_then(|toes| (facing * (self.position(toes) - self.position(joint))).try_normalize());
        let Some(along) = along else {
            return facing;
        };
        if along.dot(up).abs() > POINTED_FOOT {
            return arc(along, forward - 0.4 * up) * facing;
        }
        let flat = along - along.project_onto_normalized(up);
        arc(flat, forward) * facing
    }

    /// Every node in the T-pose. Joints that are not bones move with the nearest ancestor bone.
    pub(super) fn finish(self, scene: &Scene, reference: &Pose) -> TPose {
        let mut bone_of = vec![None; scene.nodes.len()];
        for (bone, joint) in &self.bones {
            bone_of[joint.index()] = Some(*bone);
        }
        let mut pose = Pose::rest(scene);
        // The rotation of each node from the reference pose, and of each bone from the rest pose.
        let mut turned: Vec<Quat> = Vec::with_capacity(scene.nodes.len());
        let mut from_rest = vec![Quat::IDENTITY; scene.nodes.len()];
        let mut rotations = BTreeMap::new();
        for (index, bone) in bone_of.iter().enumerate() {
            let parent = self.hierarchy.parents[index];
            let above = parent.map_or(Quat::IDENTITY, |parent| turned[parent]);
            let to_t_pose = bone.and_then(|bone| self.to_t_pose.get(&bone));
            let to_t_pose = to_t_pose.map_or(above, |found| found.rotation);
            turned.push(to_t_pose);
            let position = parent.map_or(self.positions[index], |parent| {
                pose.node_to_world[parent].w_axis.truncate() + above * (self.positions[index] - self.positions[parent])
            });
            let rotation = to_t_pose * self.rotations[index];
            let rest_rotation = rotation_of(&pose.node_to_world[index]);
            if let Some(parent) = parent {
                from_rest[index] = from_rest[parent];
            }
            if let Some(bone) = bone {
                let all = rotation * rest_rotation.inverse();
                rotations.insert(*bone, (all * from_rest[index].inverse()).normalize());
                from_rest[index] = all;
            }
            // Scale and shear of the reference pose are kept.
            let linear = &reference.node_to_world[index];
            let shape = Mat4::from_quat(rotation_of(linear).inverse()) * Mat4::from_mat3(Mat3::from_mat4(*linear));
            pose.node_to_world[index] = Mat4::from_rotation_translation(rotation, position) * shape;
            let parent_to_world = parent.map_or(Mat4::IDENTITY, |parent| pose.node_to_world[parent]);
            // An end site keeps its exact position, so that it counts as unmoved.
            let is_unmoved = scene.nodes[index].kind == NodeKind::EndSite
                && reference.node_to_parent[index] == pose.node_to_parent[index];
            let node_to_parent = match is_unmoved {
                true => pose.node_to_parent[index],
                false => parent_to_world.inverse() * pose.node_to_world[index],
            };
            if node_to_parent.is_finite() {
                pose.node_to_parent[index] = node_to_parent;
            }
        }
        let bone = |(bone, to_t_pose): (Bone, TPoseRotation)| {
            let made = TPoseBone {
                joint: self.bones[&bone],
                rotation: rotations[&bone],
                confidence: to_t_pose.confidence,
                reason: to_t_pose.reason,
                reference_to_t_pose: to_t_pose.rotation,
            };
            (bone, made)
        };
        TPose {
            source: self.source,
            pose,
            bones: self.to_t_pose.into_iter().map(bone).collect(),
            axes: self.axes,
            positions: self.positions,
            rotations: self.rotations,
            frames: scene.animations.iter().map(Animation::frame_count).sum(),
        }
    }
}
