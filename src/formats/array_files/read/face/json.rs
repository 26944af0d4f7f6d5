//! The blend shapes of MediaPipe's face landmarker as JSON.

use std::collections::BTreeMap;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::limit_exceeded;
use mocap_scene::scene::{Assumption, Confidence, FACE_SHAPES, Scene, Topic, face_shape};
use serde_json::Value;

use super::{Track, increasing};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The keys of the list of frames.
const FRAMES: [&str; 4] = ["frames", "results", "data", "blendshapes"];

/// The keys of the shapes of a frame, in lower case without underscores.
const SHAPES: [&str; 4] = ["faceblendshapes", "blendshapes", "categories", "shapes"];

/// The keys of the name of a shape, in lower case without underscores. The second constant has the keys of its weight.
const NAMES: [&str; 3] = ["categoryname", "displayname", "name"];
const WEIGHTS: [&str; 3] = ["score", "weight", "value"];

/// The keys of the time of a frame, in lower case without underscores. Each has the number of its time units in a
/// second.
const TIMES: [(&str, f64); 5] = [
    ("timestampms", 1e3),
    ("timems", 1e3),
    ("timestampus", 1e6),
    ("time", 1.0),
    ("timestamp", 1.0),
];

/// The frame rate in Hz if no frame has a time.
const USUAL_RATE: f64 = 30.0;

/// If the step between frames, read as seconds, is at least this number, the times are in milliseconds. Every take has
/// more than one frame per second.
const SLOWEST: f64 = 1.0;

/// The largest relative difference between a frame rate and a whole number that counts as rounding: timestamps are
/// whole milliseconds.
const NEAR: f64 = 0.02;

pub(in super::super) fn read(bytes: &[u8], options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let text = crate::text::decode(bytes)?;
    let root: Value = serde_json::from_slice(&text).map_err(|error| {
        let message = format!("line {}: the text is not JSON", error.line());
        Box::new(Diagnostic::new(Code::UnexpectedToken, message).help("write the blend shapes again as JSON"))
    })?;
    let frames = frames(&root);
    let values = (frames.len() as u64).saturating_mul(FACE_SHAPES.len() as u64);
    if values > options.limits.max_values {
        let most = format!("at most {} values", options.limits.max_values);
        return Err(limit_exceeded(most, format!("{} frames", frames.len())).into());
    }
    let mut found: Vec<(f64, Option<f64>, BTreeMap<&'static str, f32>)> = Vec::new();
    let (mut empty, mut faces) = (0, 0);
    for (index, frame) in frames.iter().enumerate() {
        let shapes = weights(frame, &mut faces);
        match shapes.is_empty() {
            true => empty += 1,
            false => found.push((index as f64, time(frame), shapes)),
        }
    }
    let known: Vec<&'static str> = FACE_SHAPES
        .into_iter()
        .filter(|shape| found.iter().any(|(.., shapes)| shapes.contains_key(shape)))
        .collect();
    if known.is_empty() {
        let message = "the JSON has no blend shapes of ARKit, such as eyeBlinkLeft";
        let help = "write a list of frames with faceBlendshapes, as MediaPipe's face landmarker returns them";
        return Err(Box::new(Diagnostic::new(Code::MissingKeyword, message).help(help)));
    }
    if empty > 0 {
        let message = format!(
            "{empty} of {} frames have no face: their weights are interpolated between the neighbouring frames",
            frames.len()
        );
        warnings.push(Code::Gap, || Diagnostic::new(Code::Gap, message));
    }
    if faces > 0 {
        let message = format!("{faces} frames have more than one face; only the first face was read");
        warnings.push(Code::NotCarriedOver, || Diagnostic::new(Code::NotCarriedOver, message));
    }
    let (ticks, rate, assumption) = ticks(&found, warnings);
    let weights = known.iter().map(|shape| {
        let mut last = 0.0;
        let of_frame = found.iter().map(|(.., shapes)| {
            last = shapes.get(shape).copied().unwrap_or(last);
            last
        });
        of_frame.collect()
    });
    let track = Track {
        weights: weights.collect(),
        shapes: known,
        ticks,
        rate: options.frame_rate_or(rate)?,
        assumption: assumption.filter(|_| options.retime.is_none()),
    };
    Ok(track.into_scene(warnings))
}

/// A key in lower case without underscores.
fn plain(key: &str) -> String {
    key.replace(['_', '-'], "").to_ascii_lowercase()
}

/// The value of the first of these keys that the object has.
fn member<'a>(value: &'a Value, keys: &[&str]) -> Option<&'a Value> {
    let object = value.as_object()?;
    keys.iter()
        .find_map(|wanted| Some(object.iter().find(|(key, _)| plain(key) == *wanted)?.1))
}

/// The frames of a file. An object without a list of frames is one frame.
fn frames(root: &Value) -> Vec<&Value> {
    let list = match root {
        Value::Array(list) => Some(list),
        _ => member(root, &FRAMES)
            .and_then(Value::as_array)
            .filter(|list| !is_shapes(list)),
    };
    match list {
        Some(list) if !is_shapes(list) => list.iter().collect(),
        _ => vec![root],
    }
}

/// Whether a list contains the shapes of one face, not frames or faces.
fn is_shapes(list: &[Value]) -> bool {
    list.first().is_some_and(|first| category(first).is_some())
}

/// The name and the weight of a shape.
fn category(value: &Value) -> Option<(&str, f32)> {
    let name = member(value, &NAMES)?.as_str()?;
    let weight = member(value, &WEIGHTS)?.as_f64()? as f32;
    weight.is_finite().then_some((name, weight))
}

/// The weights of the first face of a frame. If the frame has several faces, adds 1 to `faces`.
fn weights(frame: &Value, faces: &mut usize) -> BTreeMap<&'static str, f32> {
    let known = |(name, weight): (&str, f32)| Some((face_shape(name)?, weight));
    match frame {
        Value::Array(list) if is_shapes(list) => list.iter().filter_map(category).filter_map(known).collect(),
        Value::Array(list) => {
            *faces += usize::from(list.len() > 1);
            list.first().map(|first| weights(first, faces)).unwrap_or_default()
        }
        Value::Object(object) => match member(frame, &SHAPES) {
            Some(shapes) => weights(shapes, faces),
            None => {
                let numbers = object
                    .iter()
                    .filter_map(|(name, value)| Some((name.as_str(), value.as_f64()? as f32)));
                numbers
                    .filter(|(_, weight)| weight.is_finite())
                    .filter_map(known)
                    .collect()
            }
        },
        _ => BTreeMap::new(),
    }
}

/// The time of a frame in seconds, by the unit of its key.
fn time(frame: &Value) -> Option<f64> {
    TIMES.into_iter().find_map(|(key, a_second)| {
        let time = member(frame, &[key])?.as_f64()?;
        time.is_finite().then_some(time / a_second)
    })
}

/// The ticks of the frames, their rate, and an assumption if the file states no times.
fn ticks(
    found: &[(f64, Option<f64>, BTreeMap<&'static str, f32>)],
    warnings: &mut Warnings,
) -> (Vec<f64>, f64, Option<Assumption>) {
    let first = found.first().map_or(0.0, |(index, ..)| *index);
    let numbers = || found.iter().map(|(index, ..)| index - first).collect();
    let times: Option<Vec<f64>> = found.iter().map(|(_, time, _)| *time).collect();
    let mut steps: Vec<f64> = times
        .iter()
        .flat_map(|times| times.windows(2))
        .map(|pair| pair[1] - pair[0])
        .collect();
    steps.sort_unstable_by(f64::total_cmp);
    let step = steps.get(steps.len() / 2).copied().filter(|step| *step > 0.0);
    let (Some(times), Some(step)) = (times, step) else {
        let assumption = Assumption {
            topic: Topic::FrameRate,
            choice: format!("{USUAL_RATE} fps"),
            reason: "the file has no times".to_owned(),
            confidence: Some(Confidence::Unsure),
        };
        return (numbers(), USUAL_RATE, Some(assumption));
    };
    let unit = if step >= SLOWEST { 1e-3 } else { 1.0 };
    let exact = 1.0 / (unit * step);
    let whole = exact.round();
    let rate = if (exact - whole).abs() <= NEAR * whole {
        whole
    } else {
        exact
    };
    let ticks = times.iter().map(|time| (time - times[0]) * unit * rate);
    (increasing(ticks.collect(), warnings), rate, None)
}
