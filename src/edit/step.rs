//! Steps as text: `NAME:key=value,...`, as the command line takes them and a file records them.

use std::fmt;
use std::str::FromStr;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::{
    BlendWeight, ConcatOptions, ContactOptions, DespikeOptions, FillOptions, FootLockOptions, InBetweenOptions,
    LayerPart, LoopOptions, PathFacing, PathPoint, SmoothOptions, WarpPathOptions, blend, concat, despike, fill,
    foot_lock, in_between, layer, loop_clip, mirror, smooth, warp_path, warp_time,
};
use crate::error::{Code, Diagnostic, Error, Result};
use crate::scene::{AppliedStep, Scene, SecondMotion};

/// The steps by name, each with its keys and what it does.
pub const EDIT_STEPS: &[(&str, &str)] = &[
    (
        "foot-lock",
        "hold feet still in contact and above the floor: blend=S, height=M, speed=M/S, release=TIMES, shortest=S, gap=S, floor=M, largest-change=M",
    ),
    ("mirror", "exchange left and right"),
    (
        "smooth",
        "take fast changes out: filter=butterworth|gaussian, cut-off=HZ",
    ),
    (
        "despike",
        "take single frames out that jump: threshold=TIMES, angle=DEGREES, distance=SHARE, longest=FRAMES",
    ),
    ("fill", "fill gaps in which the motion was held: longest=S, shortest=S"),
    (
        "loop",
        "cut to a loop: frames=A..B, or the best one of shortest=S to longest=S; blend=S, in-place=true",
    ),
    ("concat", "append the next IN, or with=N: blend=S, align=false"),
    (
        "blend",
        "mix with the next IN, or with=N, aligned in time: weight=0..1, or weight=SECONDS:WEIGHT+... for a curve",
    ),
    (
        "layer",
        "take a part of the body from the next IN, or with=N: part=upper|legs|arms|head",
    ),
    (
        "warp",
        "move moments: SECONDS=SECONDS,..., or speed=FACTOR for all; or bend the way over the ground to points: path=[SECONDS:]M/M+..., facing=along|kept",
    ),
    (
        "in-between",
        "keep key frames, compute the others: every=N, keys=A+B+..., interpolation=slerp|squad",
    ),
];

/// A step with its parameters.
///
/// ```
/// use mocap::edit::EditStep;
///
/// let step: EditStep = "smooth:cut-off=8".parse()?;
/// assert_eq!(step.to_string(), "smooth:cut-off=8.0,filter=butterworth");
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// let report = step.apply(&mut scene, 0, None)?;
/// assert!(report.changed["largest_rotation"].as_f64() > Some(0.0));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct EditStep {
    kind: Kind,
    with: Option<usize>,
}

/// Seconds of a motion that change their speed: all of any motion.
const LONGEST: f64 = 1e9;

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    FootLock(FootLockKeys),
    Mirror,
    Smooth(SmoothOptions),
    Despike(DespikeOptions),
    Fill(FillOptions),
    Loop(LoopOptions),
    Concat(ConcatOptions),
    Blend(BlendWeight),
    Layer(LayerKeys),
    Warp(Vec<(f64, f64)>),
    Speed(f64),
    Path(WarpPathOptions),
    InBetween(InBetweenOptions),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct FootLockKeys {
    blend: f64,
    height: f64,
    speed: f64,
    release: f64,
    shortest: f64,
    gap: f64,
    floor: Option<f32>,
    largest_change: Option<f64>,
}

impl Default for FootLockKeys {
    fn default() -> Self {
        let (lock, contacts) = (FootLockOptions::default(), ContactOptions::default());
        Self {
            blend: lock.blend,
            height: contacts.height,
            speed: contacts.speed,
            release: contacts.release,
            shortest: contacts.shortest,
            gap: contacts.gap,
            floor: None,
            largest_change: None,
        }
    }
}

/// Of a blend without a weight.
const HALF: BlendWeight = BlendWeight::Constant(0.5);

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct LayerKeys {
    part: LayerPart,
}

/// What a step changed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EditReport {
    /// The step with all its parameters.
    pub step: String,
    /// The file of the second motion, of a step that takes one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with: Option<String>,
    /// The report of its function, as JSON.
    pub changed: Value,
}

impl EditStep {
    /// Its name.
    pub fn name(&self) -> &'static str {
        match self.kind {
            Kind::FootLock(_) => "foot-lock",
            Kind::Mirror => "mirror",
            Kind::Smooth(_) => "smooth",
            Kind::Despike(_) => "despike",
            Kind::Fill(_) => "fill",
            Kind::Loop(_) => "loop",
            Kind::Concat(_) => "concat",
            Kind::Blend(_) => "blend",
            Kind::Layer(_) => "layer",
            Kind::Warp(_) | Kind::Speed(_) | Kind::Path(_) => "warp",
            Kind::InBetween(_) => "in-between",
        }
    }

    /// Whether it takes a second motion.
    pub fn needs_other(&self) -> bool {
        matches!(self.kind, Kind::Concat(_) | Kind::Blend(_) | Kind::Layer(_))
    }

    /// The place of the second motion among the inputs, from 1, where the text names it with `with`.
    pub fn with(&self) -> Option<usize> {
        self.with
    }

    /// Applies the step to an animation of `scene`, and records it in
    /// [`Metadata::steps`](crate::scene::Metadata::steps). `other` is the second motion of a step that takes one, of
    /// which the first animation counts.
    ///
    /// # Errors
    /// Those of the step's function; [`Code::UnknownOption`] without a second motion that it needs.
    pub fn apply(&self, scene: &mut Scene, animation: usize, other: Option<&Scene>) -> Result<EditReport> {
        let second = || {
            let message = format!("the step {} needs a second motion", self.name());
            other.ok_or_else(|| Error::from(Diagnostic::new(Code::UnknownOption, message)))
        };
        let changed = match &self.kind {
            Kind::FootLock(keys) => json(&foot_lock(scene, animation, &keys.options())?),
            Kind::Mirror => json(&mirror(scene, animation, None)?),
            Kind::Smooth(options) => json(&smooth(scene, animation, options)?),
            Kind::Despike(options) => json(&despike(scene, animation, options)?),
            Kind::Fill(options) => json(&fill(scene, animation, options)?),
            Kind::Loop(options) => json(&loop_clip(scene, animation, options)?),
            Kind::Concat(options) => json(&concat(scene, animation, second()?, 0, options)?),
            Kind::Blend(weight) => json(&blend(scene, animation, second()?, 0, weight.clone())?),
            Kind::Layer(keys) => json(&layer(scene, animation, second()?, 0, keys.part)?),
            Kind::Warp(moments) => json(&warp_time(scene, animation, moments)?),
            Kind::Speed(speed) => json(&warp_time(scene, animation, &[(0.0, 0.0), (LONGEST * speed, LONGEST)])?),
            Kind::Path(options) => json(&warp_path(scene, animation, options)?),
            Kind::InBetween(options) => json(&in_between(scene, animation, options)?),
        };
        let edit = self.to_string();
        let second = other.filter(|_| self.needs_other()).map(SecondMotion::of);
        let origin = second.as_ref().and_then(|second| second.source.as_ref());
        let report = EditReport {
            step: edit.clone(),
            with: origin.map(|origin| origin.name.clone()),
            changed,
        };
        scene.metadata.steps.push(AppliedStep::Edit { edit, with: second });
        Ok(report)
    }

    fn keys(&self) -> Map<String, Value> {
        let of = |key: &str, value: Value| json(&Map::from_iter([(key.to_owned(), value)]));
        let value = match &self.kind {
            Kind::FootLock(keys) => json(keys),
            Kind::Smooth(options) => json(options),
            Kind::Despike(options) => json(options),
            Kind::Fill(options) => json(options),
            Kind::Loop(options) => json(options),
            Kind::Concat(options) => json(options),
            Kind::Blend(BlendWeight::Constant(weight)) => of("weight", Value::from(*weight)),
            Kind::Blend(BlendWeight::Curve(points)) => {
                let points: Vec<String> = points.iter().map(|(time, weight)| format!("{time}:{weight}")).collect();
                of("weight", Value::from(points.join("+")))
            }
            Kind::Layer(keys) => json(keys),
            Kind::InBetween(options) => json(options),
            Kind::Speed(speed) => of("speed", Value::from(*speed)),
            Kind::Path(options) => {
                let points: Vec<String> = options.points.iter().map(PathPoint::to_string).collect();
                let path = ("path".to_owned(), Value::from(points.join("+")));
                json(&Map::from_iter([path, ("facing".to_owned(), json(&options.facing))]))
            }
            Kind::Mirror | Kind::Warp(_) => Value::Null,
        };
        match value {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }
}

impl FootLockKeys {
    fn options(&self) -> FootLockOptions {
        FootLockOptions {
            contacts: ContactOptions {
                height: self.height,
                speed: self.speed,
                release: self.release,
                shortest: self.shortest,
                gap: self.gap,
                hands: false,
            },
            blend: self.blend,
            floor: self.floor,
            largest_change: self.largest_change,
            ..FootLockOptions::default()
        }
    }
}

fn json(value: &impl Serialize) -> Value {
    serde_json::to_value(value).unwrap_or_default()
}

/// The name and every parameter, also those that were not given.
impl fmt::Display for EditStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts: Vec<String> = Vec::new();
        if let Kind::Warp(moments) = &self.kind {
            parts.extend(moments.iter().map(|(from, to)| format!("{from}={to}")));
        }
        for (key, value) in self.keys() {
            let text = match &value {
                Value::Null => continue,
                Value::String(text) => text.clone(),
                Value::Array(values) if values.is_empty() => continue,
                Value::Array(values) => {
                    let values: Vec<String> = values.iter().map(Value::to_string).collect();
                    values.join(if key == "frames" { ".." } else { "+" })
                }
                other => other.to_string(),
            };
            parts.push(format!("{}={text}", key.replace('_', "-")));
        }
        f.write_str(self.name())?;
        if parts.is_empty() {
            Ok(())
        } else {
            write!(f, ":{}", parts.join(","))
        }
    }
}

/// Parses `NAME` or `NAME:key=value,...`.
impl FromStr for EditStep {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let mut map = Map::new();
        let mut with = None;
        let (mut weight, mut path) = (None, None);
        let mut moments = Vec::new();
        for part in rest.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let Some((key, value)) = part.split_once('=') else {
                return refuse(format!("{part:?} in the step {text:?} is not key=value"));
            };
            match (name, key, value.parse::<f64>()) {
                ("concat" | "blend" | "layer", "with", _) => match value.parse() {
                    Ok(place) if place >= 2 => with = Some(place),
                    _ => {
                        return refuse(format!(
                            "with in the step {text:?} must be the place of a motion among the inputs, 2 or more, got {value:?}"
                        ));
                    }
                },
                ("blend", "weight", Err(_)) => weight = Some(BlendWeight::Curve(points(text, value)?)),
                ("blend", "weight", Ok(constant)) => weight = Some(BlendWeight::Constant(constant)),
                ("warp", "path", _) => path = Some(path_points(text, value)?),
                ("warp", key, Ok(to)) if key.parse::<f64>().is_ok() => moments.push((key.parse().unwrap_or(to), to)),
                _ => {
                    map.insert(key.replace('-', "_"), parsed(key, value));
                }
            }
        }
        let kind = match name {
            "foot-lock" => Kind::FootLock(read(text, map)?),
            "smooth" => Kind::Smooth(read(text, map)?),
            "despike" => Kind::Despike(read(text, map)?),
            "fill" => Kind::Fill(read(text, map)?),
            "loop" => Kind::Loop(read(text, map)?),
            "concat" => Kind::Concat(read(text, map)?),
            "blend" if map.is_empty() => Kind::Blend(weight.unwrap_or(HALF)),
            "layer" => Kind::Layer(read(text, map)?),
            "in-between" => Kind::InBetween(read(text, map)?),
            "mirror" if map.is_empty() => Kind::Mirror,
            "warp" if path.is_some() && moments.is_empty() => {
                let PathKeys { facing } = read(text, map)?;
                let points = path.unwrap_or_default();
                Kind::Path(WarpPathOptions { points, facing })
            }
            "warp" if map.is_empty() && path.is_none() && !moments.is_empty() => Kind::Warp(moments),
            "warp" if moments.is_empty() && path.is_none() => match map.get("speed").and_then(Value::as_f64) {
                Some(speed) if speed > 0.0 && map.len() == 1 => Kind::Speed(speed),
                _ => {
                    return refuse(format!(
                        "the step {text:?} must be warp:SECONDS=SECONDS,..., warp:speed=FACTOR above 0, or warp:path=..."
                    ));
                }
            },
            "mirror" | "warp" | "blend" => {
                return refuse(format!(
                    "the step {text:?} has a key that {name} does not have, or not beside the others"
                ));
            }
            _ => {
                let names: Vec<&str> = EDIT_STEPS.iter().map(|(name, _)| *name).collect();
                let diagnostic = Diagnostic::new(Code::UnknownOption, format!("there is no step {name:?}"));
                return Err(diagnostic.expected_found(names.join(", "), format!("{name:?}")).into());
            }
        };
        Ok(Self { kind, with })
    }
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct PathKeys {
    facing: PathFacing,
}

/// `SECONDS:WEIGHT+...`.
fn points(text: &str, value: &str) -> Result<Vec<(f64, f64)>> {
    let point = |part: &str| {
        let (time, value) = part.split_once(':')?;
        Some((time.trim().parse().ok()?, value.trim().parse().ok()?))
    };
    let read = |part: &str| match point(part) {
        Some(point) => Ok(point),
        None => refuse(format!(
            "{part:?} in the step {text:?} is neither a number nor SECONDS:WEIGHT"
        )),
    };
    value.split('+').map(read).collect()
}

/// `[SECONDS:]M/M+...`.
fn path_points(text: &str, value: &str) -> Result<Vec<PathPoint>> {
    let point = |part: &str| {
        let (seconds, at) = match part.split_once(':') {
            Some((seconds, at)) => (Some(seconds.trim().parse().ok()?), at),
            None => (None, part),
        };
        let (first, second) = at.split_once('/')?;
        let at = [first.trim().parse().ok()?, second.trim().parse().ok()?];
        Some(PathPoint { seconds, at })
    };
    let read = |part: &str| match point(part) {
        Some(point) => Ok(point),
        None => refuse(format!(
            "{part:?} in the step {text:?} is not a point: M/M or SECONDS:M/M"
        )),
    };
    value.split('+').map(read).collect()
}

fn refuse<T>(message: String) -> Result<T> {
    Err(Diagnostic::new(Code::UnknownOption, message).into())
}

/// A value of the text: numbers, `A..B`, `A+B+...`, true, false, or a word.
fn parsed(key: &str, value: &str) -> Value {
    let number = |text: &str| {
        text.parse::<u64>()
            .map(Value::from)
            .ok()
            .or_else(|| serde_json::Number::from_f64(text.parse().ok()?).map(Value::Number))
    };
    let numbers = |texts: std::str::Split<'_, &str>| {
        texts
            .map(|text| number(text.trim()).unwrap_or_else(|| Value::from(text)))
            .collect()
    };
    match value {
        "true" => Value::Bool(true),
        "false" => Value::Bool(false),
        _ if value.contains("..") => Value::Array(numbers(value.split(".."))),
        _ if key == "keys" => Value::Array(numbers(value.split("+"))),
        _ => number(value).unwrap_or_else(|| Value::from(value)),
    }
}

fn read<T: DeserializeOwned>(text: &str, map: Map<String, Value>) -> Result<T> {
    serde_json::from_value(Value::Object(map)).or_else(|error| refuse(format!("the step {text:?}: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_is_printed_is_read_as_the_same() {
        for text in [
            "foot-lock",
            "foot-lock:speed=0.3,floor=0.1,largest-change=0.02",
            "mirror",
            "smooth:filter=gaussian",
            "despike:longest=2",
            "fill",
            "loop:frames=10..140,in-place=true",
            "loop",
            "concat:align=false",
            "blend:weight=0.25",
            "blend",
            "blend:weight=0:0+1.5:1",
            "warp:path=0:0/0+2.5:-1/2.25",
            "warp:path=0/0+1/2+3/-1,facing=kept",
            "layer:part=legs",
            "warp:0=0,1.5=3",
            "warp:speed=2",
            "in-between:keys=3+9,every=20,interpolation=slerp",
        ] {
            let step: EditStep = text.parse().unwrap();
            assert_eq!(step.to_string().parse::<EditStep>().unwrap(), step, "{text}");
            assert!(EDIT_STEPS.iter().any(|(name, _)| *name == step.name()));
        }
        assert_eq!("blend:with=3".parse::<EditStep>().unwrap().with(), Some(3));
    }

    #[test]
    fn what_is_wrong_with_a_step_is_said() {
        let refused = |text: &str| text.parse::<EditStep>().unwrap_err().diagnostic().message.clone();
        assert_eq!(refused("shake"), "there is no step \"shake\"");
        assert_eq!(refused("smooth:8"), "\"8\" in the step \"smooth:8\" is not key=value");
        assert!(
            refused("smooth:cutoff=8").starts_with("the step \"smooth:cutoff=8\": unknown field `cutoff`, expected")
        );
        assert!(refused("fill:longest=soon").contains("invalid type: string \"soon\""));
        assert!(refused("foot-lock:floor=nan").contains("invalid type: string \"nan\""));
        assert!(refused("warp:speed=0").ends_with("warp:speed=FACTOR above 0, or warp:path=..."));
        for text in [
            "mirror:axis=x",
            "warp:path=1/1,0=0",
            "warp:0=0,speed=2",
            "blend:heavy=1",
        ] {
            assert!(
                refused(text).ends_with("does not have, or not beside the others"),
                "{text}"
            );
        }
        assert!(refused("blend:weight=0:0+1").starts_with("\"1\" in the step"));
        assert!(refused("warp:path=1/2+3").ends_with("is not a point: M/M or SECONDS:M/M"));
        assert!(refused("blend:with=b.bvh").ends_with("2 or more, got \"b.bvh\""));
        assert!(refused("smooth:with=2").contains("unknown field `with`"));
    }
}
