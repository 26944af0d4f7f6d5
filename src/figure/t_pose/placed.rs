//! Places the T-pose in the scene, and lowers its arms for an A-pose.

use glam::{Mat4, Quat, Vec3};
use mocap_scene::pose::Pose;
use mocap_scene::scene::{Assumption, HumanoidBone as Bone, NodeId, Scene, Side, Topic};

use super::{TPose, TPoseSource};
use crate::Figure;

impl TPose {
    /// The T-pose with its arms lowered by an angle in degrees. 45 degrees give an A-pose.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::figure::{Figure, HumanoidBone};
    ///
    /// let scene = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// let figure = Figure::new(&scene);
    /// let t_pose = figure.t_pose(&scene).unwrap();
    /// let a_pose = t_pose.with_lowered_arms(&scene, 45.0);
    /// let at = |bone| a_pose.position(t_pose.bones[&bone].joint);
    /// let arm = (at(HumanoidBone::LeftHand) - at(HumanoidBone::LeftUpperArm)).normalize();
    /// assert!((arm.x - 0.5_f32.sqrt()).abs() < 1e-3 && (arm.y + 0.5_f32.sqrt()).abs() < 1e-3);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn with_lowered_arms(&self, scene: &Scene, degrees: f32) -> Pose {
        let mut pose = self.pose.clone();
        for side in [Side::Left, Side::Right] {
            let Some(arm) = self.bones.get(&Bone::LeftUpperArm.on(side)) else {
                continue;
            };
            let angle = if side == Side::Left { -degrees } else { degrees };
            let about = Quat::from_axis_angle(self.axes * Vec3::Z, angle.to_radians());
            let at = pose.position(arm.joint);
            let rotation = Mat4::from_quat(about);
            let moved = Mat4::from_translation(at) * rotation * Mat4::from_translation(-at);
            set_world(&mut pose, scene, arm.joint, |node_to_world| moved * node_to_world);
        }
        pose
    }

    /// The source of the T-pose and the confidence in it, as an assumption for outputs with the T-pose.
    pub(crate) fn assumption(&self) -> Assumption {
        let is_limb = |bone: Bone| matches!(bone.on(Side::Left), Bone::LeftUpperArm | Bone::LeftUpperLeg);
        let limbs = self.bones.iter().filter(|(bone, _)| is_limb(**bone));
        let confidence = limbs
            .map(|(_, found)| found.confidence)
            .max_by_key(|confidence| *confidence as u8);
        let source = match self.source {
            TPoseSource::RestPose => "the T-pose is made from the rest pose",
            TPoseSource::FirstFrame => "the T-pose is made from the first frame, which is a T-pose",
            TPoseSource::Computed => "the T-pose is made from the bones, and from their bending axes in the motion",
        };
        Assumption {
            topic: Topic::RestPose,
            choice: "t-pose".to_owned(),
            reason: source.to_owned(),
            confidence,
        }
    }

    /// Moves a pose of this figure so that its hips have their position in the rest pose.
    pub(crate) fn at_rest(&self, scene: &Scene, mut pose: Pose) -> Pose {
        let Some(hips) = self.bones.get(&Bone::Hips) else {
            return pose;
        };
        let offset = Pose::rest(scene).position(hips.joint) - pose.position(hips.joint);
        move_by(&mut pose, scene, hips.joint, offset);
        pose
    }

    /// Moves the T-pose to the floor of the motion, below the first frame of an animation.
    pub(crate) fn on_floor(&self, scene: &Scene, figure: &Figure, animation: usize) -> Pose {
        let mut pose = self.pose.clone();
        let (Some(hips), Some(first)) = (self.bones.get(&Bone::Hips), Pose::at_tick(scene, animation, 0.0)) else {
            return pose;
        };
        let up = self.axes * Vec3::Y;
        let offset = first.position(hips.joint) - pose.position(hips.joint);
        let feet = [Bone::LeftFoot, Bone::RightFoot, Bone::LeftToes, Bone::RightToes].into_iter();
        let heights = feet.filter_map(|foot| Some(pose.position(self.bones.get(&foot)?.joint).dot(up)));
        let height = match heights.reduce(f32::min).zip(figure.ground_of(scene)) {
            Some((lowest, ground)) => ground.joints() - lowest,
            None => offset.dot(up),
        };
        move_by(
            &mut pose,
            scene,
            hips.joint,
            offset.reject_from_normalized(up) + height * up,
        );
        pose
    }
}

fn move_by(pose: &mut Pose, scene: &Scene, hips: NodeId, offset: Vec3) {
    if offset.is_finite() && offset != Vec3::ZERO {
        set_world(pose, scene, hips, |node_to_world| {
            Mat4::from_translation(offset) * node_to_world
        });
    }
}

/// Moves a node with all its descendants.
fn set_world(pose: &mut Pose, scene: &Scene, node: NodeId, moved: impl Fn(Mat4) -> Mat4) {
    let parent = scene.nodes[node.index()].parent;
    let parent_to_world = parent.map_or(Mat4::IDENTITY, |parent| pose.node_to_world[parent.index()]);
    let node_to_parent = parent_to_world.inverse() * moved(pose.node_to_world[node.index()]);
    if node_to_parent.is_finite() {
        pose.node_to_parent[node.index()] = node_to_parent;
        pose.update_world();
    }
}
