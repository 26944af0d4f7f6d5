//! Converts the animations of a file to tracks with linear interpolation.
//!
//! | glTF | keys |
//! |---|---|
//! | LINEAR | unchanged |
//! | STEP | each value twice: at its key, and at the last 32-bit time before the next key |
//! | CUBICSPLINE | samples of the curve, so close that linear interpolation is within [`CURVE_ERROR`] |
//! | KHR_animation_pointer to a node's translation, rotation or scale | like a channel of that node |

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion::unit;

use super::accessors::{Budget, numbers};
use super::file::{File, degenerate, implausible, is_degenerate, is_plausible};
use super::invalid::{invalid, missing};
use super::json::{Animation, Channel};
use crate::Failure;

/// The largest deviation of samples from a curve, as a fraction of the largest value of the track. For rotations, the
/// number limits the deviation of the unit quaternion.
pub(super) const CURVE_ERROR: f64 = 1e-6;

/// The largest number of samples between two keys of a curve.
const MOST_SAMPLES: usize = 4096;

/// The keys of one property of one node.
#[doc(hidden)]
pub struct Track {
    /// The index of the node in the file.
    #[doc(hidden)]
    pub node: usize,
    /// The times of the keys in seconds, strictly increasing.
    #[doc(hidden)]
    pub times: Vec<f32>,
    #[doc(hidden)]
    pub values: Values,
    /// The interpolation of the file and its key times in seconds, if the interpolation is not linear.
    #[doc(hidden)]
    pub bent: Option<(Bend, Vec<f32>)>,
}

/// The interpolation of a track that is not linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Bend {
    Step,
    Curve,
}

#[doc(hidden)]
pub enum Values {
    Translations(Vec<Vec3>),
    Rotations(Vec<Quat>),
    Scales(Vec<Vec3>),
}

impl Values {
    /// The count of numbers in one key.
    pub(crate) fn components(&self) -> u64 {
        match self {
            Self::Translations(_) | Self::Scales(_) => 3,
            Self::Rotations(_) => 4,
        }
    }
}

impl Track {
    /// Drops all keys but the first.
    pub(super) fn keep_first(&mut self) {
        self.times.truncate(1);
        self.bent = None;
        match &mut self.values {
            Values::Translations(values) | Values::Scales(values) => values.truncate(1),
            Values::Rotations(values) => values.truncate(1),
        }
    }

    /// The key times of the file in seconds.
    pub(super) fn key_times(&self) -> &[f32] {
        self.bent.as_ref().map_or(&self.times, |(_, times)| times)
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Property {
    Translation,
    Rotation,
    Scale,
}

impl File<'_> {
    /// The animations of the file.
    #[doc(hidden)]
    pub fn animations(&self) -> impl ExactSizeIterator<Item = &Animation> {
        self.root.animations.iter()
    }

    /// The tracks of an animation that animate nodes.
    ///
    /// # Errors
    /// A key is not valid. The error names the animation.
    #[doc(hidden)]
    pub fn tracks(&self, index: usize) -> Result<Vec<Track>, Failure> {
        let animation = &self.root.animations[index];
        let mut tracks = Vec::new();
        for (position, channel) in animation.channels.iter().enumerate() {
            let pointer = format!("/animations/{index}/channels/{position}");
            let target = self.target(channel, &pointer);
            let track = target.and_then(|target| match target {
                Some((node, property)) => self.track(index, channel, node, property).map(Some),
                None => Ok(None),
            });
            let name = |mut diagnostic: Failure| {
                if let Some(name) = animation.name.as_ref().filter(|name| !name.is_empty()) {
                    diagnostic.message = format!("animation \"{name}\": {}", diagnostic.message);
                }
                diagnostic
            };
            tracks.extend(track.map_err(name)?);
        }
        Ok(tracks)
    }

    /// The nodes that animations move.
    ///
    /// # Errors
    /// A node does not exist.
    pub(super) fn moved(&self) -> Result<Vec<usize>, Failure> {
        let mut moved = Vec::new();
        for (index, animation) in self.root.animations.iter().enumerate() {
            for (position, channel) in animation.channels.iter().enumerate() {
                let target = self.target(channel, &format!("/animations/{index}/channels/{position}"))?;
                moved.extend(target.map(|(node, _)| node));
            }
        }
        Ok(moved)
    }

    /// The node and the property that a channel moves; `None` if it moves something else.
    fn target(&self, channel: &Channel, pointer: &str) -> Result<Option<(usize, Property)>, Failure> {
        let extension = channel.target.extensions.get("KHR_animation_pointer");
        let named = extension.and_then(|extension| extension.get("pointer")?.as_str());
        let parts: Vec<&str> = named.map(|named| named.split('/').collect()).unwrap_or_default();
        let (node, path) = match (parts.as_slice(), channel.target.path.as_str(), channel.target.node) {
            (["", "nodes", node, path], "pointer", _) => (node.parse().ok(), *path),
            (_, path, node) => (node, path),
        };
        let property = match path {
            "translation" => Property::Translation,
            "rotation" => Property::Rotation,
            "scale" => Property::Scale,
            // Morph targets, and targets of extensions.
            _ => return Ok(None),
        };
        let count = self.root.nodes.len();
        match node {
            Some(node) if node >= count => Err(missing(format!("{pointer}/target/node"), "node", node, count).into()),
            // By the specification, a channel without a node is ignored.
            node => Ok(node.map(|node| (node, property))),
        }
    }

    fn track(&self, animation: usize, channel: &Channel, node: usize, property: Property) -> Result<Track, Failure> {
        let columns = if property == Property::Rotation { 4 } else { 3 };
        let ChannelKeys { keys, bend, output } = self.sampled(animation, channel, columns, columns)?;
        let is_scale = property == Property::Scale;
        if let Some(scale) = keys
            .values
            .iter()
            .find(|scale| is_scale && bend.is_none() && is_degenerate(**scale))
        {
            return Err(degenerate(output, *scale).into());
        }
        let key_times = keys.times.clone();
        let straight = keys.straight(bend, &self.bytes.budget, &output)?;
        let bends = bend.filter(|_| straight.times.len() != key_times.len());
        let vectors = || straight.values.chunks_exact(3).map(Vec3::from_slice).collect();
        let values = match property {
            Property::Rotation => Values::Rotations(rotations(&straight.values)),
            Property::Scale => Values::Scales(vectors()),
            Property::Translation => Values::Translations(vectors()),
        };
        Ok(Track {
            node,
            times: straight.times,
            values,
            bent: bends.map(|bend| (bend, key_times)),
        })
    }

    /// The keys of a channel, `width` numbers each, from an accessor with `columns` columns.
    pub(super) fn sampled(
        &self,
        animation: usize,
        channel: &Channel,
        columns: usize,
        width: usize,
    ) -> Result<ChannelKeys, Failure> {
        let samplers = &self.root.animations[animation].samplers;
        let pointer = format!("/animations/{animation}/samplers/{}", channel.sampler);
        let sampler = samplers
            .get(channel.sampler)
            .ok_or_else(|| missing(&*pointer, "sampler", channel.sampler, samplers.len()))?;
        let (input, output) = (format!("{pointer}/input"), format!("{pointer}/output"));
        let times = numbers(&self.root, &self.bytes, sampler.input, 1, &input)?;
        let values = numbers(&self.root, &self.bytes, sampler.output, columns, &output)?;
        check_times(&times, &input)?;
        let bend = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => None,
            Some("STEP") => Some(Bend::Step),
            Some("CUBICSPLINE") => Some(Bend::Curve),
            Some(other) => {
                let message = "glTF has no such interpolation";
                return Err(invalid(format!("{pointer}/interpolation"), message)
                    .expected_found("LINEAR, STEP or CUBICSPLINE", format!("\"{other}\""))
                    .into());
            }
        };
        let values_a_key = if bend == Some(Bend::Curve) { 3 } else { 1 };
        if values.len() != times.len() * width * values_a_key {
            let a_key = width / columns * values_a_key;
            let expected = format!("{} values for {} times", times.len() * a_key, times.len());
            return Err(
                invalid(output, "the number of values in the sampler does not match its times")
                    .expected_found(expected, format!("{}", values.len() / columns))
                    .into(),
            );
        }
        if let Some(number) = values.iter().find(|number| !is_plausible(**number)) {
            return Err(implausible(output, *number).into());
        }
        let keys = Keys {
            times,
            values,
            columns: width,
        };
        Ok(ChannelKeys { keys, bend, output })
    }
}

/// The keys of a channel as the file stores them, and the pointer to them.
pub(super) struct ChannelKeys {
    pub(super) keys: Keys,
    pub(super) bend: Option<Bend>,
    pub(super) output: String,
}

/// Unit quaternions. A quaternion of length 0 repeats the previous quaternion.
fn rotations(values: &[f32]) -> Vec<Quat> {
    let mut last = Quat::IDENTITY;
    let rotations = values.chunks_exact(4).map(|value| {
        last = unit(Quat::from_slice(value)).unwrap_or(last);
        last
    });
    rotations.collect()
}

fn check_times(times: &[f32], pointer: &str) -> Result<(), Failure> {
    let Some(first) = times.first() else {
        return Err(invalid(pointer, "the sampler has no key")
            .expected_found("at least 1", "0")
            .into());
    };
    if !(first.is_finite() && *first >= 0.0) {
        return Err(invalid(pointer, "a time must be a finite number of seconds, 0 or more")
            .expected_found("0 or more", format!("{first}"))
            .into());
    }
    match times
        .windows(2)
        .position(|pair| !(pair[0] < pair[1] && pair[1].is_finite()))
    {
        None => Ok(()),
        Some(key) => Err(invalid(pointer, "the times must increase from key to key")
            .expected_found(
                format!("a time after {}", times[key]),
                format!("{} at key {}", times[key + 1], key + 1),
            )
            .into()),
    }
}

/// The keys of a sampler. Curve keys have an in-tangent, a value and an out-tangent each.
pub(super) struct Keys {
    pub(super) times: Vec<f32>,
    pub(super) values: Vec<f32>,
    pub(super) columns: usize,
}

impl Keys {
    /// Keys whose linear interpolation gives the same motion as these keys.
    pub(super) fn straight(self, bend: Option<Bend>, budget: &Budget, pointer: &str) -> Result<Self, Failure> {
        match bend {
            None => Ok(self),
            Some(Bend::Step) => self.step(budget, pointer),
            Some(Bend::Curve) => self.curve(budget, pointer),
        }
    }

    fn push(&mut self, time: f32, value: &[f32]) {
        if self.times.last().is_none_or(|last| time > *last) {
            self.times.push(time);
            self.values.extend_from_slice(value);
        }
    }

    /// Keys whose linear interpolation gives the steps of these keys.
    fn step(&self, budget: &Budget, pointer: &str) -> Result<Self, Failure> {
        budget.take(self.values.len() as u64, pointer)?;
        let mut straight = Self {
            times: Vec::new(),
            values: Vec::new(),
            columns: self.columns,
        };
        let mut held: Option<&[f32]> = None;
        for (&time, value) in std::iter::zip(&self.times, self.values.chunks_exact(self.columns)) {
            if let Some(held) = held.filter(|held| *held != value) {
                straight.push(time.next_down(), held);
            }
            straight.push(time, value);
            held = Some(value);
        }
        Ok(straight)
    }

    /// Samples of the curve through these keys.
    fn curve(&self, budget: &Budget, pointer: &str) -> Result<Self, Failure> {
        let columns = self.columns;
        let mut straight = Self {
            times: Vec::new(),
            values: Vec::new(),
            columns,
        };
        let key = |key: usize| &self.values[3 * columns * key..3 * columns * (key + 1)];
        let last = self.times.len() - 1;
        let is_rotation = columns == 4;
        let most = self
            .values
            .iter()
            .fold(0.0, |most: f64, value| most.max(f64::from(value.abs())));
        let tolerance = CURVE_ERROR
            * if is_rotation {
                1.0
            } else {
                most.max(f64::from(f32::MIN_POSITIVE))
            };
        for index in 0..last {
            let segment = Segment {
                start: key(index),
                end: key(index + 1),
                seconds: f64::from(self.times[index + 1]) - f64::from(self.times[index]),
                columns,
            };
            let samples = segment.samples(tolerance);
            budget.take((samples * columns) as u64, pointer)?;
            let start = f64::from(self.times[index]);
            for sample in 0..samples {
                let time = (start + segment.seconds * sample as f64 / samples as f64) as f32;
                // Sample at the rounded 32-bit time, not at the exact time.
                let fraction = (f64::from(time) - start) / segment.seconds;
                let value = segment.at(fraction.clamp(0.0, 1.0)).map(|value| value as f32);
                straight.push(time, &value[..columns]);
            }
        }
        straight.push(self.times[last], &key(last)[columns..2 * columns]);
        if let Some(number) = straight.values.iter().find(|number| !is_plausible(**number)) {
            return Err(implausible(pointer.to_owned(), *number).into());
        }
        Ok(straight)
    }
}

/// The cubic curve from one key to the next.
struct Segment<'a> {
    start: &'a [f32],
    end: &'a [f32],
    seconds: f64,
    columns: usize,
}

impl Segment<'_> {
    /// The Hermite spline of glTF's appendix C. For rotations, the value is normalized to a unit quaternion.
    fn at(&self, t: f64) -> [f64; 4] {
        let (t2, t3) = (t * t, t * t * t);
        let columns = self.columns;
        let mut value = [0.0; 4];
        for (column, value) in value.iter_mut().enumerate().take(columns) {
            let start = f64::from(self.start[columns + column]);
            let out = self.seconds * f64::from(self.start[2 * columns + column]);
            let into = self.seconds * f64::from(self.end[column]);
            let end = f64::from(self.end[columns + column]);
            *value = (2.0 * t3 - 3.0 * t2 + 1.0) * start
                + (t3 - 2.0 * t2 + t) * out
                + (-2.0 * t3 + 3.0 * t2) * end
                + (t3 - t2) * into;
        }
        if columns == 4 {
            let length = value.iter().map(|value| value * value).sum::<f64>().sqrt();
            if length > 0.0 {
                value = value.map(|value| value / length);
            }
        }
        value
    }

    /// The number of linear pieces of equal duration that keep the curve within `tolerance`.
    fn samples(&self, tolerance: f64) -> usize {
        let mut samples = 1;
        loop {
            let error = self.error(samples);
            if error <= tolerance || samples >= MOST_SAMPLES || !error.is_finite() {
                return samples;
            }
            // The error decreases with the square of the number of pieces.
            let wanted = samples as f64 * (error / tolerance).sqrt();
            samples = (wanted.ceil() as usize).clamp(samples + 1, MOST_SAMPLES);
        }
    }

    /// The largest distance of the curve from `samples` linear pieces, measured at their quarters.
    fn error(&self, samples: usize) -> f64 {
        let mut largest = 0.0_f64;
        let mut start = self.at(0.0);
        for sample in 0..samples {
            let at = |fraction: f64| (sample as f64 + fraction) / samples as f64;
            let end = self.at(at(1.0));
            for fraction in [0.25, 0.5, 0.75] {
                let (curve, straight) = (self.at(at(fraction)), mixed(start, end, fraction, self.columns == 4));
                let squares: f64 = std::iter::zip(curve, straight).map(|(a, b)| (a - b) * (a - b)).sum();
                // For a rotation, the angle is twice the distance.
                largest = largest.max(squares.sqrt() * if self.columns == 4 { 2.0 } else { 1.0 });
            }
            start = end;
        }
        largest
    }
}

/// The interpolated value between two keys: on the line, or for rotations on the arc.
fn mixed(start: [f64; 4], end: [f64; 4], fraction: f64, is_rotation: bool) -> [f64; 4] {
    if is_rotation {
        let (start, end) = (glam::DQuat::from_array(start), glam::DQuat::from_array(end));
        let mixed = start.slerp(end, fraction);
        // A quaternion and its negative are the same rotation; the curve must not jump.
        return if mixed.dot(start) < 0.0 { -mixed } else { mixed }.to_array();
    }
    std::array::from_fn(|column| start[column] + fraction * (end[column] - start[column]))
}
