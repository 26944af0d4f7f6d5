//! Solves joint rotations from positions: a skeleton whose joints follow points, frame by frame.
//!
//! A [`JointSet`] states the joints. Each joint has a parent, a bone, and the points from which its position is known.
//! The solver then works in three steps:
//!
//! 1. It fills gaps in the points by linear interpolation, and reports the gaps.
//! 2. It computes [`Lengths`]: medians over the frames, so that a few bad frames change nothing, or the lengths of each
//!    frame.
//! 3. It rotates the joints from the root outwards.
//!
//! The joints get their rotations as follows:
//!
//! - Hips and chest are fitted to the line across the body and the line up.
//! - A limb points exactly at its child. The hinge at its end determines its roll: a knee bends so that the shin goes
//!   back, an elbow so that the forearm goes forward with palms down. While a limb is too straight to show its roll,
//!   the roll is interpolated between the known values, relative to axes with minimal twist.
//! - The joints of the spine share the twist between hips and chest.
//! - All other joints twist as little as they can.
//!
//! The rest pose is a T-pose without rotations, facing +Z, as the rest pose of VRM and of SMPL.

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

pub mod biomechanics;
#[doc(hidden)]
pub mod internals;
#[doc(hidden)]
pub mod markers;
mod mhr70;
mod points;
mod rest;
mod roll;
mod rules;
mod set;
mod turn;

use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::math::up_axis::to_y_up;
use mocap_scene::scene::{Animation, Assumption, Channel, Confidence, Keys, Node, NodeId, Scene, Topic, UpAxis};

pub use self::markers::MarkerWeights;
use self::points::Points;
use self::rest::Rest;
pub use self::set::{JointSet, Lengths};

impl JointSet {
    /// Replaces the points of `scene` with a skeleton that has rotations. The scene keeps its name, its rate and its
    /// unit. The set determines the joints. +Y becomes up: up is the average direction of the spine.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::solve::JointSet;
    ///
    /// let mut scene = mocap::import("fixtures/real/hand_take.c3d")?;
    /// let set = r#"[{"name": "hips", "bone": "hips", "points": ["no such marker"]}]"#;
    /// let error = JointSet::from_json("my joints", set)?.solve(&mut scene).unwrap_err();
    /// assert!(error.to_string().contains("missing: no such marker"));
    /// // Readers do it where the joints are named, and for arrays with the joints of SMPL.
    /// let scene = mocap::import("fixtures/arrays/points_smpl22.npy")?;
    /// assert!(scene.animations[0].channels.iter().any(|channel| channel.rotation_keys.len() > 1));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::NoMotion`]: there is no motion.
    /// - [`Code::InvalidValue`]: the scene does not have the points of the set.
    /// - [`Code::NumberRange`]: positions are too far apart to compute with.
    pub fn solve(&self, scene: &mut Scene) -> Result<()> {
        let mut points = Points::of_scene(scene, self)?;
        let up = points.up(self);
        points.turn(up);
        let rules = rules::Rules::new(self, &points);
        let (rest, rotations) = turn::turn(self, &rules, &points);
        check_finite(self, &rotations)?;
        // The reader already warned about the gaps of each point.
        scene.warnings.retain(|warning| warning.code != Code::Gap);
        scene.warnings.append(&mut points.warnings);
        let lengths = match self.lengths {
            Lengths::Median => "lengths are medians",
            Lengths::Moving => "lengths are taken from each frame",
        };
        write(scene, self, &points, &rest, rotations, up, lengths);
        Ok(())
    }
}

/// Products of distances may exceed the range of 32-bit numbers.
fn check_finite(set: &JointSet, rotations: &[Vec<Quat>]) -> Result<()> {
    for (joint, rotations) in set.joints.iter().zip(rotations) {
        if let Some(frame) = rotations.iter().position(|rotation| !rotation.is_finite()) {
            let message = format!("the joints are too far apart in frame {frame} to solve rotations");
            return Err(Diagnostic::new(Code::NumberRange, message)
                .in_joint(&joint.name)
                .help("correct the positions in that frame, or remove the frame")
                .into());
        }
    }
    Ok(())
}

/// Replaces nodes and keys. `lengths` describes how bone lengths were computed.
fn write(
    scene: &mut Scene,
    set: &JointSet,
    points: &Points,
    rest: &Rest,
    world: Vec<Vec<Quat>>,
    up: (UpAxis, Confidence),
    lengths: &str,
) {
    let order = set.depth_first();
    let mut ids = vec![None; set.joints.len()];
    let (mut nodes, mut channels) = (Vec::with_capacity(order.len()), Vec::with_capacity(order.len()));
    for &index in &order {
        let joint = &set.joints[index];
        let id = NodeId::new(nodes.len());
        ids[index] = Some(id);
        let offset = rest.offsets[index];
        nodes.push(Node {
            name: joint.name.clone(),
            parent: joint.parent.and_then(|parent| ids[parent]),
            transform: Mat4::from_translation(offset),
            humanoid_bone: joint.bone,
            ..Node::default()
        });
        let mut before = Quat::IDENTITY;
        let local = (0..points.frames).map(|frame| {
            let own = world[index][frame];
            let local = joint
                .parent
                .map_or(own, |parent| world[parent][frame].inverse() * own)
                .normalize();
            before = if local.dot(before) < 0.0 { -local } else { local };
            before
        });
        channels.push(Channel {
            node_name: joint.name.clone(),
            node: Some(id),
            rotation_keys: Keys::every_tick(local.collect()),
            position_keys: match joint.parent {
                None => Keys::every_tick(points.tracks[index].clone()),
                Some(parent) if set.lengths == Lengths::Moving => {
                    let position =
                        |frame: usize| world[parent][frame].inverse() * rest::vector(points, parent, index, frame);
                    Keys::every_tick((0..points.frames).map(position).collect())
                }
                Some(_) => Keys::constant(offset),
            },
            scaling_keys: Keys::constant(Vec3::ONE),
        });
    }
    scene.nodes = nodes;
    scene.meshes.clear();
    if let Some(first) = scene.animations.first_mut() {
        *first = Animation {
            channels,
            ..std::mem::take(first)
        };
    }
    scene.animations.truncate(1);
    scene.metadata.assumptions.retain(|said| said.topic != Topic::Layout);
    let mut assume = |topic: Topic, choice: String, reason: &str, confidence: Option<Confidence>| {
        scene.metadata.assumptions.push(Assumption {
            topic,
            choice,
            reason: reason.to_owned(),
            confidence,
        });
    };
    let choice = format!("rotations are solved from the positions of {}; {lengths}", set.name);
    assume(Topic::Body, choice, "the file has no rotations", None);
    if scene.metadata.up.is_none() && up.0 != UpAxis::Y {
        let choice = format!("{} was up, and is +Y now", up.0.as_str().to_uppercase());
        assume(
            Topic::UpAxis,
            choice,
            "the spine points in this direction on average",
            Some(up.1),
        );
    }
    scene.metadata.up = Some(UpAxis::Y);
}

/// The error for a scene that does not match a set.
fn refused(message: String, expected: String, found: String) -> Diagnostic {
    Diagnostic::new(Code::InvalidValue, message).expected_found(expected, found)
}

/// Rotates a point so that `up` becomes +Y.
fn turned(point: Vec3, up: UpAxis) -> Vec3 {
    to_y_up(point, up)
}
