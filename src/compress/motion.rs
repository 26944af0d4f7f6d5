//! What has to be met: where every joint is and how it is turned, at every moment that counts.

use std::borrow::Cow;
use std::ops::Range;

use glam::{Quat, Vec3};

use super::chain::SHELL;
use super::code::same_side;
use crate::error::{Code, Diagnostic, Result};
use crate::pose::{Binding, Trs};
use crate::scene::{Animation, Keys, Node, NodeId, Scene};

/// How far a scale may be from even along the three axes: what is left of rounding.
const EVEN: f32 = 1e-4;

/// Frames times nodes. Each takes some 100 bytes; and a duration is a claim, which a few keys can make.
const MOST_VALUES: usize = 1 << 28;

/// One animation of a scene, sampled.
pub(super) struct Motion<'a> {
    /// The moments that count: the whole ticks of the animation, and every tick that has a key.
    pub(super) ticks: Vec<f64>,
    /// One a node of the scene, in its order.
    pub(super) joints: Vec<Joint<'a>>,
}

/// One node, and how it stands to its parent at every moment.
pub(super) struct Joint<'a> {
    pub(super) parent: Option<usize>,
    pub(super) children: Vec<usize>,
    pub(super) translation: Track<'a, Vec3>,
    pub(super) rotation: Track<'a, Quat>,
    /// Where the joint stands at all moments, and how, if it moves and turns so little that it can as well be still.
    steady_translation: Option<Vec3>,
    steady_rotation: Option<Quat>,
    /// Length in the world of a unit in the space of this node.
    pub(super) scale: f32,
}

pub(super) enum Track<'a, T: Clone> {
    Still(T),
    Moving(Cow<'a, [T]>),
}

impl<T: Copy> Track<'_, T> {
    pub(super) fn at(&self, frame: usize) -> T {
        match self {
            Self::Still(value) => *value,
            Self::Moving(values) => values[frame],
        }
    }

    pub(super) fn moves(&self) -> bool {
        matches!(self, Self::Moving(_))
    }

    /// None where it stands still.
    fn values(&self) -> &[T] {
        match self {
            Self::Still(_) => &[],
            Self::Moving(values) => values,
        }
    }
}

impl Track<'_, Vec3> {
    fn mean(&self) -> Option<Vec3> {
        let values = self.values();
        (!values.is_empty()).then(|| values.iter().sum::<Vec3>() / values.len() as f32)
    }
}

/// Nothing of no rotations.
pub(super) fn mean_rotation(rotations: &[Quat]) -> Option<Quat> {
    let first = *rotations.first()?;
    let add = |sum: Quat, rotation: &Quat| sum + same_side(*rotation, first);
    Some(rotations.iter().fold(first * 0.0, add).normalize())
}

/// Positions and rotations in the world, one a moment.
#[derive(Clone, Default)]
pub(super) struct World {
    pub(super) positions: Vec<Vec3>,
    pub(super) rotations: Vec<Quat>,
}

impl<'a> Motion<'a> {
    /// # Errors
    /// Where a value is not finite, or where the motion scales: then no bound on its parts is one on the whole.
    pub(super) fn new(scene: &'a Scene, animation: &'a Animation) -> Result<Self> {
        let values = animation.frame_count().saturating_mul(scene.nodes.len());
        if values > MOST_VALUES {
            let message = "its frames are too many to keep a largest error over them";
            return Err(Diagnostic::new(Code::LimitExceeded, message)
                .expected_found(
                    format!("at most {MOST_VALUES} frames of a node"),
                    format!("{} frames of {} nodes", animation.frame_count(), scene.nodes.len()),
                )
                .help("write it without compression and without a largest error, or trim it")
                .into());
        }
        let ticks = moments(animation);
        let mut joints: Vec<Joint> = Vec::with_capacity(scene.nodes.len());
        let mut carries = vec![false; scene.nodes.len()];
        for node in &scene.nodes {
            if let Some(parent) = node.parent {
                carries[parent.index()] = true;
            }
        }
        for (index, node) in scene.nodes.iter().enumerate() {
            let parent = node.parent.map(NodeId::index);
            if let Some(parent) = parent {
                joints[parent].children.push(index);
            }
            let rest = Trs::from_matrix(node.transform);
            let above = parent.map_or(1.0, |parent| joints[parent].scale);
            joints.push(Joint {
                parent,
                children: Vec::new(),
                translation: Track::Still(finite(node, rest.translation)?),
                rotation: Track::Still(unit(node, rest.rotation)?),
                steady_translation: None,
                steady_rotation: None,
                // The scale of a node that carries nothing moves nothing.
                scale: above
                    * if carries[index] {
                        even_scale(node, &[rest.scale])?
                    } else {
                        1.0
                    },
            });
        }
        for (node, place) in Binding::new(scene, animation).driven() {
            let channel = &animation.channels[place];
            let (node, joint) = (&scene.nodes[node.index()], &mut joints[node.index()]);
            if !channel.scaling_keys.is_empty() && !joint.children.is_empty() {
                let own = even_scale(node, &channel.scaling_keys.values)?;
                let rest = even_scale(node, &[Trs::from_matrix(node.transform).scale])?;
                if (own / rest - 1.0).abs() > EVEN {
                    return Err(scales(node).into());
                }
            }
            if let Some(track) = track(&channel.position_keys, &ticks, Keys::<Vec3>::sample) {
                check(node, &track, Vec3::is_finite)?;
                joint.translation = track;
            }
            if let Some(track) = track(&channel.rotation_keys, &ticks, Keys::<Quat>::sample) {
                check(node, &track, |value| (value.length_squared() - 1.0).abs() < 1e-3)?;
                joint.rotation = track;
            }
        }
        Ok(Self { ticks, joints })
    }

    /// Lets joints be still that move and turn so little that what they carry moves by no more than `tolerance`.
    pub(super) fn settle(&mut self, tolerance: f32) {
        // How far a joint's turn reaches: to the next joint that turns by itself.
        let mut reaches = vec![SHELL; self.joints.len()];
        for index in (0..self.joints.len()).rev() {
            let joint = &self.joints[index];
            for &child in &joint.children {
                let below = &self.joints[child];
                if !below.shifts() {
                    let way = below.offset().length() * joint.scale;
                    let reach = way + if below.turns() { 0.0 } else { reaches[child] };
                    reaches[index] = reaches[index].max(reach);
                }
            }
            let scale = self.unit(joint);
            let steady_translation = joint.translation.mean().filter(|mean| {
                let far = |value: &Vec3| value.distance(*mean) * scale > tolerance;
                !joint.translation.values().iter().any(far)
            });
            let steady_rotation = mean_rotation(joint.rotation.values()).filter(|mean| {
                let angle = |value: &Quat| 2.0 * (mean.conjugate() * *value).xyz().length();
                let far = |value: &Quat| angle(value) * reaches[index] > tolerance;
                !joint.rotation.values().iter().any(far)
            });
            let joint = &mut self.joints[index];
            (joint.steady_translation, joint.steady_rotation) = (steady_translation, steady_rotation);
        }
    }

    pub(super) fn frames(&self) -> usize {
        self.ticks.len()
    }

    /// All frames, as one stretch.
    pub(super) fn everywhere(&self) -> Vec<Range<usize>> {
        std::iter::once(0..self.frames()).collect()
    }

    /// Length in the world of a unit of a joint's translation.
    pub(super) fn unit(&self, joint: &Joint) -> f32 {
        joint.parent.map_or(1.0, |parent| self.joints[parent].scale)
    }

    /// Where all joints are in the world. Those that neither move nor carry another are left empty: their parent says
    /// where they are.
    pub(super) fn world(&self) -> Vec<World> {
        let mut worlds: Vec<World> = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            let mut world = World::default();
            if !joint.is_tip() {
                world.positions.reserve_exact(self.frames());
                world.rotations.reserve_exact(self.frames());
                for frame in 0..self.frames() {
                    let (translation, rotation) = (joint.translation.at(frame), joint.rotation.at(frame));
                    let (position, rotation) = match joint.parent {
                        None => (translation, rotation),
                        Some(parent) => {
                            let (above, scale) = (&worlds[parent], self.joints[parent].scale);
                            let turn = above.rotations[frame];
                            (above.positions[frame] + turn * (translation * scale), turn * rotation)
                        }
                    };
                    world.positions.push(position);
                    world.rotations.push(rotation.normalize());
                }
            }
            worlds.push(world);
        }
        worlds
    }
}

impl Joint<'_> {
    /// Whether it has to move in its parent, and to turn.
    pub(super) fn shifts(&self) -> bool {
        self.translation.moves() && self.steady_translation.is_none()
    }

    pub(super) fn turns(&self) -> bool {
        self.rotation.moves() && self.steady_rotation.is_none()
    }

    /// Where it stands if it does not have to move, and how if it does not have to turn.
    pub(super) fn offset(&self) -> Vec3 {
        self.steady_translation.unwrap_or_else(|| self.translation.at(0))
    }

    pub(super) fn turn(&self) -> Quat {
        self.steady_rotation.unwrap_or_else(|| self.rotation.at(0))
    }

    /// Whether the node neither moves nor carries another.
    pub(super) fn is_tip(&self) -> bool {
        self.children.is_empty() && !self.translation.moves() && !self.rotation.moves()
    }
}

/// The whole ticks of an animation and those of all its keys, each once.
fn moments(animation: &Animation) -> Vec<f64> {
    let mut ticks: Vec<f64> = (0..animation.frame_count()).map(|frame| frame as f64).collect();
    let own = animation.channels.iter().flat_map(|channel| {
        let own = [&channel.position_keys.ticks, &channel.rotation_keys.ticks];
        own.into_iter().flatten().flatten()
    });
    let extra: Vec<f64> = own
        .copied()
        .filter(|tick| tick.fract() != 0.0 && tick.is_finite() && *tick >= 0.0 && *tick <= animation.duration)
        .collect();
    if !extra.is_empty() {
        ticks.extend(extra);
        ticks.sort_by(f64::total_cmp);
        ticks.dedup();
    }
    ticks
}

/// The values of a track at `ticks`; borrowed where it has a key at each.
fn track<'a, T: Copy + PartialEq>(
    keys: &'a Keys<T>,
    ticks: &[f64],
    sample: fn(&Keys<T>, f64) -> Option<T>,
) -> Option<Track<'a, T>> {
    let first = *keys.values.first()?;
    if keys.values.iter().all(|value| *value == first) {
        return Some(Track::Still(first));
    }
    if keys.ticks.is_none() && keys.len() == ticks.len() {
        return Some(Track::Moving(Cow::Borrowed(&keys.values)));
    }
    let values: Vec<T> = ticks.iter().filter_map(|&tick| sample(keys, tick)).collect();
    Some(Track::Moving(Cow::Owned(values)))
}

fn check<T: Copy>(node: &Node, track: &Track<'_, T>, is_good: impl Fn(T) -> bool) -> Result<()> {
    let all = match track {
        Track::Still(value) => is_good(*value),
        Track::Moving(values) => values.iter().all(|value| is_good(*value)),
    };
    if all { Ok(()) } else { Err(not_finite(node).into()) }
}

fn finite(node: &Node, value: Vec3) -> Result<Vec3> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(not_finite(node).into())
    }
}

fn unit(node: &Node, value: Quat) -> Result<Quat> {
    if value.is_finite() && value.length_squared() > 0.0 {
        Ok(value.normalize())
    } else {
        Err(not_finite(node).into())
    }
}

fn not_finite(node: &Node) -> Diagnostic {
    Diagnostic::new(
        Code::Unrepresentable,
        "a value of its motion is not finite, or a rotation is none",
    )
    .in_joint(&node.name)
}

fn even_scale(node: &Node, values: &[Vec3]) -> Result<f32> {
    let first = values[0].x;
    let is_even = |value: &Vec3| value.to_array().iter().all(|axis| (axis / first - 1.0).abs() < EVEN);
    if first.is_finite() && first > 0.0 && values.iter().all(is_even) {
        Ok(first)
    } else {
        Err(scales(node).into())
    }
}

fn scales(node: &Node) -> Diagnostic {
    Diagnostic::new(
        Code::Unrepresentable,
        "it scales over time or unevenly, for which no bound is known here",
    )
    .in_joint(&node.name)
    .help("write it without compression and without a largest error")
}
