//! Motion files of OpenSim, `.mot` and `.sto`: a column of numbers for each angle.
//!
//! | lines | hold |
//! |---|---|
//! | first | the name of the motion |
//! | others up to `endheader` | `nRows=`, `nColumns=`, `inDegrees=yes` or `no`, and words of the writer |
//! | the next one | the names of the columns, of which the first is `time`, in seconds |
//! | others | a frame: a number for each column, separated by tabs or blanks |
//!
//! The format is described by OpenSim, *Motion (.mot) Files* and *Storage (.sto) Files*.

use crate::error::{Code, Diagnostic};
use crate::format::Failure;
use crate::format::text::table::{Table, cells, words};
use crate::format::text::{Word, decode, decode_name, is_binary};
use crate::limits::{Limits, limit_exceeded};

/// The last line of every header.
const END_OF_HEADER: &str = "endheader";

/// Lines of a header, at most: files of OpenSim have ten, and some repeat the settings of the tool that wrote them.
const LONGEST_HEADER: usize = 1000;

pub(super) fn sniff(bytes: &[u8]) -> bool {
    const NEAR: usize = 4096;
    let start = &bytes[..bytes.len().min(NEAR)];
    start
        .split(|byte| *byte == b'\n')
        .any(|line| line.trim_ascii().eq_ignore_ascii_case(END_OF_HEADER.as_bytes()))
}

/// The columns of a file.
pub(super) struct Columns {
    pub(super) names: Vec<String>,
    /// In seconds.
    pub(super) times: Vec<f64>,
    /// Of each column that has a name, frame by frame.
    pub(super) values: Vec<Vec<f64>>,
    /// Whether angles are in degrees; otherwise they are in radians.
    pub(super) in_degrees: bool,
}

impl Columns {
    /// # Errors
    /// Where a line is not that of such a file, or the file has more than the limits allow.
    pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Self, Failure> {
        let text = decode(bytes)?;
        if is_binary(&text) {
            return Err(Box::new(Diagnostic::new(Code::BinaryFile, "the file is not text")));
        }
        let mut table = Table::new(&text);
        let in_degrees = header(&mut table)?;
        let line = table.header_line("the names of the columns")?;
        let mut names = words(line).into_iter();
        if names.next().is_none_or(|word| !word.is("time")) {
            return Err(table.refused(
                line,
                "the line of the names of columns is missing",
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
        while let Some(line) = table.next_line() {
            columns.row(&table, line, limits)?;
        }
        Ok(columns)
    }

    fn row(&mut self, table: &Table<'_>, line: Word<'_>, limits: &Limits) -> Result<(), Failure> {
        let mut cells = cells(line);
        // A tab may end a line.
        while cells.last().is_some_and(|cell| cell.bytes.is_empty()) {
            cells.pop();
        }
        let (expected, frame) = (self.names.len() + 1, self.times.len());
        if cells.len() != expected {
            return Err(Box::new(
                Diagnostic::new(
                    Code::RowLength,
                    format!("frame {frame} has another number of values than there are columns"),
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
        for (values, cell) in self.values.iter_mut().zip(&cells[1..]) {
            values.push(table.number(*cell, "a value")?);
        }
        Ok(())
    }

    /// The values of the column of this name.
    pub(super) fn column(&self, name: &str) -> Option<&[f64]> {
        let index = self.names.iter().position(|own| own.eq_ignore_ascii_case(name))?;
        Some(&self.values[index])
    }

    /// Frames per second by the first time and the last; NaN where they tell none.
    pub(super) fn rate(&self) -> f64 {
        match self.times.as_slice() {
            [first, .., last] if last > first => (self.times.len() as f64 - 1.0) / (last - first),
            _ => f64::NAN,
        }
    }
}

/// Passes the header, and says whether angles are in degrees.
fn header(table: &mut Table<'_>) -> Result<bool, Failure> {
    let mut in_degrees = true;
    for _ in 0..LONGEST_HEADER {
        let line = table.header_line(END_OF_HEADER)?;
        let text = decode_name(line.bytes).to_ascii_lowercase();
        match text.trim().split_once('=') {
            Some((key, value)) if key.trim() == "indegrees" => in_degrees = value.trim() != "no",
            _ if text.trim() == END_OF_HEADER => return Ok(in_degrees),
            _ => {}
        }
    }
    Err(Box::new(limit_exceeded(
        format!("{END_OF_HEADER} within {LONGEST_HEADER} lines"),
        "a longer header".to_owned(),
    )))
}
