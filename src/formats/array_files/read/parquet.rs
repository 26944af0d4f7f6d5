//! Parquet files with this program's arrays. `mocap fk` writes a row for each frame and joint, and `mocap pack --table
//! clips` writes a row for each clip. The reader decodes the strings of `mocap fk` a few rows at a time, because a text
//! column can be far longer than its file.

use std::panic::{AssertUnwindSafe, catch_unwind};

use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type, Int32Type};
use arrow_array::{Array, RecordBatch};
use bytes::Bytes;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, limit_exceeded};
use mocap_scene::scene::{Format, Scene};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ArrowReaderOptions, ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder};

use super::csv::{own_entries, rotation_columns};
use super::layouts;
use super::parquet_pages;
use super::point_rows::{TABLES, is_survey, table_of_survey};
use crate::warnings::Warnings;
use crate::{Failure, ReadOptions};

/// The largest number of rows to decode at once.
const BATCH: usize = 8192;

/// The largest number of text bytes to decode at once.
const TEXTS: u64 = 16 << 20;

/// The largest difference, in frames, between the time of a row and the time of its frame.
const SAME_TIME: f64 = 1e-6;

type Builder = ParquetRecordBatchReaderBuilder<Bytes>;

/// The rows of `mocap fk`, sorted by frame and joint.
#[doc(hidden)]
pub struct ParquetRows {
    /// The header as JSON.
    #[doc(hidden)]
    pub header: String,
    #[doc(hidden)]
    pub frames: usize,
    /// The joint positions: frames x joints x 3 numbers.
    #[doc(hidden)]
    pub positions: Vec<f32>,
    /// The rotations: frames x joints x the count of numbers in a rotation.
    #[doc(hidden)]
    pub rotations: Vec<f32>,
    /// The velocities: frames x joints x 3 numbers, if the table has velocities.
    #[doc(hidden)]
    pub velocities: Option<Vec<f32>>,
}

/// The rows of a `mocap fk` table; `None` for another table.
///
/// # Errors
/// The file is broken, or a row does not have the expected frame, time and joint.
#[doc(hidden)]
pub fn parquet_rows(bytes: &[u8], limits: &Limits) -> mocap_scene::error::Result<Option<ParquetRows>> {
    let read = catch_unwind(AssertUnwindSafe(|| {
        let (builder, longest) = open(bytes, limits)?;
        let header = builder.schema().metadata().get("mocap").cloned();
        header.map(|header| rows(builder, longest, header)).transpose()
    }));
    Ok(read.unwrap_or_else(|_| Err(broken("its pages do not match its metadata")))?)
}

fn broken(error: impl std::fmt::Display) -> Failure {
    let message = format!("the Parquet file cannot be read: {error}");
    Box::new(Diagnostic::new(Code::UnexpectedEnd, message).help("write or download it again"))
}

fn no_motion(message: &str, found: String) -> Failure {
    Box::new(
        Diagnostic::new(Code::MissingKeyword, message)
            .expected_found(
                "a table that mocap fk wrote, or a table of clips that mocap pack wrote",
                found,
            )
            .help(TABLES),
    )
}

/// The scene of a Parquet file. The library that decodes Parquet panics on some files with unexpected pages.
pub(super) fn scene(bytes: &[u8], options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let read = catch_unwind(AssertUnwindSafe(|| tables(bytes, options, warnings)));
    read.unwrap_or_else(|_| Err(broken("its pages do not match its metadata")))
}

fn tables(bytes: &[u8], options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let (builder, longest) = open(bytes, &options.limits)?;
    let names: Vec<String> = builder
        .schema()
        .fields()
        .iter()
        .map(|field| field.name().clone())
        .collect();
    let header = builder.schema().metadata().get("mocap").cloned();
    let has = |name: &str| names.iter().any(|own| own == name);
    match header {
        Some(header) => {
            let read = rows(builder, longest, header)?;
            let header = parsed(&read.header)?;
            let (count, width) = (header.joints.len().max(1), rotation_columns(&header.rotation).len());
            let (positions, rotations) = (&read.positions, &read.rotations);
            let entries = own_entries(&read.header, (read.frames, count), positions, rotations, width)?;
            layouts::scene(&entries, Format::Parquet, options, warnings)
        }
        None if has("header") && has("positions") && has("rotations") => clips(builder, options, warnings),
        None if has("clip") && has("joint") && has("x") => {
            let message = "the rows of mocap pack do not describe their numbers";
            let found = no_motion(message, format!("the columns {}", names.join(", ")));
            Err(Box::new(found.help("run mocap pack with {table} clips")))
        }
        None if is_survey(&names) => Err(Box::new(table_of_survey())),
        None => {
            let found: Vec<&str> = names.iter().take(12).map(String::as_str).collect();
            Err(no_motion(
                "the Parquet file is not a motion",
                format!("the columns {}", found.join(", ")),
            ))
        }
    }
}

/// Opens a file, and checks its pages against their headers. Also returns the size in bytes of its longest text
/// dictionary.
fn open(bytes: &[u8], limits: &Limits) -> Result<(Builder, u64), Failure> {
    let builder = Builder::try_new_with_options(Bytes::copy_from_slice(bytes), ArrowReaderOptions::new());
    let builder = builder.map_err(broken)?;
    let most = limits.expanded_values(bytes.len() as u64);
    let longest = parquet_pages::check(bytes, builder.metadata(), most)?;
    Ok((builder, longest))
}

/// Reads only the columns with these names.
fn columns(builder: Builder, names: &[&str], batch: usize) -> Result<ParquetRecordBatchReader, Failure> {
    let fields = builder.schema().fields();
    let roots = fields
        .iter()
        .enumerate()
        .filter(|(_, field)| names.contains(&field.name().as_str()));
    let roots: Vec<usize> = roots.map(|(root, _)| root).collect();
    if roots.len() != names.len() {
        let found: Vec<&str> = fields.iter().map(|field| field.name().as_str()).collect();
        let message = format!("the table does not have the columns {} once each", names.join(", "));
        return Err(no_motion(&message, found.join(", ")));
    }
    let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
    builder
        .with_projection(mask)
        .with_batch_size(batch)
        .build()
        .map_err(broken)
}

/// The header fields that rows need.
#[derive(serde::Deserialize)]
struct Header {
    frame_rate: f64,
    rotation: String,
    joints: Vec<Joint>,
}

#[derive(serde::Deserialize)]
struct Joint {
    #[doc(hidden)]
    pub name: String,
}

fn parsed(header: &str) -> Result<Header, Failure> {
    serde_json::from_str(header).map_err(|error| {
        no_motion(
            &format!("the header of the table is not one that mocap writes: {error}"),
            String::new(),
        )
    })
}

/// Reads a row for each frame and joint. `longest` is the largest length of a string.
fn rows(builder: Builder, longest: u64, json: String) -> Result<ParquetRows, Failure> {
    let header = parsed(&json)?;
    let rotation = rotation_columns(&header.rotation);
    let has_velocities = builder.schema().fields().iter().any(|field| field.name() == "vx");
    let velocity: &[&str] = if has_velocities { &["vx", "vy", "vz"] } else { &[] };
    let position = ["x", "y", "z"];
    let names = [&["frame", "time", "joint"], &position[..], rotation, velocity].concat();
    let batch_rows = (TEXTS / longest.max(1)).clamp(1, BATCH as u64) as usize;
    let count = header.joints.len().max(1);
    let (mut positions, mut rotations, mut velocities, mut row) = (Vec::new(), Vec::new(), Vec::new(), 0_usize);
    for batch in columns(builder, &names, batch_rows)? {
        let batch = batch.map_err(broken)?;
        let column = |name: &str| batch.column_by_name(name).filter(|column| column.null_count() == 0);
        let frames = column("frame").and_then(|column| column.as_primitive_opt::<Int32Type>());
        let times = column("time").and_then(|column| column.as_primitive_opt::<Float64Type>());
        let joints = column("joint").and_then(|column| column.as_string_opt::<i32>());
        let (Some(frames), Some(times), Some(joints)) = (frames, times, joints) else {
            let message = "the columns frame, time and joint are not int32, float64 and text, or have gaps";
            return Err(no_motion(message, String::new()));
        };
        let numbers = |names: &[&str]| {
            names
                .iter()
                .map(|name| floats(&batch, name))
                .collect::<Result<Vec<_>, _>>()
        };
        let (translations, turns, speeds) = (numbers(&position)?, numbers(rotation)?, numbers(velocity)?);
        for at in 0..batch.num_rows() {
            let frame = row / count;
            let name = header.joints.get(row % count).map_or("", |joint| &joint.name);
            let is_time = (times.value(at) * header.frame_rate - frame as f64).abs() < SAME_TIME;
            if frames.value(at) as usize != frame || !is_time || joints.value(at) != name {
                let shown: String = joints.value(at).chars().take(40).collect();
                let found = format!("frame {}, {} s, \"{shown}\"", frames.value(at), times.value(at));
                let message = format!("row {row} of the table does not have the next frame, time or joint");
                return Err(Box::new(
                    Diagnostic::new(Code::RowLength, message)
                        .expected_found(
                            format!("frame {frame}, {} s, \"{name}\"", frame as f64 / header.frame_rate),
                            found,
                        )
                        .help("the rows are reordered or incomplete: write the table again with mocap fk"),
                ));
            }
            positions.extend(translations.iter().map(|column| column[at]));
            rotations.extend(turns.iter().map(|column| column[at]));
            velocities.extend(speeds.iter().map(|column| column[at]));
            row += 1;
        }
    }
    if !row.is_multiple_of(count) {
        let message = "the last frame of the table does not have all joints";
        return Err(Box::new(
            Diagnostic::new(Code::RowLength, message)
                .expected_found(format!("{count} rows"), (row % count).to_string())
                .help("write it again with mocap fk"),
        ));
    }
    Ok(ParquetRows {
        header: json,
        frames: row / count,
        positions,
        rotations,
        velocities: has_velocities.then_some(velocities),
    })
}

/// A column of numbers without gaps.
fn floats<'b>(batch: &'b RecordBatch, name: &str) -> Result<&'b [f32], Failure> {
    let column = batch
        .column_by_name(name)
        .and_then(|column| column.as_primitive_opt::<Float32Type>());
    match column {
        Some(column) if column.null_count() == 0 => Ok(column.values()),
        _ => Err(no_motion(
            &format!("the column {name} is not float32, or has gaps"),
            String::new(),
        )),
    }
}

/// Reads a row for each clip. The clips of one skeleton become the clips of a scene.
fn clips(builder: Builder, options: &ReadOptions, warnings: &mut Warnings) -> Result<Scene, Failure> {
    let mut left = options
        .limits
        .expanded_values(builder.metadata().file_metadata().num_rows().max(0) as u64);
    let mut scene: Option<Scene> = None;
    // Read one row at a time, because a single row can be as long as all other rows together.
    for batch in columns(builder, &["clip", "header", "positions", "rotations"], 1)? {
        let batch = batch.map_err(broken)?;
        let Some((json, [positions, rotations])) = clip(&batch)? else {
            continue;
        };
        // A dictionary has a string once, but any number of rows may refer to it.
        left = left
            .checked_sub(json.len() as u64)
            .ok_or_else(|| limit_exceeded("headers in proportion to the file".to_owned(), "longer ones".to_owned()))?;
        let header = parsed(json)?;
        let (count, width) = (header.joints.len().max(1), rotation_columns(&header.rotation).len());
        let frames = positions.len() / (3 * count);
        let entries = own_entries(json, (frames, count), positions, rotations, width)?;
        let mut read = layouts::scene(&entries, Format::Parquet, options, warnings)?;
        let name = batch
            .column_by_name("clip")
            .and_then(|column| column.as_string_opt::<i32>());
        if let (Some(animation), Some(name)) = (read.animations.first_mut(), name) {
            animation.name = name.value(0).chars().take(options.limits.max_name_bytes / 4).collect();
        }
        match &mut scene {
            None => scene = Some(read),
            Some(scene) if scene.nodes == read.nodes => scene.animations.append(&mut read.animations),
            Some(_) => {
                let message = "the table has clips of several skeletons, but a scene has one skeleton";
                return Err(Box::new(Diagnostic::new(Code::UnreadableFormat, message).help(
                    "select the clips of one skeleton (the column skeleton) and write them to a table",
                )));
            }
        }
    }
    scene.ok_or_else(|| no_motion("the table has no clips", String::new()))
}

/// The header of a clip, its positions and its rotations.
type Clip<'b> = (&'b str, [&'b [f32]; 2]);

/// The header and the numbers of a row; `None` if `mocap pack` could not read the file of the clip.
fn clip(batch: &RecordBatch) -> Result<Option<Clip<'_>>, Failure> {
    let header = batch
        .column_by_name("header")
        .and_then(|column| column.as_string_opt::<i32>());
    let header = header.ok_or_else(|| no_motion("the column header is not text", String::new()))?;
    if batch.num_rows() == 0 || header.is_null(0) {
        return Ok(None);
    }
    let numbers = |name: &str| {
        let lists = batch
            .column_by_name(name)
            .and_then(|column| column.as_list_opt::<i32>());
        let rows = lists.and_then(|lists| lists.values().as_fixed_size_list_opt());
        let values = rows.and_then(|rows| rows.values().as_primitive_opt::<Float32Type>());
        let values = values.filter(|values| values.null_count() == 0);
        let values =
            values.ok_or_else(|| no_motion(&format!("the column {name} is not a list of numbers"), String::new()))?;
        Ok::<&[f32], Failure>(values.values())
    };
    Ok(Some((header.value(0), [numbers("positions")?, numbers("rotations")?])))
}
