//! The tables of OptiTrack's Motive: markers, rigid bodies and bones, with a row for each frame.
//!
//! ```text
//! Format Version,1.23,Take Name,walk,...,Export Frame Rate,120,...,Rotation Type,Quaternion,Length Units,Meters,...
//! (blank)
//! ,Type,Rigid Body,...,Marker,...
//! ,Name,Wand,...,S:Head,...
//! ,ID,"1",...
//! ,Parent,...                                  since version 1.24
//! ,,Rotation,...,Position,...,Mean Marker Error
//! Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,...
//! ```
//!
//! An empty cell is a gap. Rotations are quaternions X, Y, Z, W, or angles in degrees about the axes that `Rotation
//! Type` names, each axis rotated by the rotations before it. +Y is up.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::{DQuat, EulerRot, Quat, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::files::Records;
use mocap_scene::limits::{is_plausible, limit_exceeded};
use mocap_scene::scene::{Assumption, Confidence, Format, Keys, Scene, Topic, UpAxis};

use crate::points::{self, Kind, Track};
use crate::text::{number, quote};
use crate::warnings::{Warnings, missing_frames};
use crate::{Failure, ReadOptions};

/// The number of columns before the first object: the frame and the time.
const BEFORE: usize = 2;

/// The help for a table that differs from Motive's form.
const EXPORT: &str = "export it again from Motive, with the header";

/// The columns of one object.
#[derive(Default)]
struct Object {
    kind: String,
    name: String,
    position: [Option<usize>; 3],
    /// The columns of the rotation: X, Y, Z and W.
    rotation: [Option<usize>; 4],
    track: Track,
    rotations: Vec<(f64, Quat)>,
}

impl Object {
    fn has_position(&self) -> bool {
        self.position.iter().all(Option::is_some)
    }

    /// Whether the object is the expected position of a marker in a model, not a seen position.
    fn is_expected(&self) -> bool {
        self.kind.ends_with("Marker") && self.kind != "Marker"
    }
}

/// The form of a file's rotations.
#[derive(Clone, Copy)]
enum Turns {
    Quaternion,
    Euler(EulerRot),
}

pub(super) fn scene(bytes: &[u8], options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let text = crate::text::decode(bytes)?;
    let text = String::from_utf8_lossy(&text);
    let mut records = Records::new(&text);
    let mut cells = Vec::new();
    records.next(&mut cells);
    let stated: HashMap<String, String> = cells
        .chunks_exact(2)
        .map(|pair| (pair[0].trim().to_owned(), pair[1].trim().to_owned()))
        .collect();
    let turns = turns(&stated)?;
    let rows = header_rows(&mut records)?;
    let mut objects = objects(&rows);
    leave_out(&mut objects, &stated, warnings);
    if objects.len() >= options.limits.max_nodes {
        let most = format!("at most {} nodes", options.limits.max_nodes);
        return Err(limit_exceeded(most, format!("{} objects", objects.len())).into());
    }
    let mut frames = 0_usize;
    let mut times = Vec::new();
    while records.next(&mut cells) {
        if cells.iter().all(|cell| cell.trim().is_empty()) {
            continue;
        }
        let values = (frames as u64 + 1).saturating_mul(7 * objects.len() as u64);
        if values > options.limits.max_values {
            let most = format!("at most {} values", options.limits.max_values);
            return Err(limit_exceeded(most, format!("more than {frames} frames")).into());
        }
        times.extend(cell(&cells, Some(1), records.line)?);
        for object in &mut objects {
            object.read(&cells, frames, records.line, turns)?;
        }
        frames += 1;
    }
    let total = stated
        .get("Total Exported Frames")
        .and_then(|text| text.parse::<u64>().ok());
    if let Some(total) = total.filter(|total| *total > frames as u64) {
        warnings.push(Code::MissingFrames, || missing_frames(total, frames as u64));
    }
    let rate = options.frame_rate_or(rate(&stated, &times))?;
    Ok(build(objects, &stated, (frames, rate), warnings))
}

fn build(
    mut objects: Vec<Object>,
    stated: &HashMap<String, String>,
    (frames, rate): (usize, f64),
    warnings: &mut Warnings,
) -> Scene {
    let mut scene = Scene::default();
    scene.metadata.format = Some(Format::Csv);
    scene.metadata.metres_per_unit = stated.get("Length Units").and_then(|unit| metres(unit));
    scene.metadata.up = Some(UpAxis::Y);
    scene.metadata.assumptions.push(Assumption {
        topic: Topic::UpAxis,
        choice: "+Y is up".to_owned(),
        reason: "the file states no up axis; Motive exports +Y up by default".to_owned(),
        confidence: Some(Confidence::Likely),
    });
    let tracks = objects.iter_mut().map(|object| std::mem::take(&mut object.track));
    let tracks = tracks.collect();
    points::add(&mut scene, Kind::MARKERS, tracks, (frames, rate), warnings);
    let channels = scene
        .animations
        .iter_mut()
        .flat_map(|animation| &mut animation.channels);
    for (channel, object) in channels.zip(objects) {
        if !object.rotations.is_empty() {
            let (ticks, rotations) = object.rotations.into_iter().unzip();
            channel.rotation_keys = Keys::at_ticks(rotations, ticks);
        }
    }
    scene
}

/// The rows between the first line and the data. The last row has the axis names.
fn header_rows<'t>(records: &mut Records<'t>) -> Result<Vec<Vec<Cow<'t, str>>>, Failure> {
    /// The largest number of header rows: type, name, ID, parent, measured quantity, axes, and empty ones.
    const MOST: usize = 16;
    let mut rows = Vec::new();
    for _ in 0..MOST {
        let mut cells = Vec::new();
        if !records.next(&mut cells) {
            break;
        }
        if cells.iter().all(|cell| cell.trim().is_empty()) {
            continue;
        }
        let is_last = cells[0].trim() == "Frame";
        rows.push(cells);
        if is_last && rows.len() >= 4 {
            return Ok(rows);
        }
    }
    let message = "the Motive table has no header rows that describe its columns";
    Err(Box::new(
        Diagnostic::new(Code::MissingKeyword, message)
            .expected_found("rows of types, names and axes; the last one begins with Frame", "none")
            .help(EXPORT),
    ))
}

/// The objects in the order of their columns.
fn objects(rows: &[Vec<Cow<'_, str>>]) -> Vec<Object> {
    let at = |row: usize, column: usize| rows[row].get(column).map_or("", |cell| cell.trim());
    let (what, axes) = (rows.len() - 2, rows.len() - 1);
    let mut objects: Vec<Object> = Vec::new();
    let mut index_of: HashMap<(&str, &str, &str), usize> = HashMap::new();
    for column in BEFORE..rows[axes].len() {
        let key = (at(0, column), at(1, column), at(2, column));
        let index = *index_of.entry(key).or_insert_with(|| {
            let track = Track {
                name: key.1.to_owned(),
                ..Track::default()
            };
            objects.push(Object {
                kind: key.0.to_owned(),
                name: key.1.to_owned(),
                track,
                ..Object::default()
            });
            objects.len() - 1
        });
        let axis = match at(axes, column) {
            "X" => 0,
            "Y" => 1,
            "Z" => 2,
            "W" => 3,
            _ => continue,
        };
        match at(what, column) {
            "Position" if axis < 3 => objects[index].position[axis] = Some(column),
            "Rotation" => objects[index].rotation[axis] = Some(column),
            _ => {}
        }
    }
    objects
}

/// Drops objects without positions, and bones whose values are relative to their parents. Also drops the expected
/// position of a marker if the file has the seen position too.
fn leave_out(objects: &mut Vec<Object>, stated: &HashMap<String, String>, warnings: &mut Warnings) {
    objects.retain(Object::has_position);
    let is_seen = |object: &Object| object.kind == "Marker";
    let seen: Vec<String> = objects
        .iter()
        .filter(|one| is_seen(one))
        .map(|one| one.name.clone())
        .collect();
    objects.retain(|object| !(object.is_expected() && seen.contains(&object.name)));
    let is_local = stated.get("Coordinate Space").is_some_and(|space| space == "Local");
    let bones = objects.iter().filter(|object| object.kind == "Bone").count();
    if is_local && bones > 0 {
        objects.retain(|object| object.kind != "Bone");
        warnings.push(Code::IgnoredChannel, || {
            let message = format!("{bones} bones are relative to their parents, whose positions the file lacks");
            Diagnostic::new(Code::IgnoredChannel, message).help(
                "these bones were skipped; export them in global coordinates, or export the skeleton as BVH or FBX",
            )
        });
    }
}

impl Object {
    fn read(&mut self, cells: &[Cow<'_, str>], frame: usize, line: usize, turns: Turns) -> Result<(), Failure> {
        let tick = frame as f64;
        let mut position = [0.0; 3];
        for (value, column) in position.iter_mut().zip(self.position) {
            let Some(number) = cell(cells, column, line)? else {
                return Ok(());
            };
            *value = number as f32;
        }
        self.track.ticks.push(tick);
        self.track.positions.push(Vec3::from_array(position));
        let number = |axis: usize| cell(cells, self.rotation[axis], line);
        let (Some(x), Some(y), Some(z)) = (number(0)?, number(1)?, number(2)?) else {
            return Ok(());
        };
        let rotation = match turns {
            Turns::Quaternion => match number(3)? {
                Some(w) => DQuat::from_xyzw(x, y, z, w),
                None => return Ok(()),
            },
            Turns::Euler(order) => {
                // The columns are X, Y and Z for any rotation order.
                let angle = |axis: char| match axis {
                    'X' => x.to_radians(),
                    'Y' => y.to_radians(),
                    _ => z.to_radians(),
                };
                let letters = format!("{order:?}");
                let mut axes = letters.chars().map(angle);
                let mut next = || axes.next().unwrap_or_default();
                DQuat::from_euler(order, next(), next(), next())
            }
        };
        if rotation.is_finite() && rotation.length_squared() > f64::EPSILON {
            self.rotations.push((tick, rotation.normalize().as_quat()));
        }
        Ok(())
    }
}

/// The number in a cell; `None` for an empty cell.
fn cell(cells: &[Cow<'_, str>], column: Option<usize>, line: usize) -> Result<Option<f64>, Failure> {
    let Some(text) = column.and_then(|column| cells.get(column)).map(|cell| cell.trim()) else {
        return Ok(None);
    };
    if text.is_empty() {
        return Ok(None);
    }
    match number::parse(text.as_bytes()) {
        Some(number) if number.length == text.len() => Ok(Some(number.value).filter(|value| is_plausible(*value))),
        _ => {
            let message = format!("line {line}: a cell is not a number");
            Err(Box::new(
                Diagnostic::new(Code::InvalidNumber, message)
                    .expected_found("a number, or an empty cell", quote(text.as_bytes()))
                    .help(EXPORT),
            ))
        }
    }
}

fn turns(stated: &HashMap<String, String>) -> Result<Turns, Failure> {
    let word = stated.get("Rotation Type").map_or("Quaternion", String::as_str);
    Ok(match word {
        "Quaternion" | "" => Turns::Quaternion,
        "XYZ" => Turns::Euler(EulerRot::XYZ),
        "XZY" => Turns::Euler(EulerRot::XZY),
        "YXZ" => Turns::Euler(EulerRot::YXZ),
        "YZX" => Turns::Euler(EulerRot::YZX),
        "ZXY" => Turns::Euler(EulerRot::ZXY),
        "ZYX" => Turns::Euler(EulerRot::ZYX),
        other => {
            return Err(Box::new(
                Diagnostic::new(Code::UnexpectedToken, "the Rotation Type of the table is unknown")
                    .expected_found("Quaternion, or an order such as XYZ", format!("\"{other}\""))
                    .help(EXPORT),
            ));
        }
    })
}

fn metres(unit: &str) -> Option<f64> {
    match unit.to_ascii_lowercase().as_str() {
        "meters" => Some(1.0),
        "centimeters" => Some(0.01),
        "millimeters" => Some(0.001),
        "inches" => Some(0.0254),
        "feet" => Some(0.3048),
        other => points::metres(other),
    }
}

/// The frame rate in frames per second that the header states, or else the rate of the times.
fn rate(stated: &HashMap<String, String>, times: &[f64]) -> f64 {
    let number = |key: &str| stated.get(key)?.parse::<f64>().ok().filter(|rate| *rate > 0.0);
    let of_times = || match times {
        [first, .., last] if last > first => (times.len() - 1) as f64 / (last - first),
        _ => f64::NAN,
    };
    let known = number("Export Frame Rate").or_else(|| number("Capture Frame Rate"));
    known.unwrap_or_else(of_times)
}
