//! The raw clip: one animation of a scene, sampled at every frame, as a hierarchy of joints.

use std::borrow::Cow;
use std::ops::Range;

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::pose::{Binding, Trs, forward_kinematics};
use mocap_scene::scene::{Animation, Keys, Node, NodeId, Scene};

use super::object_space::ObjectSpaceTrack;

/// The largest relative difference between the three factors of a scale that counts as uniform: a few rounding errors.
const UNIFORM: f32 = 1e-4;

/// The number of shell points of a joint: one on each of its axes.
const SHELL_POINTS: usize = Vec3::AXES.len();

/// The default shell distance in metres for a joint whose rotation moves no other joint. The distance is ACL's value,
/// and about the distance of the skin from a joint.
const SKIN: f32 = 0.03;

/// The largest allowed difference between 1 and the squared length of a quaternion. It is more than the rounding of
/// 16-bit integers.
const NOT_A_UNIT: f32 = 1e-3;

/// The largest product of frames and nodes. A node takes about 100 bytes in each frame, and a file with a few keys can
/// claim any duration.
const MAX_VALUES: usize = 1 << 28;

pub struct RawClip<'a> {
    /// The frames: the whole ticks of the animation, and every tick with a key.
    pub ticks: Vec<f64>,
    /// One joint per node of the scene, in its order; then the points of the shells.
    pub(super) joints: Vec<RawJoint<'a>>,
    /// The node of every shell point.
    shell: Vec<usize>,
}

/// One node, and its transform relative to its parent at every frame.
pub(super) struct RawJoint<'a> {
    pub(super) parent: Option<usize>,
    pub(super) children: Vec<usize>,
    pub(super) translation: RawTrack<'a, Vec3>,
    pub(super) rotation: RawTrack<'a, Quat>,
    /// The constant value that may replace an animated track: see [`constant_tracks`](super::constant_tracks).
    pub(super) constant_translation: Option<Vec3>,
    pub(super) constant_rotation: Option<Quat>,
    /// The length of a unit in the space of this node, in metres.
    pub(super) scale: f32,
    /// The length of a unit in the space of its parent, in metres. The translation has this unit.
    pub(super) parent_scale: f32,
}

pub(super) enum RawTrack<'a, T: Clone> {
    Constant(T),
    /// One value per frame.
    Animated(Cow<'a, [T]>),
}

impl<T: Copy> RawTrack<'_, T> {
    pub(super) fn at(&self, frame: usize) -> T {
        match self {
            Self::Constant(value) => *value,
            Self::Animated(values) => values[frame],
        }
    }

    pub(super) fn is_animated(&self) -> bool {
        matches!(self, Self::Animated(_))
    }

    /// The values of an animated track; empty for a constant track.
    pub(super) fn animated_values(&self) -> &[T] {
        match self {
            Self::Constant(_) => &[],
            Self::Animated(values) => values,
        }
    }
}

/// Refuses an animation if its joints and shell points at all frames would take too much memory.
fn check_values(frames: usize, joints: usize) -> Result<()> {
    if frames.saturating_mul(joints) <= MAX_VALUES {
        return Ok(());
    }
    let message = "the animation has too many frames to measure the error at each";
    Err(Diagnostic::new(Code::LimitExceeded, message)
        .expected_found(
            format!("at most {MAX_VALUES} as the product of frames and measured points"),
            format!("{frames} frames, each with {joints} nodes and shell points"),
        )
        .help("write the motion without compression and without a largest error, or trim the motion")
        .into())
}

impl<'a> RawClip<'a> {
    /// Samples an animation at every frame. Every joint has a shell: three points that represent its skin,
    /// `shell_distance` metres along its axes. If the distance is 0, only a joint whose rotation moves no other joint
    /// has a shell, at 3 cm.
    ///
    /// # Errors
    /// A value is not finite, or a scale is not constant and uniform. Under a scale that changes or is not uniform,
    /// small errors of rotations and translations do not keep the positions within the bound.
    pub fn new(scene: &'a Scene, animation: &'a Animation, shell_distance: f32) -> Result<Self> {
        let joints = scene.nodes.len() * if shell_distance > 0.0 { 1 + SHELL_POINTS } else { 1 };
        check_values(animation.frame_count(), joints)?;
        let ticks = frame_ticks(animation);
        let mut joints: Vec<RawJoint> = Vec::with_capacity(scene.nodes.len());
        let mut has_children = vec![false; scene.nodes.len()];
        for node in &scene.nodes {
            if let Some(parent) = node.parent {
                has_children[parent.index()] = true;
            }
        }
        for (index, node) in scene.nodes.iter().enumerate() {
            let parent = node.parent.map(NodeId::index);
            if let Some(parent) = parent {
                joints[parent].children.push(index);
            }
            let rest = Trs::from_matrix(node.transform);
            let parent_scale = parent.map_or(1.0, |parent| joints[parent].scale);
            // The scale of a leaf moves no joint.
            let own_scale = if has_children[index] {
                uniform_scale(node, &[rest.scale])?
            } else {
                1.0
            };
            joints.push(RawJoint {
                parent,
                children: Vec::new(),
                translation: RawTrack::Constant(finite(node, rest.translation)?),
                rotation: RawTrack::Constant(normalized(node, rest.rotation)?),
                constant_translation: None,
                constant_rotation: None,
                scale: parent_scale * own_scale,
                parent_scale,
            });
        }
        for (node, channel) in Binding::new(scene, animation).driven() {
            let channel = &animation.channels[channel];
            let (node, joint) = (&scene.nodes[node.index()], &mut joints[node.index()]);
            if !channel.scaling_keys.is_empty() && !joint.children.is_empty() {
                let own = uniform_scale(node, &channel.scaling_keys.values)?;
                let rest = uniform_scale(node, &[Trs::from_matrix(node.transform).scale])?;
                if (own / rest - 1.0).abs() > UNIFORM {
                    return Err(scale_error(node).into());
                }
            }
            if let Some(track) = sample(&channel.position_keys, &ticks, Keys::<Vec3>::sample) {
                check(node, &track, Vec3::is_finite)?;
                joint.translation = track;
            }
            if let Some(track) = sample(&channel.rotation_keys, &ticks, Keys::<Quat>::sample) {
                check(node, &track, |value| (value.length_squared() - 1.0).abs() < NOT_A_UNIT)?;
                joint.rotation = track;
            }
        }
        let mut clip = Self {
            ticks,
            joints,
            shell: Vec::new(),
        };
        match shell_distance > 0.0 {
            true => clip.add_shell(shell_distance, &vec![true; scene.nodes.len()]),
            false => clip.add_shell(SKIN, &clip.turning_ends()),
        }
        check_values(animation.frame_count(), clip.joints.len())?;
        Ok(clip)
    }

    /// For each joint, whether its rotation moves no joint, because all its descendants are at the joint's own
    /// position.
    fn turning_ends(&self) -> Vec<bool> {
        let mut reaches = vec![false; self.joints.len()];
        for (index, joint) in self.joints.iter().enumerate().rev() {
            let stands_away = joint.translation.is_animated() || joint.offset() != Vec3::ZERO;
            if let Some(parent) = joint.parent {
                reaches[parent] |= reaches[index] || stands_away;
            }
        }
        let joints = self.joints.iter().zip(reaches);
        joints
            .map(|(joint, reaches)| joint.rotation.is_animated() && !reaches)
            .collect()
    }

    /// Adds a shell to each joint for which `has_shell` is true.
    fn add_shell(&mut self, distance: f32, has_shell: &[bool]) {
        for node in (0..self.joints.len()).filter(|node| has_shell[*node]) {
            let joint = &self.joints[node];
            // A static joint moves with its parent. A static root is at its correct position.
            let (parent, start, rotation) = match joint.parent {
                _ if !joint.is_static_leaf() => (node, Vec3::ZERO, Quat::IDENTITY),
                Some(parent) => (parent, joint.offset(), joint.orientation()),
                None => continue,
            };
            let scale = self.joints[parent].scale;
            for axis in Vec3::AXES {
                let point = start + rotation * axis * (distance / scale);
                let index = self.joints.len();
                self.joints[parent].children.push(index);
                self.joints.push(RawJoint {
                    parent: Some(parent),
                    children: Vec::new(),
                    translation: RawTrack::Constant(point),
                    rotation: RawTrack::Constant(Quat::IDENTITY),
                    constant_translation: None,
                    constant_rotation: None,
                    scale,
                    parent_scale: scale,
                });
                self.shell.push(node);
            }
        }
    }

    /// The number of nodes in the scene.
    pub(super) fn nodes(&self) -> usize {
        self.joints.len() - self.shell.len()
    }

    /// The node of a joint or of a shell point.
    pub(super) fn node_of(&self, joint: usize) -> usize {
        joint.checked_sub(self.nodes()).map_or(joint, |point| self.shell[point])
    }

    pub(super) fn frames(&self) -> usize {
        self.ticks.len()
    }

    /// All frames as one range, for functions that take several ranges.
    pub(super) fn all_frames(&self) -> Vec<Range<usize>> {
        std::iter::once(0..self.frames()).collect()
    }

    pub(super) fn parent_of(&self, joint: usize) -> Option<usize> {
        self.joints[joint].parent
    }

    /// All joints in object space. Static leaves are empty: their positions follow from their parents.
    pub(super) fn object_space(&self) -> Vec<ObjectSpaceTrack> {
        let mut tracks = vec![ObjectSpaceTrack::default(); self.joints.len()];
        forward_kinematics(
            &mut tracks,
            |index| self.parent_of(index),
            |index, parent, track| {
                let joint = &self.joints[index];
                if joint.is_static_leaf() {
                    return;
                }
                *track = ObjectSpaceTrack::with_capacity(self.frames());
                track.positions.extend((0..self.frames()).map(|frame| {
                    let offset = joint.translation.at(frame) * joint.parent_scale;
                    ObjectSpaceTrack::position(parent, frame, offset)
                }));
                let rotation = |frame| ObjectSpaceTrack::rotation(parent, frame, joint.rotation.at(frame));
                track.rotations.extend((0..self.frames()).map(rotation));
            },
        );
        tracks
    }
}

impl RawJoint<'_> {
    /// Whether the translation relative to the parent needs keys.
    pub(super) fn translates(&self) -> bool {
        self.translation.is_animated() && self.constant_translation.is_none()
    }

    /// Whether the rotation relative to the parent needs keys.
    pub(super) fn rotates(&self) -> bool {
        self.rotation.is_animated() && self.constant_rotation.is_none()
    }

    /// The translation of a joint that does not [translate](Self::translates); otherwise its translation in the first
    /// frame.
    pub(super) fn offset(&self) -> Vec3 {
        self.constant_translation.unwrap_or_else(|| self.translation.at(0))
    }

    /// The rotation of a joint that does not [rotate](Self::rotates); otherwise its rotation in the first frame.
    pub(super) fn orientation(&self) -> Quat {
        self.constant_rotation.unwrap_or_else(|| self.rotation.at(0))
    }

    /// Whether the joint is not animated and has no children, like an end site.
    pub(super) fn is_static_leaf(&self) -> bool {
        self.children.is_empty() && !self.translation.is_animated() && !self.rotation.is_animated()
    }
}

/// The whole ticks of an animation and the ticks of all its keys, each once.
fn frame_ticks(animation: &Animation) -> Vec<f64> {
    let mut ticks: Vec<f64> = animation.whole_ticks().collect();
    let of_keys = animation.channels.iter().flat_map(|channel| {
        let of_channel = [&channel.position_keys.ticks, &channel.rotation_keys.ticks];
        of_channel.into_iter().flatten().flatten()
    });
    let between: Vec<f64> = of_keys
        .copied()
        .filter(|tick| tick.fract() != 0.0 && tick.is_finite() && *tick >= 0.0 && *tick <= animation.duration)
        .collect();
    if !between.is_empty() {
        ticks.extend(between);
        ticks.sort_unstable_by(f64::total_cmp);
        ticks.dedup();
    }
    ticks
}

/// The values of the keys at `ticks`; `None` if there is no key. The values are borrowed if there is a key at each
/// tick.
fn sample<'a, T: Copy + PartialEq>(
    keys: &'a Keys<T>,
    ticks: &[f64],
    sample: fn(&Keys<T>, f64) -> Option<T>,
) -> Option<RawTrack<'a, T>> {
    let first = *keys.values.first()?;
    if keys.values.iter().all(|value| *value == first) {
        return Some(RawTrack::Constant(first));
    }
    if keys.ticks.is_none() && keys.len() == ticks.len() {
        return Some(RawTrack::Animated(Cow::Borrowed(&keys.values)));
    }
    let values: Vec<T> = ticks.iter().filter_map(|&tick| sample(keys, tick)).collect();
    Some(RawTrack::Animated(Cow::Owned(values)))
}

fn check<T: Copy>(node: &Node, track: &RawTrack<'_, T>, is_good: impl Fn(T) -> bool) -> Result<()> {
    let all = match track {
        RawTrack::Constant(value) => is_good(*value),
        RawTrack::Animated(values) => values.iter().all(|value| is_good(*value)),
    };
    if all { Ok(()) } else { Err(value_error(node).into()) }
}

fn finite(node: &Node, value: Vec3) -> Result<Vec3> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(value_error(node).into())
    }
}

fn normalized(node: &Node, value: Quat) -> Result<Quat> {
    if value.is_finite() && value.length_squared() > 0.0 {
        Ok(value.normalize())
    } else {
        Err(value_error(node).into())
    }
}

fn value_error(node: &Node) -> Diagnostic {
    Diagnostic::new(
        Code::Unrepresentable,
        "a position is not finite, or a rotation is not a quaternion of length 1",
    )
    .in_joint(&node.name)
}

fn uniform_scale(node: &Node, values: &[Vec3]) -> Result<f32> {
    let first = values[0].x;
    let is_uniform = |value: &Vec3| value.to_array().iter().all(|axis| (axis / first - 1.0).abs() < UNIFORM);
    if first.is_finite() && first > 0.0 && values.iter().all(is_uniform) {
        Ok(first)
    } else {
        Err(scale_error(node).into())
    }
}

fn scale_error(node: &Node) -> Diagnostic {
    Diagnostic::new(
        Code::Unrepresentable,
        "a largest error can be kept only if the scale is above 0, uniform and constant",
    )
    .in_joint(&node.name)
    .help("write the motion without compression and without a largest error")
}
