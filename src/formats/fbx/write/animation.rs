//! Writes the clips: a stack with one layer for each, and curves of angles, positions and scales.
//!
//! A curve has a key at every tick of its track, and is linear between keys. Positions of a scene are also linear, but
//! rotations follow an arc. So a track of rotations with fewer keys gets a key at every frame. With an error bound,
//! [`curves`](super::curves) drops keys.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, Quat, Vec3};
use mocap_scene::error::{Code, Result};
use mocap_scene::limits::{self, FARTHEST, is_plausible};
use mocap_scene::pose::Binding;
use mocap_scene::scene::{Animation, Channel, Keys, Scene, UNNAMED_MOTION};

use super::curves::{Curve, Part, ReducedClip};
use super::document::{Document, Id};
use super::encode::{Array, Element};
use super::names::Names;
use super::properties::Properties;
use super::skeleton::Placed;
use super::space::Space;
use super::time::{Rate, end, key_times, time};
use super::{FbxOptions, FbxReport, unrepresentable};

/// FBX's flag of linear interpolation.
const LINEAR: i32 = 4;

/// The weights of tangents, as other programs write them for linear keys: two 16-bit numbers, in which 9,999 is 1.
const TANGENT_WEIGHTS: u32 = 0x0d05_0d05;

/// The written clips.
#[derive(Default)]
pub(super) struct Clips {
    /// The names of the clips, and the times of their ends.
    pub(super) ends: Vec<(String, i64)>,
    /// The layers of the clips.
    pub(super) layers: Vec<Layer>,
    /// The nodes with animated positions, and the largest distance of each from its rest position, relative to the
    /// parent.
    pub(super) moving: BTreeMap<usize, f64>,
}

/// The layer of a clip.
pub(super) struct Layer {
    pub(super) id: Id,
    /// Ticks per second.
    pub(super) rate: f64,
}

/// Adds the clips of `scene`. `names` has the names of other clips in the file.
pub(super) fn write(
    scene: &Scene,
    space: &Space,
    placed: &[Placed],
    options: &FbxOptions,
    names: &mut Names,
    document: &mut Document<'_>,
    report: &mut FbxReport,
) -> Result<Clips> {
    let mut clips = Clips::default();
    for animation in &scene.animations {
        let rate = Rate::new(animation.ticks_per_second, options)?.frames_per_second();
        let name = names.unique(scene.metadata.clip_name(animation), UNNAMED_MOTION);
        let reduced = options
            .error_bound
            .as_ref()
            .map(|bound| ReducedClip::new(scene, animation, space, placed, bound))
            .transpose()?;
        if let Some(reduced) = &reduced {
            reduced.add_error(scene, &mut report.achieved);
        }
        let duration = limits::not_negative(Code::Unrepresentable, "the duration in ticks", animation.duration)?;
        let end = end(duration, rate)?;
        let span = Properties::new()
            .time("LocalStart", 0)
            .time("LocalStop", end)
            .time("ReferenceStart", 0)
            .time("ReferenceStop", end);
        let (stack, element) = document.object("AnimationStack", [&name, "AnimStack", ""]);
        document.add("AnimationStack", element.child(span.element()));
        // Use the name of the stack: Blender joins the names of stack and layer if they differ.
        let (layer, element) = document.object("AnimationLayer", [&name, "AnimLayer", ""]);
        document.add("AnimationLayer", element.block());
        document.connect(layer, stack);
        let mut clip = Clip {
            scene,
            space,
            document,
            report,
            layer,
            rate,
            last: duration,
            whole: None,
        };
        clip.curves(animation, placed, reduced.as_ref(), &mut clips.moving)?;
        clips.ends.push((name, end));
        clips.layers.push(Layer { id: layer, rate });
    }
    Ok(clips)
}

/// A clip under construction.
struct Clip<'a, 'd, 'e> {
    scene: &'a Scene,
    space: &'a Space,
    document: &'d mut Document<'e>,
    report: &'d mut FbxReport,
    layer: Id,
    rate: f64,
    /// The last tick.
    last: f64,
    /// The number of ticks 0, 1, 2, ... and the array of their times.
    whole: Option<(usize, Array)>,
}

/// A track as three curves.
struct Track {
    part: Part,
    /// The value of the model's property in the rest pose.
    rest: DVec3,
    curves: [Curve; 3],
}

impl Track {
    /// The largest distance of the values from the rest value, estimated by the diagonal of their bounding box.
    fn farthest(&self) -> f64 {
        let of_axis = |axis: usize| {
            let differences = self.curves[axis]
                .values
                .iter()
                .map(|value| (value - self.rest[axis]).abs());
            differences.fold(0.0, f64::max)
        };
        DVec3::from_array(std::array::from_fn(of_axis)).length()
    }
}

impl Clip<'_, '_, '_> {
    fn curves(
        &mut self,
        animation: &Animation,
        placed: &[Placed],
        reduced: Option<&ReducedClip<'_>>,
        moving: &mut BTreeMap<usize, f64>,
    ) -> Result<()> {
        let binding = Binding::new(self.scene, animation);
        let mut is_empty = true;
        for (node, channel) in binding.driven() {
            let node_at_rest = &placed[node.index()];
            if node_at_rest.id == super::document::SCENE_ROOT {
                continue;
            }
            let channel = &animation.channels[channel];
            for mut track in self.tracks(node_at_rest, channel)? {
                if let Some(curves) = reduced.and_then(|reduced| reduced.curves(node.index(), node_at_rest, track.part))
                {
                    track.curves = curves;
                }
                let says_more = self.write(node_at_rest.id, &track, false)?;
                is_empty &= !says_more;
                if says_more && matches!(track.part, Part::Translation) {
                    let farthest = moving.entry(node.index()).or_default();
                    *farthest = farthest.max(track.farthest());
                }
            }
        }
        // A clip without any curve gets one curve with rest values, so that the clip keeps its duration.
        let mut placed = placed.iter();
        if is_empty
            && let Some(node_at_rest) = placed.find(|node_at_rest| node_at_rest.id != super::document::SCENE_ROOT)
        {
            let track = Track {
                part: Part::Translation,
                rest: node_at_rest.translation,
                curves: Curve::of_vectors(None, &[node_at_rest.translation]),
            };
            self.write(node_at_rest.id, &track, true)?;
        }
        Ok(())
    }

    /// The tracks of a channel, converted to values of the model's properties.
    fn tracks(&self, node_at_rest: &Placed, channel: &Channel) -> Result<Vec<Track>> {
        let mut tracks = Vec::new();
        let refuse = |tick: f64, what: &str| {
            unrepresentable(
                &channel.node_name,
                format!("the {what} at tick {tick} is not finite, or beyond {FARTHEST:e}"),
            )
        };
        let is_sound = |vector: Vec3| vector.to_array().into_iter().all(|value| is_plausible(value.into()));
        if !channel.position_keys.is_empty() {
            let keys = &channel.position_keys;
            let values = values(keys, |value| is_sound(value).then(|| self.space.point(value)))
                .map_err(|tick| refuse(tick, "position"))?;
            tracks.push(Track {
                part: Part::Translation,
                rest: node_at_rest.translation,
                curves: Curve::of_vectors(keys.ticks.as_ref(), &values),
            });
        }
        if !channel.rotation_keys.is_empty() {
            let dense = self.dense(&channel.rotation_keys);
            let keys = dense.as_ref().unwrap_or(&channel.rotation_keys);
            let rest = node_at_rest.angles_at_rest();
            let mut before = rest;
            let next = |value: Quat| {
                let rotation: DQuat = self.space.rotation(value)?;
                before = node_at_rest.angles(rotation, before);
                Some(before)
            };
            let values = values(keys, next).map_err(|tick| {
                let message = format!("the quaternion at tick {tick} is not a rotation");
                unrepresentable(&channel.node_name, message)
            })?;
            tracks.push(Track {
                part: Part::Rotation,
                rest,
                curves: Curve::of_vectors(keys.ticks.as_ref(), &values),
            });
        }
        if !channel.scaling_keys.is_empty() {
            let keys = &channel.scaling_keys;
            let values = values(keys, |value| is_sound(value).then(|| self.space.scale(value)))
                .map_err(|tick| refuse(tick, "scale"))?;
            tracks.push(Track {
                part: Part::Scaling,
                rest: node_at_rest.scale,
                curves: Curve::of_vectors(keys.ticks.as_ref(), &values),
            });
        }
        Ok(tracks)
    }

    /// The track of rotations with a key at every whole tick; `None` if it already has these keys.
    fn dense(&self, keys: &Keys<Quat>) -> Option<Keys<Quat>> {
        let own = keys.ticks.as_ref().filter(|own| own.len() > 1)?;
        let whole = own[0].ceil() as u64..=own[own.len() - 1].min(self.last).floor() as u64;
        let mut ticks: Vec<f64> = whole.map(|tick| tick as f64).chain(own.iter().copied()).collect();
        ticks.sort_unstable_by(f64::total_cmp);
        ticks.dedup();
        let values = ticks.iter().filter_map(|tick| keys.sample(*tick)).collect();
        Some(Keys::at_ticks(values, ticks))
    }

    /// Adds the curves of a track if it leaves the rest pose, or in any case with `all`. Returns whether curves were
    /// added. All three axes get a curve, because the importer built into Blender 5.0 ignores a rotation that lacks a
    /// curve.
    fn write(&mut self, model: Id, track: &Track, all: bool) -> Result<bool> {
        // Compare in single precision.
        let is_rest = |axis: usize| {
            let curve = &track.curves[axis];
            curve.is_constant() && curve.values[0] as f32 == track.rest[axis] as f32
        };
        if !all && (0..3).all(is_rest) {
            return Ok(false);
        }
        let [x, y, z] = track.rest.to_array();
        let defaults = Properties::new().number("d|X", x).number("d|Y", y).number("d|Z", z);
        let name = track.part.curve_node();
        let (node, element) = self.document.object("AnimationCurveNode", [name, "AnimCurveNode", ""]);
        self.document
            .add("AnimationCurveNode", element.child(defaults.element()));
        self.document.connect(node, self.layer);
        self.document.connect_property(node, model, track.part.property());
        for axis in 0..3 {
            let curve = &track.curves[axis];
            let count = if curve.is_constant() { 1 } else { curve.values.len() };
            let times = match &curve.ticks {
                None => self.whole_times(count),
                Some(ticks) => Array::longs(key_times(&ticks[..count], self.rate)),
            };
            let values = curve.values[..count].iter().map(|value| *value as f32);
            let curve = add_curve(self.document, track.rest[axis], times, values);
            self.document.connect_property(curve, node, ["d|X", "d|Y", "d|Z"][axis]);
            self.report.curves += 1;
            self.report.keys += count;
        }
        Ok(true)
    }

    /// The times of the ticks 0, 1, 2, ..., shared by all curves.
    fn whole_times(&mut self, count: usize) -> Array {
        match &self.whole {
            Some((known, times)) if *known == count => times.clone(),
            _ => {
                let times = Array::longs((0..count).map(|tick| time(tick as f64, self.rate)));
                if count > 1 {
                    self.whole = Some((count, times.clone()));
                }
                times
            }
        }
    }
}

/// Adds a curve with linear keys at these times.
pub(super) fn add_curve(
    document: &mut Document<'_>,
    at_rest: f64,
    times: Array,
    values: impl ExactSizeIterator<Item = f32>,
) -> Id {
    let count = values.len();
    let (curve, element) = document.object("AnimationCurve", ["", "AnimCurve", ""]);
    let element = element
        .child(Element::of("Default", at_rest))
        .child(Element::of("KeyVer", 4008))
        .child(Element::of("KeyTime", times))
        .child(Element::of("KeyValueFloat", Array::floats(values)))
        .child(Element::of("KeyAttrFlags", Array::ints([LINEAR])))
        .child(Element::of(
            "KeyAttrDataFloat",
            Array::floats([0.0, 0.0, f32::from_bits(TANGENT_WEIGHTS), 0.0]),
        ))
        .child(Element::of("KeyAttrRefCount", Array::ints([count as i32])));
    document.add("AnimationCurve", element);
    curve
}

/// The value of each key, or as error the tick of the first key without a value.
fn values<T: Copy>(keys: &Keys<T>, mut value: impl FnMut(T) -> Option<DVec3>) -> Result<Vec<DVec3>, f64> {
    let values = keys.values.iter().enumerate();
    values
        .map(|(index, key)| value(*key).ok_or_else(|| keys.tick(index)))
        .collect()
}
