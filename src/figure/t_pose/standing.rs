//! Chooses the reference pose from which the T-pose is made: a standing figure.

use glam::{Mat3, Mat4, Quat, Vec3};
use mocap_scene::math::directions::{arc, rotation_of};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

use super::TPoseSource;
use super::pointing::POINTING_KNUCKLES;
use crate::axes::Shown;
use crate::axis::{Axis, RestPose};
use crate::humanoid::Humanoid;
use crate::knuckles::Knuckles;
use crate::measure::Measures;

/// The largest angle between the trunk of a standing figure and the up axis, in radians.
const UPRIGHT: f32 = 0.35;

/// The sources of a reference pose.
pub(super) struct Sources<'a> {
    pub(super) humanoid: &'a Humanoid,
    pub(super) knuckles: &'a Knuckles,
    /// What the motion shows, if the figure does not stand in its rest pose.
    pub(super) shown: Option<&'a Shown>,
}

/// The reference pose. If the figure stands in its rest pose, it is the rest pose, and `shown` is `None`. Otherwise it
/// is the first frame of the motion if this frame is a T-pose, or else a figure whose bones are rotated to their
/// directions in a T-pose.
pub(super) fn reference(scene: &Scene, sources: &Sources<'_>, up: Axis, figure_to_world: &Mat3) -> (TPoseSource, Pose) {
    let &Sources { humanoid, shown, .. } = sources;
    let rest = Pose::rest(scene);
    let Some(shown) = shown else {
        return (
            TPoseSource::RestPose,
            upright(scene, humanoid, figure_to_world.y_axis, rest),
        );
    };
    if let Some(first) = Pose::at_tick(scene, 0, 0.0) {
        let positions = (0..scene.nodes.len()).map(|node| first.position(NodeId::new(node)));
        let figure = Measures::with_positions(scene, humanoid, positions.collect());
        // In a motion, arms may also be raised sideways in other poses, but then the body is not upright.
        let is_upright = figure
            .rest_up()
            .is_some_and(|trunk| trunk.dot(figure_to_world.y_axis) > UPRIGHT.cos());
        if is_upright && figure.rest_pose(up).value == RestPose::TPose {
            return (TPoseSource::FirstFrame, first);
        }
    }
    (
        TPoseSource::Computed,
        computed(scene, figure_to_world, sources, shown, rest),
    )
}

/// Rotates a rest pose upright if its trunk lies or leans in the world of the motion, as below a root that is rotated
/// in every frame.
fn upright(scene: &Scene, humanoid: &Humanoid, up: Vec3, mut rest: Pose) -> Pose {
    let positions = (0..scene.nodes.len()).map(|node| rest.position(NodeId::new(node)));
    let trunk = Measures::with_positions(scene, humanoid, positions.collect()).rest_up();
    let Some(trunk) = trunk.filter(|trunk| trunk.angle_between(up) > UPRIGHT) else {
        return rest;
    };
    let turn = Mat4::from_quat(arc(trunk, up));
    for (index, node) in scene.nodes.iter().enumerate() {
        if node.parent.is_none() {
            rest.node_to_parent[index] = turn * rest.node_to_parent[index];
        }
    }
    rest.update_world();
    rest
}

/// Rotates each bone, from the hips outwards, to its direction in the T-pose.
fn computed(scene: &Scene, figure_to_world: &Mat3, sources: &Sources<'_>, shown: &Shown, rest: Pose) -> Pose {
    let &Sources { humanoid, knuckles, .. } = sources;
    let axes = Axes::new(figure_to_world);
    let to_world = Quat::from_mat3(figure_to_world).normalize();
    let joint = |bone: Bone| humanoid.joint(bone);
    let is_bone = |node: NodeId| humanoid.bones.values().any(|joint| joint.joint == node);
    let settle = |pose: &mut Pose, node: NodeId| {
        if let Some(rotation) = shown.of_trunk(node, to_world) {
            let as_it_is = rotation_of(&pose.node_to_world[node.index()]);
            turn(pose, scene, node, rotation * as_it_is.inverse());
        }
    };
    let mut between = shown.trunk.iter().copied().filter(|node| !is_bone(*node)).peekable();
    let mut pose = rest;
    for (node, node_to_parent) in &shown.usual {
        pose.node_to_parent[node.index()] = *node_to_parent;
    }
    pose.update_world();
    for &bone in Bone::ALL {
        let Some(node) = joint(bone) else { continue };
        // Joints of the trunk that are not bones are rotated before their descendants.
        while shown.trunk.contains(&node)
            && let Some(above) = between.next_if(|above| above.index() < node.index())
        {
            settle(&mut pose, above);
        }
        let rotation = match bone {
            Bone::Hips => axes.hips(&pose, &joint),
            _ => next_of(scene, bone, node, &joint, knuckles).and_then(|next| {
                let as_it_is = |node: NodeId| rotation_of(&pose.node_to_world[node.index()]);
                let toward = shown.to_knuckle(next, as_it_is);
                let toward = toward
                    .unwrap_or_else(|| pose.position(next) - pose.position(node))
                    .try_normalize()?;
                Some(Quat::from_rotation_arc(toward, axes.direction(bone)?))
            }),
        };
        let rotation = rotation.filter(|rotation| rotation.is_finite());
        turn(&mut pose, scene, node, rotation.unwrap_or(Quat::IDENTITY));
        if matches!(bone, Bone::Spine | Bone::Chest | Bone::UpperChest)
            && let Some(about) = axes.shoulders(scene, &pose, node, &joint)
        {
            turn(&mut pose, scene, node, about);
        }
        if shown.trunk.contains(&node) {
            settle(&mut pose, node);
        }
        let along = axes.direction(bone);
        let as_it_is = |node: NodeId| rotation_of(&pose.node_to_world[node.index()]);
        if let Some((roll, _)) = along.and_then(|along| shown.roll(bone, node, to_world, along, as_it_is, as_it_is)) {
            turn(&mut pose, scene, node, roll);
        }
    }
    pose
}

/// Rotates a node about its position in the world, with all its descendants.
fn turn(pose: &mut Pose, scene: &Scene, node: NodeId, rotation: Quat) {
    if rotation == Quat::IDENTITY {
        return;
    }
    let at = pose.position(node);
    let about = Mat4::from_translation(at) * Mat4::from_quat(rotation) * Mat4::from_translation(-at);
    let node_to_world = about * pose.node_to_world[node.index()];
    let parent = scene.nodes[node.index()].parent;
    let parent_to_world = parent.map_or(Mat4::IDENTITY, |parent| pose.node_to_world[parent.index()]);
    let node_to_parent = parent_to_world.inverse() * node_to_world;
    if node_to_parent.is_finite() {
        pose.node_to_parent[node.index()] = node_to_parent;
        pose.update_world();
    }
}

/// The node that shows the direction of a bone: the next bone, or else the child of its joint.
fn next_of(
    scene: &Scene,
    bone: Bone,
    node: NodeId,
    joint: &impl Fn(Bone) -> Option<NodeId>,
    knuckles: &Knuckles,
) -> Option<NodeId> {
    let side = bone.side().unwrap_or(Side::Left);
    let candidates: &[Bone] = match bone {
        Bone::Spine => &[Bone::Chest, Bone::UpperChest, Bone::Neck, Bone::Head],
        Bone::Chest => &[Bone::UpperChest, Bone::Neck, Bone::Head],
        Bone::UpperChest => &[Bone::Neck, Bone::Head],
        _ => &[],
    };
    if bone.on(Side::Left) == Bone::LeftHand
        && let Some(knuckle) = POINTING_KNUCKLES
            .iter()
            .find_map(|knuckle| knuckles.of(knuckle.on(side)))
    {
        return Some(knuckle);
    }
    let hangs_on = |child: &NodeId| {
        let parent = |node: &NodeId| scene.nodes[node.index()].parent;
        std::iter::successors(parent(child), parent).any(|above| above == node)
    };
    let listed = candidates.iter().map(|candidate| candidate.on(side));
    let below = Bone::ALL.iter().copied().filter(|other| {
        candidates.is_empty() && other.parent() == Some(bone) && !other.as_str().contains("Eye") && *other != Bone::Jaw
    });
    let next = listed.chain(below).filter_map(joint).find(hangs_on);
    // If the head is the root of the skeleton, the next bone is an ancestor.
    let carries_a_bone = Bone::ALL
        .iter()
        .filter_map(|other| joint(*other))
        .any(|other| hangs_on(&other));
    if next.is_none() && carries_a_bone {
        return None;
    }
    next.or_else(|| {
        let is_bone = |child: &NodeId| Bone::ALL.iter().any(|other| joint(*other) == Some(*child));
        let is_child = |index: &usize| scene.nodes[*index].parent == Some(node);
        let mut children = (node.index() + 1..scene.nodes.len()).filter(is_child).map(NodeId::new);
        // Eyes and a jaw are in front of a head, not above it.
        children.find(|child| !is_bone(child))
    })
}

/// The axes left, up and forward of a standing figure.
struct Axes {
    left: Vec3,
    up: Vec3,
    forward: Vec3,
}

impl Axes {
    fn new(axes: &Mat3) -> Self {
        Self {
            left: axes.x_axis,
            up: axes.y_axis,
            forward: axes.z_axis,
        }
    }

    /// The direction of a bone in the T-pose; `None` for a bone that keeps its direction.
    fn direction(&self, bone: Bone) -> Option<Vec3> {
        let outwards = if bone.side() == Some(Side::Right) {
            -self.left
        } else {
            self.left
        };
        match bone.on(Side::Left) {
            Bone::Hips | Bone::LeftEye | Bone::Jaw | Bone::LeftToes | Bone::LeftShoulder => None,
            Bone::Spine | Bone::Chest | Bone::UpperChest | Bone::Neck | Bone::Head => Some(self.up),
            Bone::LeftUpperLeg | Bone::LeftLowerLeg => Some(-self.up),
            // The toes are lower than the ankle.
            Bone::LeftFoot => Some((self.forward - 0.4 * self.up).normalize()),
            Bone::LeftThumbMetacarpal | Bone::LeftThumbProximal | Bone::LeftThumbDistal => {
                Some((outwards + self.forward).normalize())
            }
            _ => Some(outwards),
        }
    }

    /// The rotation that brings both hip joints to left and right, and the spine above them.
    fn hips(&self, pose: &Pose, joint: &impl Fn(Bone) -> Option<NodeId>) -> Option<Quat> {
        let at = |bone| joint(bone).map(|node| pose.position(node));
        let left = (at(Bone::LeftUpperLeg)? - at(Bone::RightUpperLeg)?).try_normalize()?;
        let above = at(Bone::Spine).or(at(Bone::Neck)).or(at(Bone::Head))?;
        let spine = above - 0.5 * (at(Bone::LeftUpperLeg)? + at(Bone::RightUpperLeg)?);
        let up = (spine - spine.project_onto_normalized(left)).try_normalize()?;
        let from = Mat3::from_cols(left, up, left.cross(up));
        let to = Mat3::from_cols(self.left, self.up, self.left.cross(self.up));
        // The axes of a figure with a twisted rest pose may not be at right angles.
        Some(Quat::from_mat3(&(to * from.transpose())).normalize())
    }

    /// The rotation about the up axis that brings the shoulders of a joint of the spine to left and right.
    fn shoulders(
        &self,
        scene: &Scene,
        pose: &Pose,
        node: NodeId,
        joint: &impl Fn(Bone) -> Option<NodeId>,
    ) -> Option<Quat> {
        // In a rest pose that does not stand, collar bones may have any rotation. But their joints are on the trunk.
        let collars = joint(Bone::LeftShoulder).zip(joint(Bone::RightShoulder));
        let apart = collars.filter(|(left, right)| pose.position(*left).distance(pose.position(*right)) > 1e-6);
        let (left, right) = apart.or_else(|| joint(Bone::LeftUpperArm).zip(joint(Bone::RightUpperArm)))?;
        let parent = |node: &NodeId| scene.nodes[node.index()].parent;
        if !std::iter::successors(Some(left), parent).any(|above| above == node) {
            return None;
        }
        let across = pose.position(left) - pose.position(right);
        let flat = (across - across.project_onto_normalized(self.up)).try_normalize()?;
        let angle = flat.cross(self.left).dot(self.up).atan2(flat.dot(self.left));
        Some(Quat::from_axis_angle(self.up, angle))
    }
}
