//! A motion from arrays, and its scene.

use glam::{DQuat, DVec3, Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::quaternion::in_hemisphere_of;
use mocap_scene::math::up_axis::{to_y_up, turn_to_y_up};
use mocap_scene::scene::joint_tables::Joint;
use mocap_scene::scene::{Assumption, Channel, Confidence, Format, Keys, Node, NodeId, Scene, Topic, UpAxis};

use crate::frames::add_animation;
use crate::warnings::Warnings;

/// A motion on a skeleton without rotations in its T-pose.
#[derive(Debug, Default)]
pub(super) struct Motion {
    pub(super) joints: Vec<Joint>,
    /// The joint positions in the T-pose, in metres, +Y up, facing +Z.
    pub(super) rest: Vec<Vec3>,
    pub(super) frame_rate: f64,
    pub(super) up: UpAxis,
    /// The root position in each frame.
    pub(super) root: Vec<DVec3>,
    /// The rotation of each joint relative to its parent: for each joint, a list with one rotation per frame.
    pub(super) rotations: Vec<Vec<DQuat>>,
    pub(super) assumptions: Vec<Assumption>,
}

impl Motion {
    pub(super) fn frames(&self) -> usize {
        self.root.len()
    }

    /// Records a decision about something that the file does not state.
    pub(super) fn assume(
        &mut self,
        topic: Topic,
        choice: impl Into<String>,
        reason: impl Into<String>,
        confidence: Confidence,
    ) {
        self.assumptions.push(Assumption {
            topic,
            choice: choice.into(),
            reason: reason.into(),
            confidence: Some(confidence),
        });
    }

    /// The axis along which the spine points on average. This axis is the up axis if the body stands longer than it
    /// lies.
    pub(super) fn up_of_body(&self) -> (UpAxis, Confidence) {
        /// If the cosine of the mean angle between spine and axis is above this number, the up axis is sure. The angle
        /// is then below 26 degrees.
        const SURE: f64 = 0.9;
        let spines = self
            .rotations
            .first()
            .into_iter()
            .flatten()
            .map(|rotation| *rotation * DVec3::Y);
        let mean = spines.filter(|spine| spine.is_finite()).sum::<DVec3>() / self.frames().max(1) as f64;
        let along = |up: UpAxis| match up {
            UpAxis::Y => mean.y,
            UpAxis::Z => mean.z,
            UpAxis::NegY => -mean.y,
            UpAxis::NegZ => -mean.z,
        };
        let best = UpAxis::ALL
            .into_iter()
            .fold(UpAxis::Y, |best, up| if along(up) > along(best) { up } else { best });
        let confidence = match along(best) {
            SURE.. => Confidence::Sure,
            0.5.. => Confidence::Likely,
            _ => Confidence::Unsure,
        };
        (best, confidence)
    }

    /// The scene, with +Y up and in metres.
    pub(super) fn into_scene(mut self, format: Format, warnings: &mut Warnings) -> Scene {
        self.repair(warnings);
        let mut scene = Scene::default();
        scene.metadata.format = Some(format);
        scene.metadata.metres_per_unit = Some(1.0);
        scene.metadata.up = Some(UpAxis::Y);
        if self.up != UpAxis::Y {
            let choice = format!("{} was up, and is +Y now", named(self.up));
            self.assume(Topic::UpAxis, choice, "scenes of arrays have +Y up", Confidence::Sure);
        }
        scene.metadata.assumptions = std::mem::take(&mut self.assumptions);
        let order = self.depth_first();
        let mut node_of = vec![None; self.joints.len()];
        let mut channels = Vec::with_capacity(order.len());
        for &index in &order {
            let joint = &self.joints[index];
            let id = NodeId::new(scene.nodes.len());
            node_of[index] = Some(id);
            let offset = self.rest[index] - joint.parent.map_or(Vec3::ZERO, |parent| self.rest[parent]);
            scene.nodes.push(Node {
                name: joint.name.clone(),
                parent: joint.parent.and_then(|parent| node_of[parent]),
                transform: Mat4::from_translation(offset),
                humanoid_bone: joint.bone,
                ..Node::default()
            });
            channels.push(self.channel(index, id, offset));
        }
        let frames = (self.frames(), self.frame_rate);
        add_animation(&mut scene, frames, channels, "a skeleton", warnings);
        scene
    }

    fn channel(&self, index: usize, id: NodeId, offset: Vec3) -> Channel {
        let joint = &self.joints[index];
        let is_root = joint.parent.is_none();
        let turn = if is_root {
            turn_to_y_up(self.up)
        } else {
            DQuat::IDENTITY
        };
        let position_keys = match is_root {
            true => {
                let positions = self.root.iter().map(|position| to_y_up(position.as_vec3(), self.up));
                Keys::every_tick(positions.collect())
            }
            false => Keys::constant(offset),
        };
        let mut before = Quat::IDENTITY;
        let rotations = self.rotations[index].iter().map(|rotation| {
            let rotation = (turn * *rotation).normalize().as_quat();
            // Of the two quaternions of a rotation, take the one that makes the curve smooth.
            before = in_hemisphere_of(before, rotation);
            before
        });
        Channel {
            node_name: joint.name.clone(),
            node: Some(id),
            position_keys,
            rotation_keys: Keys::every_tick(rotations.collect()),
            scaling_keys: Keys::constant(Vec3::ONE),
        }
    }

    /// The joints in depth-first order: after each joint come its descendants, then its next sibling.
    fn depth_first(&self) -> Vec<usize> {
        let mut order = Vec::with_capacity(self.joints.len());
        let mut open: Vec<usize> = Vec::new();
        let children = |parent: Option<usize>| {
            let all = self.joints.iter().enumerate().rev();
            all.filter(move |(_, joint)| joint.parent == parent)
                .map(|(index, _)| index)
        };
        open.extend(children(None));
        while let Some(joint) = open.pop() {
            order.push(joint);
            open.extend(children(Some(joint)));
        }
        order
    }

    /// Replaces each value that is not finite by the last finite value before it.
    fn repair(&mut self, warnings: &mut Warnings) {
        let mut count = 0;
        let mut last = DVec3::ZERO;
        for position in &mut self.root {
            if !position.is_finite() {
                (*position, count) = (last, count + 1);
            }
            last = *position;
        }
        for track in &mut self.rotations {
            let mut last = DQuat::IDENTITY;
            for rotation in track {
                if !rotation.is_finite() || rotation.length_squared() < 1e-6 {
                    (*rotation, count) = (last, count + 1);
                }
                last = *rotation;
            }
        }
        if count > 0 {
            warnings.push(Code::NonFiniteValue, || {
                let message = format!(
                    "{count} positions or rotations of the arrays are not finite, or are not valid \
                    rotations"
                );
                Diagnostic::new(Code::NonFiniteValue, message).help("the last valid value was used instead")
            });
        }
    }
}

pub(super) fn named(up: UpAxis) -> &'static str {
    match up {
        UpAxis::Y => "+Y",
        UpAxis::Z => "+Z",
        UpAxis::NegY => "-Y",
        UpAxis::NegZ => "-Z",
    }
}
