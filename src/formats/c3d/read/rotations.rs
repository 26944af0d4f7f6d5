//! Reads the group `ROTATION`: the pose of each body segment in each frame. Markerless systems such as Theia write this
//! group instead of markers.
//!
//! The data has 17 floats for each segment and frame: a 4 by 4 matrix from the segment to the laboratory, column by
//! column, and a residual. A negative residual means that the segment was not found (C-Motion, *ROTATION data type*).
//! The origin is the proximal joint. In Visual3D's axes +X is to the right, and +Z points from the distal joint to the
//! proximal one. A foot has either +Z up, or +Z from the toes to the ankle.

use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DQuat, DVec3, Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::math::median::median_vector;
use mocap_scene::math::up_axis::to_y_up;
use mocap_scene::scene::HumanoidBone::{self as Bone, *};
use mocap_scene::scene::{Channel, Keys, Node, NodeId, Scene, UpAxis};

use super::bytes::Processor;
use super::parameters::Parameters;
use super::{BLOCK, Header};
use crate::frames::add_animation;
use crate::warnings::{Warnings, missing_frames};

/// The number of floats of a pose: 16 of the matrix, and the residual.
const FLOATS: usize = 17;

/// The largest difference of the columns of a rotation from orthogonal unit vectors.
const SKEWED: f64 = 0.01;

/// The segments, parents first: the label without its ending, the bone, and the possible parents.
const SEGMENTS: [(&str, Bone, &[&str]); 19] = [
    ("pelvis", Hips, &[]),
    ("l_thigh", LeftUpperLeg, &["pelvis"]),
    ("l_shank", LeftLowerLeg, &["l_thigh"]),
    ("l_foot", LeftFoot, &["l_shank"]),
    ("l_toes", LeftToes, &["l_foot"]),
    ("r_thigh", RightUpperLeg, &["pelvis"]),
    ("r_shank", RightLowerLeg, &["r_thigh"]),
    ("r_foot", RightFoot, &["r_shank"]),
    ("r_toes", RightToes, &["r_foot"]),
    ("abdomen", Spine, &["pelvis"]),
    ("torso", Chest, &["abdomen", "pelvis"]),
    ("neck", Neck, &["torso"]),
    ("head", Head, &["neck", "torso"]),
    ("l_uarm", LeftUpperArm, &["torso"]),
    ("l_larm", LeftLowerArm, &["l_uarm"]),
    ("l_hand", LeftHand, &["l_larm"]),
    ("r_uarm", RightUpperArm, &["torso"]),
    ("r_larm", RightLowerArm, &["r_uarm"]),
    ("r_hand", RightHand, &["r_larm"]),
];

/// The segments that a body must have.
const LEAST: [&str; 7] = ["pelvis", "l_thigh", "l_shank", "l_foot", "r_thigh", "r_shank", "r_foot"];

/// The ending of the labels.
const ENDING: &str = "_4x4";

/// A segment and its pose in each frame; `None` if it was not found.
struct Segment {
    label: String,
    poses: Vec<Option<(DQuat, DVec3)>>,
}

/// The poses of the segments.
pub(super) struct Segments {
    segments: Vec<Segment>,
    frames: usize,
    rate: f64,
}

/// The byte at which the poses begin, and the number of segments; `None` if the file has no poses.
pub(super) fn layout(parameters: &Parameters) -> Option<(usize, usize)> {
    // Both parameters are unsigned words. If one is 0, the file has no poses.
    let word = |name: &str| Some(usize::from(parameters.number("ROTATION", name)? as i64 as u16));
    let (block, count) = (word("DATA_START")?.checked_sub(1)?, word("USED")?);
    (count > 0).then_some((block * BLOCK, count))
}

/// Reads the poses of all complete frames; `None` if the file has none.
pub(super) fn read(
    bytes: &[u8],
    processor: Processor,
    header: &Header,
    parameters: &Parameters,
    max_values: u64,
    warnings: &mut Warnings,
) -> Option<Segments> {
    let (start, count) = layout(parameters)?;
    let stated = |name: &str| parameters.number("ROTATION", name).filter(|number| *number > 0.0);
    let ratio = stated("RATIO").or_else(|| Some(stated("RATE")? / header.stated_rate));
    let ratio = ratio.map_or(1.0, f64::round).clamp(1.0, f64::from(u16::MAX));
    let wanted = header.frames.saturating_mul(ratio as u64);
    let record = 4 * FLOATS * count;
    let data = bytes.get(start..).unwrap_or_default();
    let most = usize::try_from(max_values).unwrap_or(usize::MAX) / (FLOATS * count);
    let frames = usize::try_from(wanted)
        .unwrap_or(usize::MAX)
        .min(data.len() / record)
        .min(most);
    if (frames as u64) < wanted {
        warnings.push(Code::MissingFrames, || missing_frames(wanted, frames as u64));
    }
    let labels = parameters.all_texts("ROTATION", "LABELS");
    let segment = |index: usize| Segment {
        label: labels.get(index).copied().unwrap_or_default().to_owned(),
        poses: (0..frames)
            .map(|frame| pose(&data[frame * record + 4 * FLOATS * index..][..4 * FLOATS], processor))
            .collect(),
    };
    Some(Segments {
        segments: (0..count).map(segment).collect(),
        frames,
        rate: header.frame_rate * ratio,
    })
}

/// The rotation and the position of a segment; `None` if it was not found.
fn pose(bytes: &[u8], processor: Processor) -> Option<(DQuat, DVec3)> {
    let (words, _) = bytes.as_chunks::<4>();
    let number = |index: usize| processor.real(words[index]);
    let column = |index: usize| DVec3::new(number(4 * index), number(4 * index + 1), number(4 * index + 2));
    let rotation = DMat3::from_cols(column(0), column(1), column(2));
    let off = rotation.transpose() * rotation - DMat3::IDENTITY;
    let is_rotation = off.to_cols_array().into_iter().all(|value| value.abs() < SKEWED) && rotation.determinant() > 0.0;
    let is_found = number(FLOATS - 1) >= 0.0 && is_rotation && column(3).is_finite();
    is_found.then(|| (DQuat::from_mat3(&rotation).normalize(), column(3)))
}

impl Segments {
    fn named(&self, name: &str) -> Option<&Segment> {
        let is_it = |own: &&Segment| own.name() == name && own.poses.iter().any(Option::is_some);
        self.segments.iter().find(is_it)
    }

    /// Whether the segments are a body with legs, in the axes of Visual3D.
    fn are_a_body(&self) -> bool {
        if LEAST.iter().any(|name| self.named(name).is_none()) {
            return false;
        }
        let direction = |parent: &str, child: &str| self.offset(parent, child).normalize_or_zero();
        let across = direction("pelvis", "r_thigh") - direction("pelvis", "l_thigh");
        let is_below = |side: char| direction(&format!("{side}_thigh"), &format!("{side}_shank")).z < -0.7;
        across.x > 0.0 && is_below('l') && is_below('r')
    }

    /// The median position of a segment in the axes of another segment.
    fn offset(&self, parent: &str, child: &str) -> DVec3 {
        let (Some(parent), Some(child)) = (self.named(parent), self.named(child)) else {
            return DVec3::ZERO;
        };
        let both = std::iter::zip(&parent.poses, &child.poses).filter_map(|(parent, child)| (*parent).zip(*child));
        median_vector(both.map(|((rotation, position), (_, child))| rotation.inverse() * (child - position)))
    }

    /// The rotation from axes with +X to the left, +Y up and +Z forward in the standing pose, to the segment's axes.
    fn axes(&self, name: &str) -> DQuat {
        let (side, part) = name.split_once('_').unwrap_or_default();
        let to_toes = self.offset(&format!("{side}_foot"), &format!("{side}_toes"));
        let columns = match ["foot", "toes"].contains(&part) && -to_toes.z > to_toes.y {
            true => [DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z],
            false => [DVec3::NEG_X, DVec3::Z, DVec3::Y],
        };
        let axes = DQuat::from_mat3(&DMat3::from_cols(columns[0], columns[1], columns[2])).normalize();
        // Standing segments have palms forward. In the rest pose the palms face the body.
        let pronation = match (side, part) {
            ("l", "larm" | "hand") => FRAC_PI_2,
            ("r", "larm" | "hand") => -FRAC_PI_2,
            _ => 0.0,
        };
        axes * DQuat::from_rotation_y(pronation)
    }

    /// Adds a skeleton to an empty scene. Returns whether the segments are a body. The rest pose stands with hanging
    /// arms, without rotations, and faces +Z.
    pub(super) fn add(&self, scene: &mut Scene, up: UpAxis, warnings: &mut Warnings) -> bool {
        if !self.are_a_body() {
            return false;
        }
        // The world rotations and positions of the joints, with +Y up.
        let mut world: Vec<Vec<(DQuat, DVec3)>> = Vec::new();
        let mut heights: Vec<f64> = Vec::new();
        let mut channels = Vec::new();
        let axis = |axis: Vec3| to_y_up(axis, up).as_dvec3();
        let turn = DMat3::from_cols(axis(Vec3::X), axis(Vec3::Y), axis(Vec3::Z));
        let to_up = DQuat::from_mat3(&turn).normalize();
        let mut used = Vec::new();
        for (name, bone, parents) in SEGMENTS {
            let Some(segment) = self.named(name) else { continue };
            let parent = parents
                .iter()
                .find_map(|parent| used.iter().position(|own| own == parent));
            if parent.is_none() && !parents.is_empty() {
                continue;
            }
            let axes = self.axes(name);
            let poses: Vec<(DQuat, DVec3)> = (segment.whole().into_iter())
                .map(|(rotation, position)| (to_up * rotation * axes, turn * position))
                .collect();
            let mut before = DQuat::IDENTITY;
            let local = |(frame, (rotation, position)): (usize, &(DQuat, DVec3))| {
                let (rotation, position) = match parent.map(|parent| world[parent][frame]) {
                    Some((above, origin)) => (above.inverse() * *rotation, above.inverse() * (*position - origin)),
                    None => (*rotation, *position),
                };
                before = if rotation.dot(before) < 0.0 {
                    -rotation
                } else {
                    rotation
                }
                .normalize();
                (before, position)
            };
            let local: Vec<(DQuat, DVec3)> = poses.iter().enumerate().map(local).collect();
            let offset = match parent {
                Some(_) => median_vector(local.iter().map(|(_, position)| *position)),
                None => DVec3::ZERO,
            };
            heights.push(offset.y + parent.map_or(0.0, |parent| heights[parent]));
            segment.report_gap(warnings);
            let id = NodeId::new(scene.nodes.len());
            let label = segment.label[..segment.name().len()].to_owned();
            scene.nodes.push(Node {
                name: label.clone(),
                parent: parent.map(NodeId::new),
                transform: Mat4::from_translation(offset.as_vec3()),
                humanoid_bone: Some(if bone == Chest && self.named("abdomen").is_none() {
                    Spine
                } else {
                    bone
                }),
                ..Node::default()
            });
            channels.push(Channel {
                node_name: label,
                node: Some(id),
                position_keys: Keys::every_tick(local.iter().map(|(_, position)| position.as_vec3()).collect()),
                rotation_keys: Keys::every_tick(
                    local
                        .iter()
                        .map(|(rotation, _)| rotation.as_quat())
                        .collect::<Vec<Quat>>(),
                ),
                scaling_keys: Keys::constant(Vec3::ONE),
            });
            used.push(name);
            world.push(poses);
        }
        let lowest = heights.iter().copied().fold(0.0, f64::min);
        scene.nodes[0].transform = Mat4::from_translation(Vec3::new(0.0, -lowest as f32, 0.0));
        let skipped = self
            .segments
            .iter()
            .filter(|segment| !used.contains(&segment.name().as_str()));
        let skipped: Vec<&str> = skipped.map(|segment| segment.label.as_str()).collect();
        if !skipped.is_empty() {
            warnings.push(Code::IgnoredChannel, || {
                let message = format!("segments that are no bones were skipped: {}", skipped.join(", "));
                Diagnostic::new(Code::IgnoredChannel, message)
            });
        }
        add_animation(scene, (self.frames, self.rate), channels, "segments", warnings);
        true
    }

    /// The number of segments.
    pub(super) fn count(&self) -> usize {
        self.segments.len()
    }
}

impl Segment {
    /// The label in lower case, without its ending.
    fn name(&self) -> String {
        let name = self.label.to_ascii_lowercase();
        name.strip_suffix(ENDING).unwrap_or(&name).to_owned()
    }

    /// The poses of all frames. Missing poses between two poses are interpolated.
    fn whole(&self) -> Vec<(DQuat, DVec3)> {
        let found = |frame: &usize| self.poses[*frame].is_some();
        let mut before = None;
        let mut after = (0..self.poses.len()).find(found);
        let pose = |frame: usize| {
            if after == Some(frame) {
                before = after;
                after = (frame + 1..self.poses.len()).find(found);
            }
            let at = |frame: Option<usize>| frame.and_then(|frame| self.poses[frame]);
            match (at(before), at(after)) {
                (Some((rotation, position)), Some((other, to))) => {
                    let [first, last] = [before, after].map(|frame| frame.unwrap_or(0));
                    let part = (frame - first) as f64 / (last - first) as f64;
                    (rotation.slerp(other, part), position.lerp(to, part))
                }
                (one, other) => one.or(other).unwrap_or_default(),
            }
        };
        (0..self.poses.len()).map(pose).collect()
    }

    fn report_gap(&self, warnings: &mut Warnings) {
        let missing = self.poses.iter().filter(|pose| pose.is_none()).count();
        if missing > 0 {
            warnings.push(Code::Gap, || {
                let message = format!(
                    "the segment was not found in {missing} of {} frames; its poses were interpolated",
                    self.poses.len()
                );
                Diagnostic::new(Code::Gap, message).in_joint(&self.label)
            });
        }
    }
}
