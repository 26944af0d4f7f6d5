//! Blend shapes of a face over time: the tables of Live Link Face, and the JSON of MediaPipe's face landmarker.
//!
//! ```text
//! Timecode,BlendShapeCount,EyeBlinkLeft,...,TongueOut,HeadYaw,HeadPitch,HeadRoll,LeftEyeYaw,...
//! 14:23:05:12.345,61,0.03,...
//! ```
//!
//! ```text
//! [{"timestampMs": 33, "faceBlendshapes": [{"categories": [{"categoryName": "jawOpen", "score": 0.2}, ...]}]}, ...]
//! ```
//!
//! A frame of JSON may also be a list of categories, or an object of names and weights. Keys are in camel or snake
//! case. Each ARKit shape becomes an expression with the name of the shape.

mod json;

use std::borrow::Cow;

use glam::{Mat4, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::files::Records;
use mocap_scene::limits::{is_plausible, limit_exceeded};
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{
    Assumption, Channel, Confidence, Face, Format, Keys, Node, NodeId, NodeKind, Scene, Topic, UpAxis, face_shape,
};

pub(super) use self::json::read as read_json;
use super::csv::{cut_frame, is_last, refused};
use crate::frames::add_animation;
use crate::text::{number, quote};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The number of columns before the first shape: the timecode and the number of shapes.
const BEFORE: usize = 2;

/// The frame rates of timecodes, in Hz.
const RATES: [f64; 6] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0];

/// The frame rate of Live Link Face unless its settings say otherwise, in Hz.
const USUAL_RATE: f64 = 60.0;

/// The rotations in a table of Live Link Face: the start of the column names, and the name of the joint.
const ROTATIONS: [(&str, &str); 3] = [("Head", "head"), ("LeftEye", "left eye"), ("RightEye", "right eye")];

/// The weights of ARKit's shapes in each frame.
struct Track {
    shapes: Vec<&'static str>,
    /// The ticks of the frames, in increasing order.
    ticks: Vec<f64>,
    /// The weights of each shape, one per frame.
    weights: Vec<Vec<f32>>,
    rate: f64,
    assumption: Option<Assumption>,
}

pub(super) fn scene(bytes: &[u8], options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let text = crate::text::decode(bytes)?;
    let text = String::from_utf8_lossy(&text);
    let mut records = Records::new(&text);
    let mut names = Vec::new();
    records.next(&mut names);
    let columns: Vec<(usize, &'static str)> = names
        .iter()
        .enumerate()
        .skip(BEFORE)
        .filter_map(|(column, name)| Some((column, face_shape(name.trim())?)))
        .collect();
    if columns.is_empty() {
        let message = "line 1: no column is a blend shape of ARKit, such as EyeBlinkLeft";
        let help = "export the take again from Live Link Face, with its first line";
        return Err(Box::new(Diagnostic::new(Code::MissingKeyword, message).help(help)));
    }
    let mut moments = Vec::new();
    let mut weights: Vec<Vec<f32>> = vec![Vec::new(); columns.len()];
    let mut others: Vec<Option<f64>> = vec![None; names.len()];
    let mut moving = vec![false; names.len()];
    let mut cells = Vec::new();
    while records.next(&mut cells) {
        if cells.iter().all(|cell| cell.trim().is_empty()) {
            continue;
        }
        let values = (moments.len() as u64 + 1).saturating_mul(columns.len() as u64);
        if values > options.limits.max_values {
            let most = format!("at most {} values", options.limits.max_values);
            return Err(limit_exceeded(most, format!("more than {} frames", moments.len())).into());
        }
        if cells.len() < names.len() {
            if !moments.is_empty() && is_last(&records) {
                warnings.push(Code::RowLength, || cut_frame(records.line));
                break;
            }
            let found = format!("{} cells", cells.len());
            let refusal = refused(records.line, "the row is too short");
            return Err(Box::new(
                refusal.expected_found(format!("{} cells", names.len()), found),
            ));
        }
        moments.push(timecode(cells[0].trim(), records.line)?);
        for ((column, _), weights) in columns.iter().zip(&mut weights) {
            weights.push(cell(&cells, *column, records.line)? as f32);
        }
        for column in (BEFORE..names.len()).filter(|column| face_shape(names[*column].trim()).is_none()) {
            let value = cell(&cells, column, records.line)?;
            moving[column] |= others[column].is_some_and(|first| first != value);
            others[column].get_or_insert(value);
        }
    }
    let (rate, assumption) = rate_of(&moments);
    let ticks = ticks(&moments, rate, warnings);
    let track = Track {
        shapes: columns.iter().map(|(_, shape)| *shape).collect(),
        ticks,
        weights,
        rate: options.frame_rate_or(rate)?,
        assumption: assumption.filter(|_| options.retime.is_none()),
    };
    let mut scene = track.into_scene(warnings);
    let moves = |start: &str| {
        let mut columns = names.iter().zip(&moving);
        columns.any(|(name, moving)| *moving && name.trim().starts_with(start))
    };
    let left_out: Vec<&str> = ROTATIONS
        .into_iter()
        .filter(|(start, _)| moves(start))
        .map(|(_, joint)| joint)
        .collect();
    if !left_out.is_empty() {
        scene.lose(DataKind::MovingJoints, left_out.len());
        let message = format!(
            "the rotations of {} were left out: a face track has no skeleton",
            left_out.join(", ")
        );
        warnings.push(Code::NotCarriedOver, || Diagnostic::new(Code::NotCarriedOver, message));
    }
    Ok(scene)
}

/// The number in a cell, which must be finite.
fn cell(cells: &[Cow<'_, str>], column: usize, line: usize) -> Result<f64, Failure> {
    let text = cells[column].trim();
    match number::parse(text.as_bytes()) {
        Some(number) if number.length == text.len() && is_plausible(number.value) => Ok(number.value),
        _ => {
            let message = format!("line {line}, column {}: a weight is not a number", column + 1);
            Err(Box::new(
                Diagnostic::new(Code::InvalidNumber, message)
                    .expected_found("a finite number", quote(text.as_bytes()))
                    .help("export the take again from Live Link Face"),
            ))
        }
    }
}

/// A timecode: the whole seconds of the day, and the frames after them. Without frames, the seconds have a fraction.
#[derive(Clone, Copy)]
struct Moment {
    seconds: f64,
    frames: Option<f64>,
}

fn timecode(text: &str, line: usize) -> Result<Moment, Failure> {
    let number = |part: &str| part.parse::<f64>().ok().filter(|value| (0.0..1e6).contains(value));
    let parts: Option<Vec<f64>> = text.split([':', ';']).map(number).collect();
    match parts.as_deref() {
        Some([hours, minutes, seconds, frames]) => Ok(Moment {
            seconds: 3600.0 * hours + 60.0 * minutes + seconds,
            frames: Some(*frames),
        }),
        Some([hours, minutes, seconds]) => Ok(Moment {
            seconds: 3600.0 * hours + 60.0 * minutes + seconds,
            frames: None,
        }),
        _ => {
            let message = format!("line {line}: the first cell is not a timecode");
            Err(Box::new(
                Diagnostic::new(Code::UnexpectedToken, message)
                    .expected_found("hours:minutes:seconds:frames", quote(text.as_bytes()))
                    .help("export the take again from Live Link Face"),
            ))
        }
    }
}

/// The frame rate of timecodes. If the take contains a whole second, the rate is the smallest usual rate above every
/// frame number. Otherwise the rate is [`USUAL_RATE`], which is recorded as an assumption.
fn rate_of(moments: &[Moment]) -> (f64, Option<Assumption>) {
    let has_whole_second = moments
        .first()
        .zip(moments.last())
        .is_some_and(|(first, last)| last.seconds - first.seconds >= 2.0);
    let frames = moments.iter().filter_map(|moment| moment.frames);
    let most = frames.fold(None, |most: Option<f64>, frame| {
        Some(most.map_or(frame, |most| most.max(frame)))
    });
    let rate = most.and_then(|most| RATES.into_iter().find(|rate| most < *rate));
    match rate.filter(|_| has_whole_second) {
        Some(rate) => (rate, None),
        None => {
            let assumption = Assumption {
                topic: Topic::FrameRate,
                choice: format!("{USUAL_RATE} fps"),
                reason: "the timecodes do not count the frames of a whole second; Live Link Face usually records at \
                         this rate"
                    .to_owned(),
                confidence: Some(Confidence::Likely),
            };
            (USUAL_RATE, Some(assumption))
        }
    }
}

/// The tick of each time, counted from the first time.
fn ticks(moments: &[Moment], rate: f64, warnings: &mut Warnings) -> Vec<f64> {
    /// Seconds of a day, after which a timecode starts again at 0.
    const DAY: f64 = 86_400.0;
    let tick = |moment: &Moment| moment.seconds * rate + moment.frames.unwrap_or_default();
    let first = moments.first().map_or(0.0, tick);
    let ticks = moments
        .iter()
        .map(|moment| (tick(moment) - first).rem_euclid(DAY * rate));
    increasing(ticks.collect(), warnings)
}

/// The ticks rounded to whole numbers, if they still increase. Otherwise the unchanged ticks, if they increase, or else
/// the frame numbers.
fn increasing(ticks: Vec<f64>, warnings: &mut Warnings) -> Vec<f64> {
    let increases = |ticks: &[f64]| ticks.windows(2).all(|pair| pair[1] > pair[0]);
    let whole: Vec<f64> = ticks.iter().map(|tick| tick.round()).collect();
    match (increases(&whole), increases(&ticks)) {
        (true, _) => whole,
        (false, true) => ticks,
        (false, false) => {
            let message = "the times of the frames do not increase; mocap read the frames in file order and spaced \
                           them evenly";
            warnings.push(Code::ClockJump, || Diagnostic::new(Code::ClockJump, message));
            (0..ticks.len()).map(|frame| frame as f64).collect()
        }
    }
}

impl Track {
    fn into_scene(self, warnings: &mut Warnings) -> Scene {
        let mut scene = Scene::default();
        scene.metadata.format = Some(Format::Csv);
        scene.metadata.metres_per_unit = Some(1.0);
        scene.metadata.up = Some(UpAxis::Y);
        scene.metadata.assumptions.extend(self.assumption);
        scene.nodes.push(Node {
            name: "Face".to_owned(),
            kind: NodeKind::Group,
            transform: Mat4::IDENTITY,
            ..Node::default()
        });
        let mut channels = Vec::new();
        for (shape, weights) in self.shapes.iter().zip(self.weights) {
            channels.push(Channel {
                node_name: (*shape).to_owned(),
                node: Some(NodeId::new(scene.nodes.len())),
                position_keys: Keys::at_ticks(
                    weights.into_iter().map(|weight| weight * Vec3::X).collect(),
                    self.ticks.clone(),
                ),
                rotation_keys: Keys::constant(Quat::IDENTITY),
                scaling_keys: Keys::constant(Vec3::ONE),
            });
            scene.nodes.push(Node {
                name: (*shape).to_owned(),
                kind: NodeKind::Group,
                parent: Some(NodeId::new(0)),
                transform: Mat4::IDENTITY,
                face: Some(Face::Custom((*shape).to_owned())),
                ..Node::default()
            });
        }
        let frames = self.ticks.len();
        add_animation(&mut scene, (frames, self.rate), channels, "blend shapes", warnings);
        if let (Some(animation), Some(last)) = (scene.animations.first_mut(), self.ticks.last()) {
            animation.duration = *last;
        }
        scene
    }
}
