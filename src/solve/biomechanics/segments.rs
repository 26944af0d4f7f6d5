//! The anatomical axes of the body's segments, frame by frame.
//!
//! The axes follow the International Society of Biomechanics, for a body that stands with hanging arms and palms
//! forward: +X forward, +Y up, +Z to the right. In the T-pose of a [`Figure`], the trunk and the legs have this pose.
//! The arms are abducted by 90 degrees, and the forearms, with the palms down, are pronated by 90 degrees.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, Quat, Vec3};

use mocap_figure::Figure;
use mocap_figure::body::Body;
use mocap_figure::contacts::ball;
use mocap_figure::convert::Conversion;
use mocap_figure::joint_angles::{Part, Segment, mirrored, parts};
use mocap_figure::track::{Track, whole};
use mocap_figure::watched::{WatchedJoints, WatchedPose};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, Pose};
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

/// The segments of a body over its motion. World axes are laboratory axes: +X is the facing direction of the T-pose, +Y
/// is up, +Z is to the right.
pub(super) struct Segments {
    pub(super) frame_rate: f64,
    pub(super) frames: usize,
    /// Rotations to the world. Left segments are mirrored, so that one calculation serves both sides.
    rotations: BTreeMap<Part, Vec<DQuat>>,
    /// Positions in metres of the pelvis, the ankles and the balls of the feet.
    pub(super) pelvis: Vec<DVec3>,
    pub(super) ankles: [Vec<DVec3>; 2],
    pub(super) balls: [Vec<DVec3>; 2],
    /// The length from hip to ankle along the bones, in metres.
    pub(super) leg: f64,
}

impl Segments {
    /// The segments in the first animation of the scene in which the figure was found, in any unit and with any up
    /// axis.
    ///
    /// # Errors
    /// [`Code::NotHumanoid`] and [`Code::NoMotion`].
    pub(super) fn of(scene: &Scene, figure: &Figure) -> Result<Self> {
        let mut scene = scene.clone();
        scene.animations.truncate(1);
        let (figure, _) = Conversion::new().apply_to(&mut scene, figure)?;
        let Some(animation) = scene.animations.first() else {
            return Err(Diagnostic::new(Code::NoMotion, "there is no motion to compute angles from").into());
        };
        let body = Body::of_figure(&scene, figure, "motion")?;
        let mut watched = WatchedJoints::default();
        let tracks: Vec<(Part, Track)> = parts()
            .filter_map(|part| Some((part, whole(&body, bone(&body, part)?, &mut watched)?)))
            .collect();
        let side_nodes = |node: &dyn Fn(Side) -> Option<NodeId>| [Side::Left, Side::Right].map(node);
        let ankles = side_nodes(&|side| body.joint(Bone::LeftFoot.on(side)));
        let balls = side_nodes(&|side| ball(&scene, &body.figure.humanoid, side));
        let mut made = Self {
            frame_rate: animation.ticks_per_second,
            frames: animation.frame_count(),
            rotations: tracks.iter().map(|(part, _)| (*part, Vec::new())).collect(),
            pelvis: Vec::new(),
            ankles: Default::default(),
            balls: Default::default(),
            leg: f64::from(body.leg),
        };
        let world_to_t_pose = body.axes.inverse();
        let binding = Binding::new(&scene, animation);
        let mut pose = Pose::rest(&scene);
        let mut seen: WatchedPose<1> = WatchedPose::new(watched.joints.len());
        for tick in 0..made.frames {
            pose.sample(&binding, animation, tick as f64);
            seen.set(0, &pose, &body, &watched);
            for (part, track) in &tracks {
                let rotation = anatomical(*part, Quat::from_array(track.frame(&seen).lane(0)));
                made.rotations.entry(*part).or_default().push(rotation);
            }
            let position = |node: NodeId| laboratory(world_to_t_pose * pose.position(node));
            made.pelvis.push(position(body.hips));
            for (nodes, positions) in [(ankles, &mut made.ankles), (balls, &mut made.balls)] {
                for (node, positions) in nodes.into_iter().zip(positions) {
                    positions.extend(node.map(position));
                }
            }
        }
        Ok(made)
    }

    /// The rotation of a segment relative to another in every frame; `None` if the body lacks one of them.
    pub(super) fn between(&self, above: Part, below: Part) -> Option<impl Iterator<Item = DQuat>> {
        let (above_rotations, below_rotations) = (self.rotations.get(&above)?, self.rotations.get(&below)?);
        let is_mirrored = above.1.is_none() && below.1 == Some(Side::Left);
        Some(above_rotations.iter().zip(below_rotations).map(move |(above, below)| {
            let above = if is_mirrored { mirrored(*above) } else { *above };
            above.inverse() * *below
        }))
    }

    /// The rotation of a trunk segment relative to the laboratory in every frame.
    pub(super) fn to_world(&self, segment: Segment) -> Option<&[DQuat]> {
        Some(self.rotations.get(&(segment, None))?)
    }
}

/// The bone of a segment.
fn bone(body: &Body, (segment, side): Part) -> Option<Bone> {
    let bones = segment.bones().iter().copied();
    let mut bones = bones.map(|bone| side.map_or(bone, |side| bone.on(side)));
    bones.find(|bone| body.joint(*bone).is_some())
}

/// The rotation of a segment's anatomical axes to the laboratory, from its rotation relative to the T-pose. Left
/// segments are mirrored.
fn anatomical((segment, side): Part, rotation: Quat) -> DQuat {
    let DQuat { x, y, z, w } = rotation.as_dquat().normalize();
    let rotation = DQuat::from_xyzw(z, y, -x, w);
    let rotation = if side == Some(Side::Left) {
        mirrored(rotation)
    } else {
        rotation
    };
    rotation * segment.to_t_pose()
}

/// Converts a vector from the axes of the T-pose, +X left and +Z forward, to the laboratory axes.
fn laboratory(vector: Vec3) -> DVec3 {
    let Vec3 { x, y, z } = vector;
    DVec3::new(z.into(), y.into(), f64::from(-x))
}
