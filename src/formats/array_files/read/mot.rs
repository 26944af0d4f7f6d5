//! OpenSim's motion files, `.mot` and `.sto`: a column of numbers for each angle.
//!
//! | lines | contents |
//! |---|---|
//! | first | the name of the motion |
//! | others up to `endheader` | `nRows=`, `nColumns=`, `inDegrees=yes` or `no`, and text of the writing program |
//! | the next one | the column names; the first is `time`, in seconds |
//! | others | a frame: a number for each column, separated by tabs or spaces |
//!
//! The format is described by OpenSim, *Motion (.mot) Files* and *Storage (.sto) Files*.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, limit_exceeded};

use crate::array_files::END_OF_HEADER;
use crate::text::table::{Table, cells, words};
use crate::text::{Word, decode, decode_name, is_binary, quote};
use crate::warnings::{Warnings, cut_row};
use crate::{Failure, STATE_THE_RATE};

/// The largest number of header lines. Files of OpenSim have ten; some files repeat the settings of the tool that wrote
/// the file.
const LONGEST_HEADER: usize = 1000;

/// The columns of a file.
pub(super) struct Columns {
    pub(super) names: Vec<String>,
    /// The times of the rows, in seconds.
    pub(super) times: Vec<f64>,
    /// The values of each named column, frame by frame.
    pub(super) values: Vec<Vec<f64>>,
    /// Whether angles are in degrees. Otherwise they are in radians.
    pub(super) in_degrees: bool,
}

/// The values of a column that are not finite: the first one, its frame, and their number.
#[derive(Clone, Copy)]
struct NonFiniteValues<'a> {
    first: Word<'a>,
    frame: usize,
    count: u64,
}

impl Columns {
    /// # Errors
    /// A line does not belong in such a file, there is no row, or the file exceeds the limits.
    pub(super) fn read(bytes: &[u8], limits: &Limits, warnings: &mut Warnings) -> Result<Self, Failure> {
        let text = decode(bytes)?;
        if is_binary(&text) {
            return Err(Box::new(Diagnostic::new(Code::BinaryFile, "the file is not text")));
        }
        let mut table = Table::new(&text);
        let Header { in_degrees, rows } = header(&mut table)?;
        let line = table.header_line("the names of the columns")?;
        let mut names = words(line).into_iter();
        if names.next().is_none_or(|word| !word.is("time")) {
            return Err(table.refused(
                line,
                "the line with the column names is missing",
                "time, and the names of columns",
            ));
        }
        let names: Vec<String> = names.map(|word| decode_name(word.bytes)).collect();
        let mut columns = Self {
            values: vec![Vec::new(); names.len()],
            times: Vec::new(),
            in_degrees,
            names,
        };
        let mut not_finite = vec![None; columns.names.len()];
        while let Some(line) = table.next_line() {
            let is_short = row_cells(line).len() < columns.names.len() + 1;
            if table.is_cut_off(line, is_short, columns.times.len(), rows) {
                warnings.push(Code::RowLength, || cut_row(table.cursor.locate(line)));
                break;
            }
            columns.row(&table, line, limits, &mut not_finite)?;
        }
        if columns.times.is_empty() {
            return Err(Box::new(
                Diagnostic::new(Code::NoMotion, "the file has no rows")
                    .at(table.cursor.locate_end())
                    .expected_found("a row of numbers for each frame", "the end of the file")
                    .help("the file is cut off after its column names: export it again"),
            ));
        }
        table.check_frames(columns.times.len(), rows, warnings);
        columns.say_not_finite(&table, &not_finite, warnings);
        Ok(columns)
    }

    fn say_not_finite(&self, table: &Table<'_>, found: &[Option<NonFiniteValues<'_>>], warnings: &mut Warnings) {
        for (name, found) in std::iter::zip(&self.names, found) {
            let Some(found) = found else { continue };
            warnings.push(Code::NonFiniteValue, || {
                let message = format!("column {name}, frame {}: the value is not a finite number", found.frame);
                let mut warning = Diagnostic::new(Code::NonFiniteValue, message)
                    .at(table.cursor.locate(found.first))
                    .expected_found("a finite number", quote(found.first.bytes))
                    .help("the value of the previous frame was used, or 0 in the first frame");
                warning.count = found.count;
                warning
            });
        }
    }

    fn row<'a>(
        &mut self,
        table: &Table<'a>,
        line: Word<'a>,
        limits: &Limits,
        not_finite: &mut [Option<NonFiniteValues<'a>>],
    ) -> Result<(), Failure> {
        let cells = row_cells(line);
        let (expected, frame) = (self.names.len() + 1, self.times.len());
        if cells.len() != expected {
            return Err(Box::new(
                Diagnostic::new(
                    Code::RowLength,
                    format!("the number of values in frame {frame} differs from the number of columns"),
                )
                .at(table.cursor.locate(line))
                .expected_found(format!("{expected} numbers"), format!("{}", cells.len()))
                .help("the file is cut off there, or was changed by hand: export it again"),
            ));
        }
        let count = (frame as u64 + 1).saturating_mul(expected as u64);
        if count > limits.max_values {
            let found = format!("more than {frame} frames of {expected} columns");
            return Err(Box::new(limit_exceeded(
                format!("at most {} values", limits.max_values),
                found,
            )));
        }
        self.times.push(table.number(cells[0], "a time")?);
        for ((values, cell), not_finite) in self.values.iter_mut().zip(&cells[1..]).zip(not_finite) {
            let value = table.number(*cell, "a value")?;
            if value.is_finite() {
                values.push(value);
                continue;
            }
            values.push(values.last().copied().unwrap_or(0.0));
            let first = NonFiniteValues {
                first: *cell,
                frame,
                count: 0,
            };
            not_finite.get_or_insert(first).count += 1;
        }
        Ok(())
    }

    /// The values of the column with this name.
    pub(super) fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|own| own.eq_ignore_ascii_case(name))?;
        Some(&self.values[index])
    }

    /// The first row whose time step is much longer or shorter than a frame at `rate` frames per second.
    pub(super) fn uneven_row(&self, rate: f64) -> Option<usize> {
        /// The largest deviation of a time step, as a fraction, in an evenly sampled file.
        const UNEVEN: f64 = 0.1;

        /// The deviation in seconds that is always allowed: files have as few as three decimals.
        const ROUNDED: f64 = 0.001;
        let step = 1.0 / rate;
        let is_uneven = |pair: &[f64]| (pair[1] - pair[0] - step).abs() > f64::max(UNEVEN * step, ROUNDED);
        self.times.windows(2).position(is_uneven).map(|row| row + 1)
    }

    /// The frame rate in frames per second from the first and the last time.
    ///
    /// # Errors
    /// The times give no rate.
    pub(super) fn rate(&self) -> Result<f64, Failure> {
        let found = match self.times.as_slice() {
            [first, .., last] if last > first => return Ok((self.times.len() as f64 - 1.0) / (last - first)),
            [first, .., last] => format!("{first} in the first and {last} in the last"),
            _ => "a single row".to_owned(),
        };
        Err(Box::new(
            Diagnostic::new(Code::FrameTime, "the times of the rows give no frame rate")
                .expected_found("seconds that increase from row to row", found)
                .help(STATE_THE_RATE),
        ))
    }
}

/// The cells of a row, which may end with a tab.
fn row_cells(line: Word<'_>) -> Vec<Word<'_>> {
    let mut cells = cells(line);
    while cells.last().is_some_and(|cell| cell.bytes.is_empty()) {
        cells.pop();
    }
    cells
}

/// The statements of the header.
struct Header {
    in_degrees: bool,
    /// The number of rows; NaN if the file does not state it.
    rows: f64,
}

/// Reads the header.
fn header(table: &mut Table<'_>) -> Result<Header, Failure> {
    let mut header = Header {
        in_degrees: true,
        rows: f64::NAN,
    };
    for _ in 0..LONGEST_HEADER {
        let line = table.header_line(END_OF_HEADER)?;
        let text = decode_name(line.bytes).to_ascii_lowercase();
        match text.trim().split_once('=') {
            Some((key, value)) if key.trim() == "indegrees" => header.in_degrees = value.trim() != "no",
            Some((key, value)) if key.trim() == "nrows" => header.rows = value.trim().parse().unwrap_or(f64::NAN),
            _ if text.trim() == END_OF_HEADER => return Ok(header),
            _ => {}
        }
    }
    Err(Box::new(limit_exceeded(
        format!("{END_OF_HEADER} within {LONGEST_HEADER} lines"),
        "a longer header".to_owned(),
    )))
}
