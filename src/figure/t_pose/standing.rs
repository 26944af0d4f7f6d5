//! The pose from which the T-pose is made: a figure that stands.

use glam::{Mat3, Mat4, Quat, Vec3};

use super::TPoseSource;
use crate::figure::axis::{Axis, RestPose};
use crate::figure::humanoid::Humanoid;
use crate::figure::measure::Measures;
use crate::pose::Pose;
use crate::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

/// The rest pose where `stands`; else the first frame of the motion if that is a T-pose; else a figure whose bones are
/// turned to where they point in one.
pub(super) fn reference(
    scene: &Scene,
    humanoid: &Humanoid,
    up: Axis,
    figure_to_world: &Mat3,
    stands: bool,
) -> (TPoseSource, Pose) {
    let rest = Pose::rest(scene);
    if stands {
        return (TPoseSource::RestPose, rest);
    }
    if let Some(first) = Pose::at_tick(scene, 0, 0.0) {
        let positions = (0..scene.nodes.len()).map(|node| first.position(NodeId::new(node)));
        let figure = Measures::with_places(scene, humanoid, positions.collect());
        if figure.rest_pose(up).value == RestPose::TPose {
            return (TPoseSource::FirstFrame, first);
        }
    }
    (TPoseSource::Computed, computed(scene, figure_to_world, humanoid, rest))
}

/// Turns each bone, from the hips outwards, to where it points in T-pose.
fn computed(scene: &Scene, figure_to_world: &Mat3, humanoid: &Humanoid, rest: Pose) -> Pose {
    let axes = Axes::new(figure_to_world);
    let joint = |bone: Bone| humanoid.joint(bone);
    let mut pose = rest;
    for &bone in Bone::ALL {
        let Some(node) = joint(bone) else { continue };
        let rotation = match bone {
            Bone::Hips => axes.hips(&pose, &joint),
            _ => next_of(scene, bone, node, &joint).and_then(|next| {
                let way = (pose.position(next) - pose.position(node)).try_normalize()?;
                Some(Quat::from_rotation_arc(way, axes.direction(bone)?))
            }),
        };
        let rotation = rotation.filter(|rotation| rotation.is_finite());
        turn(&mut pose, scene, node, rotation.unwrap_or(Quat::IDENTITY));
        if matches!(bone, Bone::Spine | Bone::Chest | Bone::UpperChest)
            && let Some(about) = axes.shoulders(scene, &pose, node, &joint)
        {
            turn(&mut pose, scene, node, about);
        }
    }
    pose
}

/// Turns a node about its place in the world, with all below it.
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

/// The node that shows where a bone points: the next bone, else the child of its joint.
fn next_of(scene: &Scene, bone: Bone, node: NodeId, joint: &impl Fn(Bone) -> Option<NodeId>) -> Option<NodeId> {
    let side = bone.side().unwrap_or(Side::Left);
    let candidates: &[Bone] = match bone {
        Bone::Spine => &[Bone::Chest, Bone::UpperChest, Bone::Neck, Bone::Head],
        Bone::Chest => &[Bone::UpperChest, Bone::Neck, Bone::Head],
        Bone::UpperChest => &[Bone::Neck, Bone::Head],
        Bone::LeftHand | Bone::RightHand => &[Bone::LeftMiddleProximal, Bone::LeftIndexProximal],
        _ => &[],
    };
    let hangs_on = |child: &NodeId| {
        let parent = |node: &NodeId| scene.nodes[node.index()].parent;
        std::iter::successors(parent(child), parent).any(|above| above == node)
    };
    let listed = candidates.iter().map(|candidate| candidate.on(side));
    let below = Bone::ALL.iter().copied().filter(|other| {
        candidates.is_empty() && other.parent() == Some(bone) && !other.as_str().contains("Eye") && *other != Bone::Jaw
    });
    let next = listed.chain(below).filter_map(joint).find(hangs_on);
    // A skeleton whose root is the head has the next bone above.
    let carries_a_bone = Bone::ALL
        .iter()
        .filter_map(|other| joint(*other))
        .any(|other| hangs_on(&other));
    if next.is_none() && carries_a_bone {
        return None;
    }
    next.or_else(|| {
        let is_child = |index: &usize| scene.nodes[*index].parent == Some(node);
        let mut children = (node.index() + 1..scene.nodes.len()).filter(is_child).map(NodeId::new);
        children.next()
    })
}

/// Left, up and forward of a figure that stands.
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

    /// Where a bone points in T-pose; `None` for those that stay as they are.
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

    /// The rotation that brings both hip joints to left and right and the spine above them.
    fn hips(&self, pose: &Pose, joint: &impl Fn(Bone) -> Option<NodeId>) -> Option<Quat> {
        let at = |bone| joint(bone).map(|node| pose.position(node));
        let left = (at(Bone::LeftUpperLeg)? - at(Bone::RightUpperLeg)?).try_normalize()?;
        let above = at(Bone::Spine).or(at(Bone::Neck)).or(at(Bone::Head))?;
        let spine = above - 0.5 * (at(Bone::LeftUpperLeg)? + at(Bone::RightUpperLeg)?);
        let up = (spine - spine.project_onto_normalized(left)).try_normalize()?;
        let from = Mat3::from_cols(left, up, left.cross(up));
        let to = Mat3::from_cols(self.left, self.up, self.left.cross(self.up));
        Some(Quat::from_mat3(&(to * from.transpose())))
    }

    /// The rotation about the up axis that brings the shoulders of a joint of the spine to left and right.
    fn shoulders(
        &self,
        scene: &Scene,
        pose: &Pose,
        node: NodeId,
        joint: &impl Fn(Bone) -> Option<NodeId>,
    ) -> Option<Quat> {
        let (left, right) = (joint(Bone::LeftUpperArm)?, joint(Bone::RightUpperArm)?);
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
