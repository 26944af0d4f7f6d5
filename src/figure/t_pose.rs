//! Computes the T-pose of a humanoid. In the T-pose, the figure faces forward, with its arms to the sides and its legs
//! down. Each figure has one T-pose, and all commands use this code for it.
//!
//! The T-pose is made in three steps. First, the *reference pose* is a standing figure. It is the rest pose if the
//! figure stands in its rest pose. Otherwise it is the first frame if this is a T-pose, or else a pose that is computed
//! from the bones (`standing`). Second, each bone is rotated from the reference pose to its T-pose (`builder`). Third,
//! feet, head and shoulders are levelled by the motion (`level`). `docs/retargeting-algorithm.md` explains what each
//! bone keeps.

mod builder;
mod level;
mod placed;
mod pointing;
mod stance;
mod standing;

use std::collections::BTreeMap;

use glam::{Quat, Vec3};
use mocap_scene::math::directions::rotation_of;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{Confidence, Format, HumanoidBone as Bone, NodeId, Scene};
use serde::Serialize;

use self::builder::Builder;
pub use self::pointing::direction;
pub use self::pointing::limb_end;
pub(crate) use self::pointing::next;
use super::Figure;
use super::axes::Shown;
use super::axis::{Axis, RestPose};
use super::hierarchy::Hierarchy;
use super::knuckles::Knuckles;

/// The pose from which a T-pose is made.
///
/// [`TPose`](crate::TPose) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum TPoseSource {
    /// The rest pose. The figure stands in it with its arms to the sides, down or between.
    RestPose,
    /// The first frame of the motion, which is a T-pose.
    FirstFrame,
    /// A pose that is computed from the bones. Nothing in the file shows the roll of the bones.
    Computed,
}

/// The reason for a bone's rotation in a T-pose.
///
/// [`TPose`](crate::TPose) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum TPoseReason {
    /// The bone keeps its rotation in the reference pose.
    Stands,
    /// The bone gets the shortest rotation to its direction in a T-pose.
    ShortestArc,
    /// The foot stands on its sole, and is rotated about the up axis to point forward.
    OnItsSole,
    /// The foot has the pitch and the roll that it has during contacts in the motion.
    StandsInMotion,
    /// The bone has its average rotation relative to the chest in the motion.
    AverageOfMotion,
    /// The hand has its direction in a T-pose. The knuckles determine the roll that turns the palm down.
    Knuckles,
    /// The bone has its direction in a T-pose. Its roll makes the knee or the elbow bend as in the motion: a shin bends
    /// back, a forearm forward.
    Hinge,
    /// The knee or the elbow of the bone bends as in the motion. But the hinge of the other side is not the mirror
    /// image of this hinge.
    HingeUnlikeOtherSide,
    /// The bone never bends, and gets the mirrored hinge of the other side.
    OtherSide,
    /// The bone follows its parent bone.
    FollowsTheBoneAbove,
}

impl TPoseReason {
    /// The reason as one phrase.
    ///
    /// ```
    /// use mocap::figure::report::TPoseReason;
    ///
    /// assert_eq!(TPoseReason::ShortestArc.as_str(), "by the shortest rotation to its direction");
    /// ```
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Stands => "as in the reference pose",
            Self::ShortestArc => "by the shortest rotation to its direction",
            Self::OnItsSole => "as it stands on its sole, rotated forward",
            Self::StandsInMotion => "as it stands in the motion",
            Self::AverageOfMotion => "as in the average of the motion",
            Self::Knuckles => "by the knuckles, with the palm down",
            Self::Hinge => "by its bending axis in the motion",
            Self::HingeUnlikeOtherSide => "by its bending axis in the motion, unlike the other side",
            Self::OtherSide => "by the mirrored bending axis of the other side",
            Self::FollowsTheBoneAbove => "with its parent bone",
        }
    }
}

/// A bone in the T-pose.
///
/// [`TPose`](crate::TPose) has an example.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TPoseBone {
    /// The joint of the bone.
    pub joint: NodeId,
    /// The world rotation about the joint that brings the bone from the rest pose to the T-pose, after the rotations of
    /// its ancestors.
    pub rotation: Quat,
    /// The confidence in the roll of the bone. Its direction is certain.
    pub confidence: Confidence,
    /// The reason for the rotation.
    pub reason: TPoseReason,
    /// The world rotation from the reference pose to the T-pose.
    reference_to_t_pose: Quat,
}

/// A humanoid in the T-pose: [`Figure::t_pose`].
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::figure::{Figure, HumanoidBone};
///
/// let scene = mocap::import("fixtures/real/rokoko_dance.bvh")?; // at rest every bone lies along +X or +Y
/// let figure = Figure::new(&scene);
/// let t_pose = figure.t_pose(&scene).unwrap();
/// let at = |bone| t_pose.pose.position(t_pose.bones[&bone].joint);
/// let arm = at(HumanoidBone::LeftHand) - at(HumanoidBone::LeftUpperArm);
/// assert!(arm.normalize().x > 0.999);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TPose {
    /// The pose from which it is made.
    pub source: TPoseSource,
    /// Every node of the scene in the T-pose. Joints that are not bones move with the nearest ancestor bone.
    pub pose: Pose,
    /// The bones. Left and right are the sides of the body, even if the names contradict them.
    pub bones: BTreeMap<Bone, TPoseBone>,
    /// The rotation from the T-pose's coordinate frame (+X left, +Y up, +Z forward) to the world.
    pub(crate) axes: Quat,
    /// The joints in the reference pose.
    pub(crate) positions: Vec<Vec3>,
    /// The world rotations of the joints in the reference pose.
    pub(crate) rotations: Vec<Quat>,
    /// The number of frames in the motions that show the roll of bones.
    pub(crate) frames: usize,
}

impl TPose {
    /// The T-pose of `figure`, the figure of `scene`; `None` if it is not a humanoid.
    pub(super) fn new(scene: &Scene, figure: &Figure) -> Option<Self> {
        if !figure.humanoid.found {
            return None;
        }
        let humanoid = figure.humanoid.clone().with_sides_of_the_body();
        let rest_pose = figure.rest_pose.value;
        // Without a motion, a standing rest pose is the best evidence, even if its arms or knees are not as in a
        // T-pose.
        let stands = match rest_pose {
            RestPose::TPose | RestPose::APose | RestPose::IPose => true,
            // The rest pose of a solved skeleton is a T-pose, also if the body has no arms.
            _ if scene.metadata.solved.is_some() => true,
            _ => scene.animations.is_empty() && figure.facing.value != Axis::Unknown,
        };
        let axes = figure.figure_to_world();
        let hierarchy = Hierarchy::new(scene);
        let bones = humanoid.bones.iter().map(|(bone, joint)| (*bone, joint.joint));
        let bones = bones.collect();
        let knuckles = Knuckles::new(scene, &hierarchy, &bones);
        // A rest pose that stands shows the roll of bones.
        let shown = (!stands).then(|| Shown::new(scene, &hierarchy, &bones, &knuckles, axes.y_axis));
        let sources = standing::Sources {
            humanoid: &humanoid,
            knuckles: &knuckles,
            shown: shown.as_ref(),
        };
        let (source, reference) = standing::reference(scene, &sources, figure.up.value, &axes);
        // The rest pose of a VRM animation is the T-pose by definition.
        let is_t_pose = scene.metadata.format == Some(Format::Vrma) && rest_pose == RestPose::TPose;
        let mut builder = Builder {
            source,
            is_t_pose,
            knuckles,
            axes: Quat::from_mat3(&axes).normalize(),
            bones,
            hierarchy,
            shown,
            positions: (0..scene.nodes.len())
                .map(|node| reference.position(NodeId::new(node)))
                .collect(),
            rotations: reference.node_to_world.iter().map(rotation_of).collect(),
            to_t_pose: BTreeMap::new(),
        };
        builder.turn_bones(&axes);
        if scene.metadata.format != Some(Format::Vrma) {
            builder.level(scene);
        }
        Some(builder.finish(scene, &reference))
    }

    /// The largest rotation of a bone from the rest pose to the T-pose, in addition to the rotations of its ancestors,
    /// in degrees.
    pub fn largest_rotation(&self) -> f32 {
        let angles = self.bones.values().map(|bone| Self::degrees(bone.rotation));
        angles.fold(0.0, f32::max)
    }

    /// The angle of a rotation, in degrees.
    pub fn degrees(rotation: Quat) -> f32 {
        // For small angles the cosine is too coarse.
        let sine = Vec3::new(rotation.x, rotation.y, rotation.z).length();
        2.0 * sine.atan2(rotation.w.abs()).to_degrees()
    }

    /// The rotation of a bone from the reference pose to the T-pose.
    pub(crate) fn reference_to_t_pose(&self, bone: Bone) -> Quat {
        self.bones
            .get(&bone)
            .map_or(Quat::IDENTITY, |bone| bone.reference_to_t_pose)
    }

    /// The rotation from the coordinate frame of `bone` to a joint that moves with it: the joint's rotation in the
    /// T-pose.
    pub(crate) fn frame_to_joint(&self, bone: Bone, joint: NodeId) -> Quat {
        (self.axes.inverse() * self.reference_to_t_pose(bone) * self.rotations[joint.index()]).normalize()
    }
}
