//! Writes channels: animated tracks become samplers. A constant track becomes part of the node if its value is the
//! node's rest value.

use std::sync::Arc;

use glam::{Quat, Vec3};
use gltf_json::Index;
use gltf_json::accessor::{Accessor, ComponentType};
use gltf_json::animation::Property;
use mocap_compress::{CompressedClip, KeyFrames, RotationFormat, Track, TranslationFormat, compress};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::positive;
use mocap_scene::pose::Binding;
use mocap_scene::scene::{self, Keys, Scene};

use super::super::compression::Compression;
use super::super::meshopt::{self, Filter};
use super::buffer::{Buffer, Usage};
use super::rest::Rest;
use super::text::{Animation, Channel, Sampler, Target};
use super::values::{Value, is_constant, nearly_constant_scale, rounded_unit, with_middles, without_noise};
use super::{GltfOptions, GltfReport};
use crate::report::Deviation;

/// The treatment of the file's nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nodes {
    /// The nodes take all constant tracks of the only animation, because a skin has the rest pose.
    OfOneSkinnedAnimation,
    /// The nodes have the rest pose, so the nodes take only the constant scales, and the constant tracks that equal the
    /// rest pose.
    OfOneAnimation,
    /// The nodes have taken the tracks that several animations share: [`rest::of_all`](super::rest::of_all).
    OfAllAnimations,
    /// The nodes have the T-pose of a VRM animation. All nodes but the root keep their positions.
    TPose,
    /// The nodes belong to a file that is passed through, and stay unchanged. Even constant rotations are channels,
    /// because another clip of the file may have rotated the joint.
    PassedThrough,
}

/// Writes the animation of a scene, track by track.
struct Writer<'a> {
    scene: &'a Scene,
    ticks_per_second: f64,
    nodes: Nodes,
    options: &'a GltfOptions,
    buffer: &'a mut Buffer,
    report: &'a mut GltfReport,
    clocks: Vec<Clock<'a>>,
    /// The key frames of compressed tracks, and the accessor of their times.
    key_times: Vec<(Arc<KeyFrames>, Index<Accessor>)>,
    samplers: Vec<Sampler>,
    channels: Vec<Channel>,
}

/// One accessor of times, shared by all tracks with keys at the same ticks.
struct Clock<'a> {
    ticks: Option<&'a [f64]>,
    len: usize,
    accessor: Index<Accessor>,
    /// The indices of the keys that are written, if 32-bit floats cannot distinguish all times.
    kept: Option<Vec<usize>>,
}

/// Writes `animation`. Constant tracks move to `rest`, the rest transforms of the scene's nodes, if `nodes` take them.
///
/// Returns `None` if no node of the scene has a key.
pub(super) fn write(
    scene: &Scene,
    animation: &scene::Animation,
    rest: &mut [Rest],
    nodes: Nodes,
    options: &GltfOptions,
    buffer: &mut Buffer,
    report: &mut GltfReport,
) -> Result<Option<Animation>> {
    let ticks_per_second = positive(Code::FrameTime, "ticks per second", animation.ticks_per_second)?;
    let with_middles: Vec<Option<Keys<Quat>>> = animation
        .channels
        .iter()
        .map(|channel| with_middles(&channel.rotation_keys))
        .collect();
    let (clocks, key_times, samplers, channels) = Default::default();
    let mut writer = Writer {
        scene,
        ticks_per_second,
        nodes,
        options,
        buffer,
        report,
        clocks,
        key_times,
        samplers,
        channels,
    };
    let compressed = compressed(scene, animation, nodes, options)?;
    if let Some(clip) = &compressed {
        writer.report.add_error(scene, clip);
    }
    let mut first_driven = None;
    let mut is_driven = vec![false; scene.nodes.len()];
    for (node, channel) in Binding::new(scene, animation).driven() {
        let node = node.index();
        first_driven.get_or_insert(node);
        let rotation_keys = with_middles[channel].as_ref();
        let channel = &animation.channels[channel];
        let rotation_keys = rotation_keys.unwrap_or(&channel.rotation_keys);
        let rest = &mut rest[node];
        match &compressed {
            Some(clip) => writer.compressed(node, clip, rest),
            None => {
                rest.translation =
                    writer.track(node, Property::Translation, &channel.position_keys, rest.translation)?;
                rest.rotation = writer.track(node, Property::Rotation, rotation_keys, rest.rotation)?;
            }
        }
        // A constant scale becomes part of the node if possible, even if constant tracks are kept.
        let nearly = compressed
            .as_ref()
            .and_then(|_| nearly_constant_scale(&channel.scaling_keys));
        let moves = nearly.is_none() && !is_constant(&channel.scaling_keys);
        if moves || !options.keep_constant || !writer.takes_constants() {
            match nearly {
                Some(scale) => writer.constant(node, Property::Scale, scale, &mut rest.scale, scale.to_array()),
                None => rest.scale = writer.track(node, Property::Scale, &channel.scaling_keys, rest.scale)?,
            }
        } else if let Some(scale) = nearly.or(channel.scaling_keys.values.first().copied())
            && scale.is_finite()
        {
            rest.scale = without_noise(scale);
        }
        is_driven[node] = true;
    }
    if let Some(clip) = compressed.as_ref().filter(|_| writer.takes_constants()) {
        // A node without a channel is rounded like the other nodes.
        for (node, track) in clip.tracks.iter().enumerate().filter(|(node, _)| !is_driven[*node]) {
            if let (Track::Constant(translation), Track::Constant(rotation)) = (&track.translation, &track.rotation) {
                rest[node] = Rest {
                    translation: *translation + Vec3::ZERO,
                    rotation: rounded_unit(*rotation),
                    scale: without_noise(rest[node].scale),
                };
            }
        }
    }
    if writer.clocks.iter().all(|clock| clock.len == 1)
        && writer.key_times.is_empty()
        && let Some(node) = first_driven
    {
        writer.hold(node, &rest[node], animation.duration);
    }
    let (samplers, channels) = (writer.samplers, writer.channels);
    if channels.is_empty() {
        return Ok(None);
    }
    Ok(Some(Animation {
        name: None,
        channels,
        samplers,
        extras: None,
    }))
}

/// The animation, compressed by `options`; `None` if the options request no compression.
fn compressed(
    scene: &Scene,
    animation: &scene::Animation,
    nodes: Nodes,
    options: &GltfOptions,
) -> Result<Option<CompressedClip>> {
    if cfg!(not(feature = "meshopt")) && options.compression.extension().is_some() {
        return Err(meshopt::missing().into());
    }
    // An unchanged node keeps all decimals of its values, so the bound must hold with all decimals.
    let encoding = match nodes {
        Nodes::PassedThrough => options.compression.encoding_with_exact_constants(),
        _ => options.compression.encoding(),
    };
    let bound = options.bound();
    bound
        .map(|bound| compress(scene, animation, &bound, encoding))
        .transpose()
}

impl GltfReport {
    /// Adds the error of another animation.
    fn add_error(&mut self, scene: &Scene, clip: &CompressedClip) {
        Deviation::add(&mut self.achieved, scene, clip, 1.0);
    }
}

impl<'a> Writer<'a> {
    /// Whether a constant track becomes the value of its node. Without a skin, a position or rotation that differs from
    /// the rest pose stays a track.
    fn sets_rest<T: Value<N>, const N: usize>(&self, property: Property, value: T, rest: T) -> bool {
        match self.nodes {
            Nodes::OfOneSkinnedAnimation => true,
            Nodes::OfOneAnimation => property == Property::Scale || value.is_of_rest(rest),
            _ => false,
        }
    }

    /// Whether nodes take constant tracks.
    fn takes_constants(&self) -> bool {
        matches!(self.nodes, Nodes::OfOneAnimation | Nodes::OfOneSkinnedAnimation)
    }

    /// Whether a constant track is written as a channel even if the node has the same value.
    fn keeps_constant(&self, property: Property) -> bool {
        let is_kept = self.nodes == Nodes::PassedThrough && property == Property::Rotation;
        self.options.keep_constant || is_kept
    }

    /// Writes one track if it is animated, and returns the rest value of the node.
    fn track<T: Value<N>, const N: usize>(
        &mut self,
        node: usize,
        property: Property,
        keys: &'a Keys<T>,
        rest: T,
    ) -> Result<T> {
        let Some(&first) = keys.values.first() else {
            return Ok(rest);
        };
        let invalid = || {
            let message = format!("a {} is not finite", name_of(property));
            Diagnostic::new(Code::Unrepresentable, message).in_joint(&self.scene.nodes[node].name)
        };
        if is_constant(keys) {
            let values = T::to_arrays(&mut std::iter::once(first)).ok_or_else(invalid)?;
            self.report.constant_tracks += 1;
            let value = T::from(values[0]);
            let sets_rest = self.sets_rest(property, value, rest);
            // The scale of a node in the file comes from its matrix, so it is rounded.
            let is_rounded = self.nodes == Nodes::PassedThrough && property == Property::Scale;
            let is_rest = value.is_same(rest) || is_rounded && value.is_of_rest(rest);
            if self.keeps_constant(property) || !(sets_rest || is_rest) {
                let clock = self.clock(None, 1);
                self.channel(node, property, clock, &values);
            }
            return Ok(if sets_rest { value } else { rest });
        }
        let clock = self.clock(keys.ticks.as_deref(), keys.len());
        let values = match &self.clocks[clock].kept {
            None => T::to_arrays(&mut keys.values.iter().copied()),
            Some(kept) => T::to_arrays(&mut kept.iter().map(|key| keys.values[*key])),
        };
        let values = values.ok_or_else(invalid)?;
        self.report.animated_tracks += 1;
        self.report.dropped_keys += keys.len() - values.len();
        self.channel(node, property, clock, &values);
        Ok(rest)
    }

    /// Writes a constant track, so that a take without motion keeps its length and a pose stays an animation. The track
    /// belongs to the node's first property without a track.
    fn hold(&mut self, node: usize, rest: &Rest, duration: f64) {
        let end = (duration / self.ticks_per_second) as f32;
        // A time that 32 bits cannot distinguish from 0 would be a second key at the same time.
        let times = if end > 0.0 { vec![[0.0], [end]] } else { vec![[0.0]] };
        // Uncompressed, so that a file without motion needs no extension.
        let input = self.buffer.push_times(Compression::None, &times);
        let has = |property| {
            let is_it = |channel: &Channel| {
                channel.target.node == Index::new(node as u32) && channel.target.path == name_of(property)
            };
            self.channels.iter().any(is_it)
        };
        let free = [Property::Rotation, Property::Translation]
            .into_iter()
            .find(|property| !has(*property));
        let property = free.unwrap_or(Property::Scale);
        let output = match property {
            Property::Rotation => self
                .buffer
                .push(Usage::Keys, &vec![rest.rotation.to_array(); times.len()]),
            Property::Translation => self
                .buffer
                .push(Usage::Keys, &vec![rest.translation.to_array(); times.len()]),
            _ => self.buffer.push(Usage::Keys, &vec![rest.scale.to_array(); times.len()]),
        };
        self.sampler(node, property, input, output);
    }

    /// The clock for keys at `ticks`, shared by all tracks with these ticks.
    fn clock(&mut self, ticks: Option<&'a [f64]>, len: usize) -> usize {
        if let Some(known) = self
            .clocks
            .iter()
            .position(|clock| clock.len == len && clock.ticks == ticks)
        {
            return known;
        }
        let mut times: Vec<[f32; 1]> = Vec::with_capacity(len);
        let mut kept = Vec::new();
        for key in 0..len {
            let tick = ticks.map_or(key as f64, |ticks| ticks[key]);
            let time = (tick / self.ticks_per_second) as f32;
            if times.last().is_none_or(|last| time > last[0]) {
                times.push([time]);
                kept.push(key);
            }
        }
        let accessor = self.buffer.push_times(Compression::None, &times);
        let kept = (kept.len() < len).then_some(kept);
        self.clocks.push(Clock {
            ticks,
            len,
            accessor,
            kept,
        });
        self.clocks.len() - 1
    }

    fn channel<const N: usize>(&mut self, node: usize, property: Property, clock: usize, values: &[[f32; N]]) {
        let input = self.clocks[clock].accessor;
        let output = self.buffer.push(Usage::Keys, values);
        self.sampler(node, property, input, output);
    }

    /// Writes the tracks of one node, and sets its constant values.
    fn compressed(&mut self, node: usize, clip: &CompressedClip, rest: &mut Rest) {
        let track = &clip.tracks[node];
        match &track.translation {
            Track::Constant(value) => {
                let value = *value + Vec3::ZERO;
                self.constant(
                    node,
                    Property::Translation,
                    value,
                    &mut rest.translation,
                    value.to_array(),
                );
            }
            Track::Animated {
                format,
                key_frames,
                keys,
            } => {
                let output = match format {
                    TranslationFormat::Float32 => {
                        let values: Vec<_> = keys.iter().map(|key| key.value.to_array()).collect();
                        self.buffer.push(Usage::Keys, &values)
                    }
                    TranslationFormat::ExponentialFilter(_) | TranslationFormat::Multiples(_) => {
                        let stored: Vec<_> = keys.iter().map(|key| key.stored).collect();
                        self.buffer
                            .push_stream(Filter::Exponential, ComponentType::F32, &stored)
                    }
                };
                self.animated(node, Property::Translation, clip, key_frames, output);
            }
        }
        match &track.rotation {
            Track::Constant(value) => {
                let value = rounded_unit(*value);
                self.constant(node, Property::Rotation, value, &mut rest.rotation, value.to_array());
            }
            Track::Animated {
                format,
                key_frames,
                keys,
            } => {
                let stored = || keys.iter().map(|key| key.stored).collect::<Vec<_>>();
                let output = match format {
                    RotationFormat::Float32 => {
                        let values: Vec<_> = keys.iter().map(|key| key.value.to_array().map(|c| c + 0.0)).collect();
                        self.buffer.push(Usage::Keys, &values)
                    }
                    RotationFormat::Int16 => self.buffer.push_normalized(Usage::Keys, &stored()),
                    RotationFormat::QuaternionFilter(_) | RotationFormat::SmallestThree(_) => {
                        self.buffer
                            .push_stream(Filter::Quaternion, ComponentType::I16, &stored())
                    }
                };
                self.animated(node, Property::Rotation, clip, key_frames, output);
            }
        }
    }

    fn constant<T: Value<N>, const N: usize>(
        &mut self,
        node: usize,
        property: Property,
        value: T,
        rest: &mut T,
        array: [f32; N],
    ) {
        self.report.constant_tracks += 1;
        // A rounded position still counts as the rest position.
        let is_bone = self.scene.nodes[node].face.is_none();
        if self.nodes == Nodes::TPose && property == Property::Translation && node > 0 && is_bone {
            return;
        }
        let sets_rest = self.sets_rest(property, value, *rest);
        if self.keeps_constant(property) || !(sets_rest || value.is_same(*rest)) {
            let clock = self.clock(None, 1);
            self.channel(node, property, clock, &[array]);
        }
        if sets_rest {
            *rest = value;
        }
    }

    fn animated(
        &mut self,
        node: usize,
        property: Property,
        clip: &CompressedClip,
        key_frames: &Arc<KeyFrames>,
        output: Index<Accessor>,
    ) {
        let known = self.key_times.iter().find(|(known, _)| known == key_frames);
        let input = match known {
            Some((_, accessor)) => *accessor,
            None => {
                let time = |frame: &u32| [(clip.ticks[*frame as usize] / self.ticks_per_second) as f32];
                let times: Vec<_> = key_frames.iter().map(time).collect();
                let accessor = self.buffer.push_times(self.options.compression, &times);
                self.key_times.push((Arc::clone(key_frames), accessor));
                accessor
            }
        };
        self.report.animated_tracks += 1;
        self.sampler(node, property, input, output);
    }

    fn sampler(&mut self, node: usize, property: Property, input: Index<Accessor>, output: Index<Accessor>) {
        self.channels.push(Channel {
            sampler: self.samplers.len(),
            target: Target {
                node: Index::new(node as u32),
                path: name_of(property),
            },
        });
        self.samplers.push(Sampler { input, output });
    }
}

fn name_of(property: Property) -> &'static str {
    match property {
        Property::Rotation => "rotation",
        Property::Scale => "scale",
        Property::Translation | Property::MorphTargetWeights => "translation",
    }
}
