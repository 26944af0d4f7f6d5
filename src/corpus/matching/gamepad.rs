//! A file with the sticks of a gamepad over time.

use std::borrow::Cow;

use glam::Vec2;
use serde::Deserialize;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::Records;

/// The fraction of a stick's range that counts as its centre: sticks do not return exactly to the centre.
const DEAD_ZONE: f32 = 0.1;
/// The largest time of a row, in seconds.
const LONGEST: f64 = 3600.0;
/// The largest number of rows: an hour of a gamepad at 1000 samples per second.
const MOST_ROWS: usize = 3_600_000;
/// The columns of a CSV table. The objects of a JSON list have keys with these names.
const COLUMNS: [&str; 5] = ["seconds", "left_x", "left_y", "right_x", "right_y"];

/// The two sticks of a gamepad over time: x to the right and y forward, from -1 to 1. `docs/search.md` describes the
/// file.
///
/// [`Controller::play`](super::Controller::play) has an example.
#[derive(Clone, Debug, PartialEq)]
pub struct Gamepad {
    rows: Vec<Row>,
}

/// The positions of the sticks, starting at `seconds`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    seconds: f64,
    left_x: f32,
    left_y: f32,
    #[serde(default)]
    right_x: f32,
    #[serde(default)]
    right_y: f32,
}

impl Gamepad {
    /// Parses the text of a file: a CSV table or a JSON list.
    ///
    /// ```
    /// use mocap::matching::Gamepad;
    ///
    /// let table = Gamepad::parse("seconds,left_x,left_y\n0,0,1\n2.5,1,0\n4,0,0\n")?;
    /// let list = r#"[{"seconds": 0, "left_x": 0, "left_y": 1}, {"seconds": 2.5, "left_x": 1, "left_y": 0},
    ///     {"seconds": 4, "left_x": 0, "left_y": 0}]"#;
    /// assert_eq!(Gamepad::parse(list)?, table);
    /// assert_eq!(table.seconds(), 4.0);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidArrays`]. The message names the line of a table, or the row of a list.
    pub fn parse(text: &str) -> Result<Self> {
        let rows = match text.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']) {
            list if list.starts_with('[') => {
                let rows: serde_json::Result<Vec<Row>> = serde_json::from_str(list);
                let rows = rows.map_err(|error| invalid(format!("its list: {error}")))?;
                rows.into_iter()
                    .enumerate()
                    .map(|(index, row)| (format!("row {}", index + 1), row))
                    .collect()
            }
            _ => table(text)?,
        };
        checked(rows)
    }

    /// The duration in seconds: the time of the last row.
    pub fn seconds(&self) -> f64 {
        self.rows[self.rows.len() - 1].seconds
    }

    /// The left and the right stick at a time, each at most 1 long. The values of a row apply until the next row.
    pub fn at(&self, seconds: f64) -> [Vec2; 2] {
        let after = self.rows.partition_point(|row| row.seconds <= seconds);
        let Row {
            left_x,
            left_y,
            right_x,
            right_y,
            ..
        } = self.rows[after.saturating_sub(1)];
        [Vec2::new(left_x, left_y), Vec2::new(right_x, right_y)].map(|stick| match stick.length() < DEAD_ZONE {
            true => Vec2::ZERO,
            false => stick.clamp_length_max(1.0),
        })
    }
}

/// The rows of a table, each with its line.
fn table(text: &str) -> Result<Vec<(String, Row)>> {
    let mut records = Records::new(text);
    let mut cells: Vec<Cow<'_, str>> = Vec::new();
    records.names(&mut cells);
    let mut columns = [None; COLUMNS.len()];
    for (place, cell) in cells.iter().enumerate() {
        let known = COLUMNS.iter().position(|column| *column == cell.trim());
        match known {
            Some(column) if columns[column].is_none() => columns[column] = Some(place),
            _ => {
                let found = mocap_scene::error::visible(cell.trim()).into_owned();
                return Err(of_columns("a column is unknown or appears twice", found).into());
            }
        }
    }
    if let Some(missing) = (0..3).find(|column| columns[*column].is_none()) {
        return Err(of_columns("a column is missing", format!("no {}", COLUMNS[missing])).into());
    }
    let count = cells.len();
    let mut rows = Vec::new();
    while records.next(&mut cells) {
        if cells.len() == 1 && cells[0].trim().is_empty() {
            continue;
        }
        let line = format!("line {}", records.line);
        if cells.len() != count {
            return Err(invalid(format!(
                "{line} has {} cells, and there are {count} columns",
                cells.len()
            ))
            .into());
        }
        let number = |column: usize| -> Result<f64> {
            let Some(place) = columns[column] else { return Ok(0.0) };
            let cell = cells[place].trim();
            let wrong = || {
                let found = mocap_scene::error::visible(cell).into_owned();
                invalid(format!("{line}, {}", COLUMNS[column])).expected_found("a number", found)
            };
            Ok(cell.parse().map_err(|_| wrong())?)
        };
        let row = Row {
            seconds: number(0)?,
            left_x: number(1)? as f32,
            left_y: number(2)? as f32,
            right_x: number(3)? as f32,
            right_y: number(4)? as f32,
        };
        rows.push((line, row));
        if rows.len() > MOST_ROWS {
            break;
        }
    }
    Ok(rows)
}

/// Rows in the order of their times, with sticks within their range.
fn checked(rows: Vec<(String, Row)>) -> Result<Gamepad> {
    if rows.len() > MOST_ROWS {
        return Err(invalid(format!("the file has more than {MOST_ROWS} rows")).into());
    }
    let mut before = -1.0;
    for (place, row) in &rows {
        let seconds = row.seconds;
        // This also refuses NaN, which is in no range.
        if !(0.0..=LONGEST).contains(&seconds) || seconds <= before {
            let expected = match before < 0.0 {
                true => format!("0 to {LONGEST}"),
                false => format!("more than the {before} of the row before, and at most {LONGEST}"),
            };
            let wrong = invalid(format!("{place}, seconds"));
            return Err(wrong.expected_found(expected, seconds.to_string()).into());
        }
        before = seconds;
        let sticks = [row.left_x, row.left_y, row.right_x, row.right_y];
        if let Some((index, value)) = (1..).zip(sticks).find(|(_, value)| !(-1.0..=1.0).contains(value)) {
            let wrong = invalid(format!("{place}, {}", COLUMNS[index]));
            return Err(wrong.expected_found("-1 to 1", value.to_string()).into());
        }
    }
    match rows.last() {
        Some((_, last)) if last.seconds > 0.0 => Ok(Gamepad {
            rows: rows.into_iter().map(|(_, row)| row).collect(),
        }),
        _ => Err(
            invalid("the file has no row after 0 seconds: the time of the last row is the duration".to_owned()).into(),
        ),
    }
}

fn of_columns(what: &str, found: String) -> Diagnostic {
    let expected = "seconds, left_x, left_y, and with a second stick right_x, right_y";
    invalid(what.to_owned()).expected_found(expected, found)
}

fn invalid(why: String) -> Diagnostic {
    Diagnostic::new(
        Code::InvalidArrays,
        format!("the file is not a recording of gamepad sticks: {why}"),
    )
}
