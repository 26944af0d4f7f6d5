//! Text tables: the arrays of this program, and point positions.
//!
//! | table | recognised by |
//! |---|---|
//! | `mocap fk`, a row for each frame and joint | the first line, a comment with the header |
//! | points, a row for each frame and point | columns `joint` (or `point`, `marker`, ...), `x`, `y`, `z`; `frame` or `time` |
//! | the motion of a robot | a first row with only numbers; the body states the robot |
//! | points, a row for each frame | columns `NAME_x`, `NAME_y`, `NAME_z` for each of at least three points |
//!
//! An empty cell or a NaN cell is a gap. All tables become named arrays, which `layouts` reads like the arrays of any
//! file.

use std::borrow::Cow;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::files::{PointColumns, Records, is_own_csv};
use serde::Deserialize;

use super::layouts::{BASE_OF_ROBOT, TABLE};
use super::ndarray::{Bytes, Entries, Kind, NdArray};
use super::point_rows::{PointRows, TABLES, floats, is_survey, table_of_survey};
use crate::Failure;
use crate::text::quote;
use crate::warnings::Warnings;

/// The fields of this program's array header that rows need.
#[derive(Deserialize)]
struct Header {
    rotation: String,
    joints: Vec<Joint>,
}

#[derive(Deserialize)]
struct Joint {
    #[doc(hidden)]
    pub name: String,
}

/// The names of the rotation columns. `rotation` is the word in the header that names the form of the rotations.
pub(super) fn rotation_columns(rotation: &str) -> &'static [&'static str] {
    match rotation {
        "6d" => &["r00", "r10", "r20", "r01", "r11", "r21"],
        "matrix" => &["r00", "r01", "r02", "r10", "r11", "r12", "r20", "r21", "r22"],
        "euler" => &["ex", "ey", "ez"],
        _ => &["qx", "qy", "qz", "qw"],
    }
}

/// The arrays of a table.
pub(super) fn entries(bytes: &[u8], warnings: &mut Warnings) -> Result<Entries<'static>, Failure> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let message = format!("the table is not UTF-8 text from byte {} on", error.valid_up_to());
        Box::new(Diagnostic::new(Code::BinaryFile, message).help("export it as UTF-8"))
    })?;
    match is_own_csv(bytes) {
        true => own(text, warnings),
        false if is_without_header(text) => rows(text, warnings),
        false => points(text, warnings),
    }
}

pub(super) fn refused(line: usize, message: impl Into<String>) -> Diagnostic {
    Diagnostic::new(Code::RowLength, format!("line {line}: {}", message.into()))
}

/// The warning for a table that is cut off in its last frame.
pub(super) fn cut_frame(line: usize) -> Diagnostic {
    refused(line, "the file ends inside its last frame, which was dropped")
        .help("the file is cut off: export or download it again")
}

/// Whether the table has no further record.
pub(super) fn is_last(records: &Records<'_>) -> bool {
    !records.clone().next(&mut Vec::new())
}

/// The arrays of a table that `mocap fk` wrote.
fn own(text: &str, warnings: &mut Warnings) -> Result<Entries<'static>, Failure> {
    let mut records = Records::new(text);
    let mut cells = Vec::new();
    let comment = match text.starts_with('#') {
        true => Cow::Borrowed(records.whole_line()),
        false => {
            records.next(&mut cells);
            cells.swap_remove(0)
        }
    };
    let json = comment.strip_prefix("# ").unwrap_or(&comment);
    let header: Header = serde_json::from_str(json).map_err(|error| {
        let message = format!("the first line is not a header that mocap writes: {error}");
        Box::new(Diagnostic::new(Code::UnexpectedToken, message).help("write it again with mocap fk"))
    })?;
    let rotation = rotation_columns(&header.rotation);
    let expected: Vec<&str> = ["frame", "time", "joint", "x", "y", "z"]
        .into_iter()
        .chain(rotation.iter().copied())
        .collect();
    records.next(&mut cells);
    if !cells.iter().take(expected.len()).eq(&expected) {
        let found = cells.join(",");
        let error = refused(records.line, "the columns differ from the columns that mocap fk writes");
        return Err(Box::new(
            error.expected_found(format!("{}, ...", expected.join(",")), found),
        ));
    }
    let (width, count) = (cells.len(), header.joints.len());
    let (mut positions, mut rotations, mut rows) = (Vec::new(), Vec::new(), 0_usize);
    while records.next(&mut cells) {
        let (frame, joint) = (rows / count.max(1), rows % count.max(1));
        if cells.len() < width && frame > 0 && is_last(&records) {
            break;
        }
        if cells.len() != width {
            let error = refused(
                records.line,
                "the number of cells in the row differs from the number of columns",
            );
            return Err(Box::new(
                error
                    .expected_found(width.to_string(), cells.len().to_string())
                    .help("the file is cut off or damaged: write it again with mocap fk"),
            ));
        }
        let name = header.joints.get(joint).map_or("", |joint| &joint.name);
        // Some names have a prefix, because a spreadsheet would evaluate them as formulas.
        let is_name = cells[2] == name || cells[2].strip_prefix('\'') == Some(name);
        if cells[0].parse() != Ok(frame) || !is_name {
            let error = refused(records.line, "the row does not have the next frame or joint");
            return Err(Box::new(
                error
                    .expected_found(format!("{frame},{name}"), format!("{},{}", cells[0], cells[2]))
                    .help("the rows are reordered or incomplete: write the table again with mocap fk"),
            ));
        }
        for (at, cell) in cells[3..expected.len()].iter().enumerate() {
            let number = number(cell, records.line, expected[3 + at])?;
            if at < 3 { &mut positions } else { &mut rotations }.push(number);
        }
        rows += 1;
    }
    let (frames, rest) = (rows / count.max(1), rows % count.max(1));
    if (rest > 0 || !cells.is_empty()) && frames > 0 {
        warnings.push(Code::RowLength, || {
            cut_frame(records.line).expected_found(format!("{count} rows"), format!("{rest} whole ones"))
        });
        positions.truncate(frames * count * 3);
        rotations.truncate(frames * count * rotation.len());
    } else if rest > 0 {
        let error = refused(records.line, "the first frame does not have all joints");
        return Err(Box::new(
            error
                .expected_found(format!("{count} rows"), format!("{rest}"))
                .help("the file is cut off: write it again with mocap fk"),
        ));
    }
    own_entries(json, (frames, count), &positions, &rotations, rotation.len())
}

/// The arrays of a table that mocap wrote, with the names and shapes of mocap's `.npz`.
pub(super) fn own_entries(
    header: &str,
    (frames, joints): (usize, usize),
    positions: &[f32],
    rotations: &[f32],
    width: usize,
) -> Result<Entries<'static>, Failure> {
    let mut entries = Entries::default();
    let characters = header.chars().flat_map(|character| u32::from(character).to_le_bytes());
    let kind = Kind::Text(header.chars().count());
    let text = NdArray::new(
        "header",
        (kind, false),
        Vec::new(),
        false,
        Bytes::made(characters.collect()),
    )?;
    entries.arrays.push(("header".to_owned(), text));
    let rotation_shape = match width {
        9 => vec![frames, joints, 3, 3],
        width => vec![frames, joints, width],
    };
    for (name, shape, values) in [
        ("positions", vec![frames, joints, 3], positions),
        ("rotations", rotation_shape, rotations),
    ] {
        entries.arrays.push((name.to_owned(), floats(name, shape, values)?));
    }
    Ok(entries)
}

fn number(cell: &str, line: usize, column: &str) -> Result<f32, Failure> {
    let number = fast_float2::parse(cell.trim().as_bytes());
    number.map_err(|_| {
        let error = refused(line, format!("the cell {column} is not a number"));
        Box::new(error.expected_found("a number", quote(cell.as_bytes())))
    })
}

/// Whether the first row has only numbers.
fn is_without_header(text: &str) -> bool {
    let (mut records, mut cells) = (Records::new(text), Vec::new());
    records.next(&mut cells);
    cells.len() > BASE_OF_ROBOT && cells.iter().all(|cell| double(cell).is_some())
}

fn double(cell: &str) -> Option<f64> {
    fast_float2::parse(cell.trim().as_bytes()).ok()
}

/// The numbers of a table without a header, as one array.
fn rows(text: &str, warnings: &mut Warnings) -> Result<Entries<'static>, Failure> {
    let (mut records, mut cells) = (Records::new(text), Vec::new());
    let (mut bytes, mut width, mut count) = (Vec::new(), 0, 0_usize);
    while records.next(&mut cells) {
        if matches!(cells.as_slice(), [only] if only.trim().is_empty()) {
            continue;
        }
        if count == 0 {
            width = cells.len();
        }
        if cells.len() < width && count > 0 && is_last(&records) {
            warnings.push(Code::RowLength, || {
                cut_frame(records.line).expected_found(width.to_string(), cells.len().to_string())
            });
            break;
        }
        if cells.len() != width {
            let error = refused(
                records.line,
                "the number of cells in the row differs from the first row",
            );
            return Err(Box::new(
                error.expected_found(width.to_string(), cells.len().to_string()),
            ));
        }
        for cell in &cells {
            let number = double(cell).ok_or_else(|| {
                let error = refused(records.line, "a cell is not a number");
                let found = cell.chars().take(40).collect::<String>();
                Box::new(error.expected_found("a number", format!("{found:?}")))
            })?;
            bytes.extend(number.to_le_bytes());
        }
        count += 1;
    }
    let kind = (Kind::Float(8), false);
    let array = NdArray::new(TABLE, kind, vec![count, width], false, Bytes::made(bytes))?;
    let arrays = vec![(TABLE.to_owned(), array)];
    Ok(Entries { arrays, is_cut: false })
}

/// The array of point positions in a table.
fn points(text: &str, warnings: &mut Warnings) -> Result<Entries<'static>, Failure> {
    let mut records = Records::new(text);
    let mut cells = Vec::new();
    records.names(&mut cells);
    let names: Vec<String> = cells.iter().map(|cell| cell.trim().to_owned()).collect();
    let Some(columns) = PointColumns::of(&names) else {
        if is_survey(&names) {
            return Err(Box::new(table_of_survey()));
        }
        let found: Vec<&str> = names.iter().take(12).map(String::as_str).collect();
        let message = "the table is not a motion: its columns are not positions";
        return Err(Box::new(
            Diagnostic::new(Code::MissingKeyword, message)
                .expected_found("frame,joint,x,y,z or NAME_x,NAME_y,NAME_z, ...", found.join(","))
                .help(TABLES),
        ));
    };
    let mut rows = PointRows::new(&columns, &names, warnings);
    let mut has_rows = false;
    while records.next(&mut cells) {
        if let [only] = cells.as_slice()
            && only.trim().is_empty()
        {
            continue;
        }
        if cells.len() < names.len() && has_rows && is_last(&records) {
            warnings.push(Code::RowLength, || {
                let found = cells.len().to_string();
                cut_frame(records.line).expected_found(names.len().to_string(), found)
            });
            break;
        }
        if cells.len() < names.len() {
            let error = refused(records.line, "the row has fewer cells than there are columns");
            return Err(Box::new(
                error
                    .expected_found(names.len().to_string(), cells.len().to_string())
                    .help("the file is cut off or damaged: export it again"),
            ));
        }
        // An empty cell or a cell with NaN is a gap.
        let read = |column: usize| match cells[column].trim() {
            "" | "NA" | "N/A" | "null" | "None" => Ok(f32::NAN),
            cell => number(cell, records.line, &names[column]),
        };
        rows.add(records.line, read, |column| Cow::Borrowed(cells[column].trim()))?;
        has_rows = true;
    }
    rows.into_entries()
}
