//! Converts a scene of a robot's links to a motion of the robot: the reverse of
//! [`robot_clip`](mocap_figure::robot_clip).

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec3};
use mocap_edit::contacts_of;
use mocap_figure::Figure;
use mocap_figure::robot_bones::moving::{nodes_of_links, scene_of_clips};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::pose::{Binding, Trs};
use mocap_scene::scene::robot::{JointKind, Placement, Robot, RobotJoint};
use mocap_scene::scene::{Animation, Scene, UpAxis};

use super::motion::RobotMotion;
use super::retargeter::feet_at_rest;

/// The largest part of a rotation that is not about the axis of the joint, as the vector of a unit quaternion. It is
/// above the rounding of a scene, and too small to be visible.
const OFF_AXIS: f64 = 1e-3;

/// The largest difference of the rest poses of one robot, in metres and as a part of a rotation: the rounding of a
/// scene.
const SAME_REST: f32 = 1e-4;

impl RobotMotion {
    /// The motion in a scene that was read from arrays of the robot's joints, with the robot as its body.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    /// use mocap::retarget::robot::RobotMotion;
    ///
    /// let g1 = "fixtures/robots/g1_29dof_rev_1_0.urdf";
    /// let scene = Importer::new().body(g1).import("fixtures/arrays/asap_joblib.pkl")?;
    /// let motion = RobotMotion::of_arrays(&Importer::new().import_robot(g1)?, &scene)?;
    /// assert_eq!((motion.name.as_str(), motion.dof_names.len()), ("asap_joblib", 29));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the scene is from another kind of file. [`Code::NoMotion`] if it has no motion.
    /// [`Code::Unrepresentable`] if it has the motion of another robot.
    pub fn of_arrays(robot: &Robot, scene: &Scene) -> Result<Self> {
        if scene.metadata.up != Some(UpAxis::Z) {
            let message = "the file has no arrays of a robot's joints, which are compared with the reference";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let mut motion = Self::of_scene(robot, scene)?;
        if let Some(origin) = &scene.metadata.origin {
            origin.stem().clone_into(&mut motion.name);
        }
        Ok(motion)
    }

    /// The motion of a robot whose links are the nodes of `scene`, as written by the reader of robot joints.
    ///
    /// # Errors
    /// [`Code::NoMotion`] if the scene has no motion. [`Code::Unrepresentable`] if the nodes are not the links of the
    /// robot, or a link rotates about an axis other than the axis of its joint.
    #[doc(hidden)]
    pub fn of_scene(robot: &Robot, scene: &Scene) -> Result<Self> {
        let Some(animation) = scene.animations.first() else {
            return Err(Diagnostic::new(Code::NoMotion, "the file contains no motion").into());
        };
        let mut motion = Self::of_clip(robot, scene, animation, DQuat::IDENTITY)?;
        if let Ok(found) = contacts_of(scene, animation, &Figure::new(scene)) {
            motion.contacts = feet_at_rest(&found, motion.frames());
        }
        Ok(motion)
    }

    /// The motion of a scene in metres in which `robot` itself moves; `None` if another body moves.
    pub(super) fn of_same_robot(robot: &Robot, scene: &Scene, animation: &Animation) -> Option<Self> {
        let own = scene_of_clips(robot, Vec::new());
        if own.nodes.len() != scene.nodes.len() {
            return None;
        }
        let links = std::iter::zip(&own.nodes, &scene.nodes).skip(1);
        let is_alike = links
            .map(|(link, node)| (link.transform, node.transform))
            .all(|(link, node)| link.abs_diff_eq(node, SAME_REST));
        if !is_alike {
            return None;
        }
        Self::of_clip(robot, scene, animation, world_of_robot(scene)?).ok()
    }

    /// Converts an animation of a scene of the robot's links. `to_world` rotates its axes to +Z up.
    fn of_clip(robot: &Robot, scene: &Scene, animation: &Animation, to_world: DQuat) -> Result<Self> {
        let nodes = nodes_of_links(robot, scene)
            .ok_or_else(|| not_of(format!("its joints are not the links of {}", robot.name)))?;
        let (frames, joints) = (animation.frame_count(), robot.moving_joints());
        let rest: Vec<Trs> = scene
            .nodes
            .iter()
            .map(|node| Trs::from_matrix(node.transform))
            .collect();
        let base = robot.links[0].joint.link_to_parent(0.0);
        let begin = base.to_inner(to_world * rest[0].translation.as_dvec3());
        let mut motion = Self {
            name: animation.name.clone(),
            fps: animation.ticks_per_second,
            dof_names: robot.dof_names(),
            root: Vec::with_capacity(frames),
            dof_pos: Vec::with_capacity(frames * joints.len()),
            contacts: vec![[false; 2]; frames],
            hind_contacts: Vec::new(),
        };
        let binding = Binding::new(scene, animation);
        for frame in 0..frames {
            let mut links = rest.clone();
            binding.sample(animation, frame as f64, |node, trs| links[node.index()] = trs);
            let rotation = (to_world * links[0].rotation.as_dquat()).normalize();
            let translation = to_world * links[0].translation.as_dvec3() - rotation * begin;
            motion.root.push(Placement { rotation, translation });
            for (dof, &link) in joints.iter().enumerate() {
                let joint = &robot.links[link].joint;
                let before = frame.checked_sub(1).map(|before| motion.dof_of(before)[dof]);
                let node = nodes[link];
                let moved = (links[node].translation - rest[node].translation).as_dvec3();
                let position = position(joint, links[node].rotation.as_dquat(), moved, before.unwrap_or(0.0));
                motion.dof_pos.push(position.ok_or_else(|| off_axis(joint, frame))?);
            }
        }
        Ok(motion)
    }
}

/// The rotation from the axes of a scene in which a robot moves to the robot's axes, with +Z up.
pub(super) fn world_of_robot(scene: &Scene) -> Option<DQuat> {
    match scene.metadata.up? {
        UpAxis::Z => Some(DQuat::IDENTITY),
        UpAxis::Y => Some(DQuat::from_rotation_x(FRAC_PI_2)),
        UpAxis::NegY | UpAxis::NegZ => None,
    }
}

/// The position of a joint whose link has this rotation relative to its parent, and this displacement from its
/// placement at 0. Angles may differ by full turns; the angle nearest to `before` is returned. `None` if the joint
/// cannot have this rotation.
fn position(joint: &RobotJoint, rotation: DQuat, moved: DVec3, before: f64) -> Option<f64> {
    if joint.kind == JointKind::Slide {
        return Some(moved.dot(joint.origin.rotation * joint.axis));
    }
    let turn = (joint.origin.rotation.inverse() * rotation).normalize();
    let vector = DVec3::new(turn.x, turn.y, turn.z);
    let along = vector.dot(joint.axis);
    if (vector - along * joint.axis).length() > OFF_AXIS {
        return None;
    }
    let angle = 2.0 * along.atan2(turn.w);
    Some(angle + TAU * ((before - angle) / TAU).round())
}

fn off_axis(joint: &RobotJoint, frame: usize) -> Error {
    not_of(format!(
        "the link of joint {:?} rotates about another axis than the joint's axis in frame {frame}",
        joint.name
    ))
}

fn not_of(message: String) -> Error {
    Diagnostic::new(
        Code::Unrepresentable,
        format!("the motion is not the motion of this robot: {message}"),
    )
    .help("retarget the motion to the robot")
    .into()
}
