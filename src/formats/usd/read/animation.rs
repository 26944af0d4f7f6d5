//! The animations of a skeleton.

use std::collections::{HashMap, HashSet};

use glam::{Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{FrameBudget, is_plausible};
use mocap_scene::math::quaternion::{in_hemisphere_of, unit};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Animation, Channel, Keys, NodeId, UNNAMED_MOTION};

use super::metadata_number;
use super::skeleton::Skeleton;
use crate::usd::parse::{Attribute, Layer, Prim, Value};
use crate::usd::{DURATION, RATE};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// Time codes per second if the layer states none: USD's default.
const DEFAULT_RATE: f64 = 24.0;

/// The largest difference between a tick and a whole tick that count as equal, because time codes are rounded.
const WHOLE: f64 = 1e-9;

/// The weights of an animation by the names of blend shapes.
pub(super) type Weights = HashMap<String, Keys<f32>>;

/// The animations of the skeleton or of the blend shapes of meshes. The animation that is bound comes first.
pub(super) fn read(
    layer: &Layer<'_>,
    skeleton: &Skeleton,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<(Vec<Animation>, Vec<Weights>), Failure> {
    let mut found = Vec::new();
    let mut budget = FrameBudget::stated_by(&options.limits, layer.text.len() as u64);
    for (index, prim) in layer
        .prims
        .iter()
        .enumerate()
        .filter(|(_, prim)| prim.kind == "SkelAnimation")
    {
        let is_bound = skeleton.source.as_deref() == Some(&layer.path(index));
        let times = Times::of(layer, prim, skeleton, options)?;
        let mut joints = prim.texts("joints").iter();
        let shapes = prim.texts("blendShapes");
        if joints.any(|joint| skeleton.joints.contains_key(joint)) || !shapes.is_empty() {
            times.check(layer, prim, skeleton.nodes.len() + shapes.len(), &mut budget)?;
        }
        let weights = times.weights(layer, index, warnings);
        if let Some(animation) = times.animation(prim, skeleton, !weights.is_empty(), warnings)? {
            found.push((!is_bound, animation, weights));
        }
    }
    if found.is_empty() && !skeleton.path.is_empty() {
        let still = Prim::default();
        let times = Times::of(layer, &still, skeleton, options)?;
        let animation = times.with_path(skeleton, Animation::default());
        found.push((true, animation, Weights::new()));
    }
    // The sort is stable, so the other animations keep the order of the file.
    found.sort_by_key(|(is_other, ..)| *is_other);
    let found = found.into_iter().map(|(_, animation, weights)| (animation, weights));
    Ok(found.unzip())
}

/// The number of blend shapes whose weight changes in any animation.
pub(super) fn moving_shapes(layer: &Layer<'_>) -> usize {
    let animations = layer.prims.iter().filter(|prim| prim.kind == "SkelAnimation");
    let moving = animations.flat_map(|prim| {
        let weights = prim.attributes.get("blendShapeWeights");
        let samples = weights.map_or(&[][..], |weights| &weights.samples);
        let varies = move |column: usize| {
            let at = |(_, value): &(f64, Value)| value.numbers.get(column).map(|weight| weight.to_bits());
            samples.windows(2).any(|pair| at(&pair[0]) != at(&pair[1]))
        };
        let names = prim.texts("blendShapes").iter().enumerate();
        names.filter(move |(column, _)| varies(*column)).map(|(_, name)| name)
    });
    moving.collect::<HashSet<_>>().len()
}

/// The time samples of all attributes.
fn samples(prim: &Prim) -> impl Iterator<Item = &(f64, Value)> {
    prim.attributes.values().flat_map(|attribute| &attribute.samples)
}

fn attribute_value<'a>(prim: &'a Prim, name: &str) -> Option<&'a Value> {
    prim.attributes.get(name)?.value.as_ref()
}

/// The ticks of an attribute, and at each tick N numbers for every joint.
type Track<const N: usize> = (Vec<f64>, Vec<Vec<[f32; N]>>);

/// Converts time codes to ticks.
struct Times {
    /// Ticks per time code.
    ticks: f64,
    /// The time code of the first tick.
    start: f64,
    /// Ticks per second.
    rate: f64,
    duration: Option<f64>,
}

impl Times {
    fn of(layer: &Layer<'_>, prim: &Prim, skeleton: &Skeleton, options: &ReadOptions) -> Result<Self, Failure> {
        let own = |name: &str| attribute_value(prim, name)?.numbers.first().copied();
        let codes = metadata_number(layer, "timeCodesPerSecond").or(metadata_number(layer, "framesPerSecond"));
        let codes = codes.unwrap_or(DEFAULT_RATE);
        let stated = own(RATE).unwrap_or(codes);
        let rate = options.frame_rate_or(stated)?;
        let ticks = stated / codes;
        if !(ticks.is_finite() && ticks > 0.0) {
            let message = format!("timeCodesPerSecond must be finite and above 0, got {codes}");
            return Err(Diagnostic::new(Code::FrameTime, message).into());
        }
        let path = skeleton.path.iter().map(|(time, _)| *time);
        let start = samples(prim)
            .map(|(time, _)| *time)
            .chain(path)
            .fold(f64::INFINITY, f64::min);
        let start = if start.is_finite() { start } else { 0.0 };
        Ok(Self {
            ticks,
            start: metadata_number(layer, "startTimeCode")
                .filter(|stated| *stated <= start)
                .unwrap_or(start),
            rate,
            duration: own(DURATION).filter(|duration| duration.is_finite() && *duration >= 0.0),
        })
    }

    /// Checks the length of an animation against the limits. The error states the location of the value that makes the
    /// animation too long.
    fn check(&self, layer: &Layer<'_>, prim: &Prim, nodes: usize, budget: &mut FrameBudget) -> Result<(), Failure> {
        let by_time = |a: &&(f64, Value), b: &&(f64, Value)| a.0.total_cmp(&b.0).then(a.1.offset.cmp(&b.1.offset));
        let mut stated = Vec::new();
        if let Some(((first, at_first), (last, at_last))) =
            samples(prim).min_by(by_time).zip(samples(prim).max_by(by_time))
        {
            let farther = if first.abs() > last.abs() { at_first } else { at_last };
            let codes = |from: f64| format!("time codes from {from} to {last}");
            stated.push((codes(*first), (last - first) * self.ticks, farther));
            let start = layer.metadata.get("startTimeCode").unwrap_or(farther);
            stated.push((codes(self.start), self.tick(*last), start));
        }
        if let (Some(ticks), Some(value)) = (self.duration, attribute_value(prim, DURATION)) {
            stated.push((format!("{DURATION} of {ticks}"), ticks, value));
        }
        let mut longest = 0.0_f64;
        for (what, last, value) in stated {
            let mut trial = *budget;
            trial.frames(last.round(), nodes).map_err(|mut refusal| {
                let frames = refusal.found.unwrap_or_else(|| last.to_string());
                refusal.found = Some(format!("{frames}: {what}"));
                refusal.at(layer.locate(value))
            })?;
            longest = longest.max(last);
        }
        budget.frames(longest.round(), nodes)?;
        Ok(())
    }

    fn tick(&self, time: f64) -> f64 {
        let tick = (time - self.start) * self.ticks;
        if (tick - tick.round()).abs() < WHOLE {
            tick.round()
        } else {
            tick
        }
    }

    fn animation(
        &self,
        prim: &Prim,
        skeleton: &Skeleton,
        has_weights: bool,
        warnings: &mut Warnings,
    ) -> Result<Option<Animation>, Failure> {
        let joints = prim.texts("joints");
        let attribute = |name: &str| prim.attributes.get(name);
        let positions = self.track::<3>(attribute("translations"), joints, "translations")?;
        let rotations = self.track::<4>(attribute("rotations"), joints, "rotations")?;
        let scales = self.track::<3>(attribute("scales"), joints, "scales")?;
        // Weights of blend shapes count too, because they may last longer.
        let last = samples(prim).map(|(time, _)| self.tick(*time)).fold(0.0, f64::max);
        let mut channels = Vec::new();
        let mut free = skeleton.joints.clone();
        for (column, joint) in joints.iter().enumerate() {
            // The joint is no longer free, because a second channel of a joint has no meaning.
            let Some(node) = free.remove(joint) else {
                warnings.tally(Code::IgnoredChannel, || {
                    let message = "an animation has a joint that the skeleton lacks, or has a joint twice";
                    Diagnostic::new(Code::IgnoredChannel, message).in_joint(joint)
                });
                continue;
            };
            let mut rest = Trs::from_matrix(skeleton.nodes[node].transform);
            // A transform with shear has no rotation of unit length.
            rest.rotation = unit(rest.rotation).unwrap_or(Quat::IDENTITY);
            channels.push(Channel {
                node_name: skeleton.nodes[node].name.clone(),
                node: Some(NodeId::new(node)),
                position_keys: keys(&positions, column, joints.len(), rest.translation, Vec3::from_array),
                rotation_keys: keys(
                    &rotations,
                    column,
                    joints.len(),
                    rest.rotation,
                    |[w, x, y, z]: [f32; 4]| {
                        // An invalid rotation is replaced by the rest rotation.
                        unit(Quat::from_xyzw(x, y, z, w)).unwrap_or(rest.rotation)
                    },
                ),
                scaling_keys: keys(&scales, column, joints.len(), rest.scale, Vec3::from_array),
            });
        }
        if channels.is_empty() && !has_weights {
            return Ok(None);
        }
        let name = prim.metadata.get("displayName").and_then(|value| value.texts.first());
        let mut animation = Animation {
            name: name.unwrap_or(&prim.name).clone(),
            duration: self.duration.unwrap_or(last).max(last),
            channels,
            ..Animation::default()
        };
        animation.sort_channels();
        Ok(Some(self.with_path(skeleton, animation)))
    }

    /// The weights of blend shapes. If the weights do not match the names, the weights are skipped with a warning: the
    /// skeleton moves without the weights.
    fn weights(&self, layer: &Layer<'_>, index: usize, warnings: &mut Warnings) -> Weights {
        let prim = &layer.prims[index];
        let names = prim.texts("blendShapes");
        match self.track::<1>(prim.attributes.get("blendShapeWeights"), names, "blendShapeWeights") {
            Ok(track) if !track.1.is_empty() => {
                let columns = names.iter().enumerate();
                let of_shape = |(column, name): (usize, &String)| {
                    let weights = keys(&track, column, names.len(), 0.0, |[weight]: [f32; 1]| weight);
                    (name.clone(), weights)
                };
                columns.map(of_shape).collect()
            }
            Ok(_) => Weights::new(),
            Err(wrong) => {
                warnings.push(Code::IgnoredChannel, || {
                    let message = format!(
                        "{}: blend shape weights were dropped: {}",
                        layer.path(index),
                        wrong.message
                    );
                    Diagnostic::new(Code::IgnoredChannel, message)
                });
                Weights::new()
            }
        }
    }

    /// The animation with the motion of the skeleton's ancestor prims, which becomes the motion of the first node.
    fn with_path(&self, skeleton: &Skeleton, mut animation: Animation) -> Animation {
        animation.ticks_per_second = self.rate;
        let Some((last, _)) = skeleton.path.last() else {
            return animation;
        };
        animation.duration = animation.duration.max(self.tick(*last));
        if animation.name.is_empty() {
            animation.name = UNNAMED_MOTION.to_owned();
        }
        let mut parts: Vec<Trs> = skeleton
            .path
            .iter()
            .map(|(_, matrix)| Trs::from_matrix(*matrix))
            .collect();
        for index in 1..parts.len() {
            parts[index].rotation = in_hemisphere_of(parts[index - 1].rotation, parts[index].rotation);
        }
        let ticks: Vec<f64> = skeleton.path.iter().map(|(time, _)| self.tick(*time)).collect();
        let channel = Channel {
            node_name: skeleton.nodes[0].name.clone(),
            node: Some(NodeId::new(0)),
            position_keys: changing(parts.iter().map(|part| part.translation), &ticks),
            rotation_keys: changing(
                parts.iter().map(|part| unit(part.rotation).unwrap_or(Quat::IDENTITY)),
                &ticks,
            ),
            scaling_keys: changing(parts.iter().map(|part| part.scale), &ticks),
        };
        animation.channels.insert(0, channel);
        animation
    }

    /// The ticks of an attribute, and at each tick N numbers for every joint.
    fn track<const N: usize>(
        &self,
        attribute: Option<&Attribute>,
        names: &[String],
        name: &str,
    ) -> Result<Track<N>, Failure> {
        let Some(attribute) = attribute else {
            return Ok((Vec::new(), Vec::new()));
        };
        let joints = names.len();
        let constant = attribute.value.iter().filter(|_| attribute.samples.is_empty());
        let constant = constant.map(|value| (0.0, value));
        let samples = attribute.samples.iter().map(|(time, value)| (self.tick(*time), value));
        let mut samples: Vec<_> = constant.chain(samples).collect();
        samples.dedup_by(|a, b| a.0 == b.0);
        samples.retain(|(_, value)| !value.numbers.is_empty());
        let mut rows = Vec::with_capacity(samples.len());
        for (tick, value) in &samples {
            if value.numbers.len() != N * joints {
                let message = match N {
                    1 => format!("{name} must have a number for each shape at every time"),
                    _ => format!("{name} must have {N} numbers for each joint at every time"),
                };
                let found = format!("{} at tick {tick}", value.numbers.len());
                let expected = format!("{} numbers", N * joints);
                return Err(Diagnostic::new(Code::InvalidUsd, message)
                    .expected_found(expected, found)
                    .into());
            }
            if let Some(index) = value.numbers.iter().position(|number| !is_plausible(*number)) {
                let joint = &names[index / N];
                let message = format!("a number of {name} at tick {tick} is not finite, or too large to compute with");
                return Err(Diagnostic::new(Code::NumberRange, message).in_joint(joint).into());
            }
            let (numbers, _) = value.numbers.as_chunks::<N>();
            rows.push(
                numbers
                    .iter()
                    .map(|numbers| numbers.map(|number| number as f32))
                    .collect(),
            );
        }
        Ok((samples.iter().map(|(tick, _)| *tick).collect(), rows))
    }
}

/// Keys at ticks; a single key if all values are equal.
fn changing<T: Copy + PartialEq>(values: impl Iterator<Item = T>, ticks: &[f64]) -> Keys<T> {
    let values: Vec<T> = values.collect();
    match values.first() {
        Some(first) if values.iter().all(|value| value == first) => Keys::constant(*first),
        _ => Keys::at_ticks(values, ticks.to_vec()),
    }
}

/// The keys of one joint, or its rest value if it has no keys.
fn keys<T: Copy + PartialEq, const N: usize>(
    (ticks, rows): &(Vec<f64>, Vec<Vec<[f32; N]>>),
    column: usize,
    joints: usize,
    rest: T,
    make: impl Fn([f32; N]) -> T,
) -> Keys<T> {
    let values: Vec<T> = rows
        .iter()
        .filter(|row| row.len() == joints)
        .map(|row| make(row[column]))
        .collect();
    match values.is_empty() {
        true => Keys::constant(rest),
        false => changing(values.into_iter(), ticks),
    }
}
