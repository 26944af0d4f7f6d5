//! Forward kinematics in double precision, of a scene and of a glTF file alike.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::{DMat4, DQuat, DVec3, Quat, Vec3};

use crate::error::Result;
use crate::format::gltf::{File, Values};
use crate::pose::Binding;
use crate::scene::{Keys, NodeId, NodeKind, Scene};

/// Nodes, parents before children, with their tracks.
pub(super) struct Skeleton<'a> {
    pub(super) joints: Vec<Joint<'a>>,
    /// The time of the last key, in seconds.
    pub(super) end: f64,
}

pub(super) struct Joint<'a> {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    pub(super) kind: NodeKind,
    rest: (DVec3, DQuat, DVec3),
    translation: Option<Track<'a, Vec3>>,
    rotation: Option<Track<'a, Quat>>,
    scale: Option<Track<'a, Vec3>>,
}

/// The keys of one property, and their times.
struct Track<'a, T: Clone> {
    times: Times<'a>,
    values: Cow<'a, [T]>,
}

enum Times<'a> {
    /// One key per tick; ticks per second.
    EveryTick(f64),
    /// Ticks, and ticks per second.
    Ticks(&'a [f64], f64),
    /// Seconds.
    Seconds(Vec<f32>),
}

impl<'a> Skeleton<'a> {
    /// The nodes of `scene` and the keys of its first animation.
    pub(super) fn of_scene(scene: &'a Scene) -> Self {
        let joint = |node: &crate::scene::Node| {
            let (scale, rotation, translation) = node.transform.as_dmat4().to_scale_rotation_translation();
            Joint::at_rest(
                node.name.clone(),
                node.parent.map(NodeId::index),
                node.kind,
                (translation, rotation, scale),
            )
        };
        let mut joints: Vec<_> = scene.nodes.iter().map(joint).collect();
        let mut end = 0.0;
        if let Some(animation) = scene.animations.first() {
            let rate = animation.ticks_per_second;
            end = animation.duration / rate;
            for (node, channel) in Binding::new(scene, animation).driven() {
                let (joint, channel) = (&mut joints[node.index()], &animation.channels[channel]);
                joint.translation = Track::of_keys(&channel.position_keys, rate);
                joint.rotation = Track::of_keys(&channel.rotation_keys, rate);
                joint.scale = Track::of_keys(&channel.scaling_keys, rate);
            }
        }
        Self { joints, end }
    }
}

impl Skeleton<'static> {
    /// The nodes of a file's default scene and the tracks of its first animation.
    pub(super) fn of_file(file: &File<'_>) -> Result<Self> {
        let listed = file.nodes()?;
        let mut place_of = HashMap::new();
        let mut joints = Vec::with_capacity(listed.len());
        for (place, node) in listed.iter().enumerate() {
            place_of.insert(node.index, place);
            let at = file.transform(node.index)?;
            let rest = (at.translation.as_dvec3(), at.rotation.as_dquat(), at.scale.as_dvec3());
            let kind = if file.is_end_site(node.index) {
                NodeKind::EndSite
            } else {
                NodeKind::Joint
            };
            joints.push(Joint::at_rest(file.source_name(node.index), node.parent, kind, rest));
        }
        let tracks = match file.animations().len() {
            0 => Vec::new(),
            _ => file.tracks(0)?,
        };
        let mut end = 0.0;
        for track in tracks {
            end = track.times.last().map_or(end, |last| f64::max(end, f64::from(*last)));
            let Some(&place) = place_of.get(&track.node) else {
                continue;
            };
            let (joint, times) = (&mut joints[place], Times::Seconds(track.times));
            match track.values {
                Values::Translations(values) => {
                    joint.translation = Some(Track {
                        times,
                        values: values.into(),
                    });
                }
                Values::Rotations(values) => {
                    joint.rotation = Some(Track {
                        times,
                        values: values.into(),
                    });
                }
                Values::Scales(values) => {
                    joint.scale = Some(Track {
                        times,
                        values: values.into(),
                    });
                }
            }
        }
        Ok(Self { joints, end })
    }
}

impl Skeleton<'_> {
    /// Node to world of every joint at `seconds`, into `world`, which is emptied first.
    pub(super) fn world(&self, seconds: f64, world: &mut Vec<DMat4>) {
        world.clear();
        for joint in &self.joints {
            let node_to_parent = joint.node_to_parent(seconds);
            world.push(match joint.parent {
                Some(parent) => world[parent] * node_to_parent,
                None => node_to_parent,
            });
        }
    }
}

impl Joint<'_> {
    fn at_rest(name: String, parent: Option<usize>, kind: NodeKind, rest: (DVec3, DQuat, DVec3)) -> Self {
        let (translation, rotation, scale) = (None, None, None);
        Self {
            name,
            parent,
            kind,
            rest,
            translation,
            rotation,
            scale,
        }
    }

    fn node_to_parent(&self, seconds: f64) -> DMat4 {
        let vector = |track: &Option<Track<Vec3>>, rest| {
            track
                .as_ref()
                .map_or(rest, |track| track.at(seconds, |value| value.as_dvec3(), DVec3::lerp))
        };
        let rotation = self
            .rotation
            .as_ref()
            .map_or(self.rest.1, |track| track.at(seconds, unit, DQuat::slerp));
        DMat4::from_scale_rotation_translation(
            vector(&self.scale, self.rest.2),
            rotation.normalize(),
            vector(&self.translation, self.rest.0),
        )
    }
}

fn unit(rotation: &Quat) -> DQuat {
    rotation.as_dquat().normalize()
}

impl<'a, T: Clone> Track<'a, T> {
    fn of_keys(keys: &'a Keys<T>, ticks_per_second: f64) -> Option<Self> {
        let times = match &keys.ticks {
            None => Times::EveryTick(ticks_per_second),
            Some(ticks) => Times::Ticks(ticks, ticks_per_second),
        };
        (!keys.is_empty()).then(|| Self {
            times,
            values: Cow::Borrowed(keys.values.as_slice()),
        })
    }

    /// The value at `seconds`, interpolated between keys; beyond the ends that of the nearest key.
    fn at<V>(&self, seconds: f64, convert: impl Fn(&T) -> V, mix: impl Fn(V, V, f64) -> V) -> V {
        let last = self.values.len() - 1;
        // The first key after `seconds`.
        let next = match &self.times {
            // Whole ticks come from a division and may be off by a rounding, so a neighbouring key counts as exact.
            Times::EveryTick(rate) => (seconds * rate).floor().max(-1.0) as i64 as usize + 1,
            Times::Ticks(ticks, rate) => ticks.partition_point(|tick| tick / rate <= seconds),
            Times::Seconds(times) => times.partition_point(|time| f64::from(*time) <= seconds),
        };
        if next == 0 || next > last {
            return convert(&self.values[next.saturating_sub(1).min(last)]);
        }
        let time = |key: usize| match &self.times {
            Times::EveryTick(rate) => key as f64 / rate,
            Times::Ticks(ticks, rate) => ticks[key] / rate,
            Times::Seconds(times) => f64::from(times[key]),
        };
        let share = (seconds - time(next - 1)) / (time(next) - time(next - 1));
        mix(
            convert(&self.values[next - 1]),
            convert(&self.values[next]),
            share.clamp(0.0, 1.0),
        )
    }
}
