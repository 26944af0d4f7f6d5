//! Reads text in columns: a header, and then a row of numbers for each frame.

use mocap_scene::error::{Code, Diagnostic};

use super::{Cursor, Word, is_line_end, is_space, number, quote};
use crate::Failure;
use crate::warnings::{Warnings, missing_frames};

/// Iterates over the lines of a string.
pub(crate) struct Table<'a> {
    pub(crate) cursor: Cursor<'a>,
}

impl<'a> Table<'a> {
    pub(crate) fn new(text: &'a [u8]) -> Self {
        Self {
            cursor: Cursor::new(text),
        }
    }

    /// The next line that is not empty.
    pub(crate) fn next_line(&mut self) -> Option<Word<'a>> {
        loop {
            self.cursor.take_while(is_line_end);
            let line = self.cursor.take_while(|byte| !is_line_end(byte));
            if line.bytes.is_empty() {
                return None;
            }
            if !line.bytes.iter().copied().all(is_space) {
                return Some(line);
            }
        }
    }

    /// Whether a row is cut off: the text ends with this row, without a line end. In addition, the row lacks some
    /// cells, or frames that the header states are missing after the row. The last number of the row may be cut off
    /// too.
    pub(crate) fn is_cut_off(&self, row: Word<'_>, is_short: bool, frame: usize, stated: f64) -> bool {
        let is_last = row.offset + row.bytes.len() == self.cursor.text().len();
        is_last && frame > 0 && (is_short || frame as f64 + 1.0 < stated)
    }

    /// Warns if the number of frames differs from the header.
    pub(crate) fn check_frames(&self, found: usize, stated: f64, warnings: &mut Warnings) {
        if stated > found as f64 {
            warnings.push(Code::MissingFrames, || missing_frames(stated as u64, found as u64));
        } else if stated < found as f64 {
            warnings.push(Code::FrameCount, || {
                Diagnostic::new(Code::FrameCount, "the file has more frames than its header states")
                    .expected_found(format!("{stated} frames"), format!("{found} frames"))
                    .help("all frames were read")
            });
        }
    }

    /// The next line of the header, which must exist.
    pub(crate) fn header_line(&mut self, expected: &str) -> Result<Word<'a>, Failure> {
        self.next_line().ok_or_else(|| {
            Box::new(
                Diagnostic::new(Code::UnexpectedEnd, "the file ends within its header")
                    .at(self.cursor.locate_end())
                    .expected_found(expected, "the end of the file")
                    .help("the file is cut off: export or download it again"),
            )
        })
    }

    /// The error for an unexpected word.
    pub(crate) fn refused(&self, word: Word<'_>, message: &str, expected: &str) -> Failure {
        Box::new(
            Diagnostic::new(Code::MissingKeyword, message)
                .at(self.cursor.locate(word))
                .expected_found(expected, quote(word.bytes))
                .help("check that the file has the format of its name, or export it again"),
        )
    }

    /// The number in a cell; NaN if the cell is empty or states NaN. `what` describes the number.
    pub(crate) fn number(&self, cell: Word<'_>, what: &str) -> Result<f64, Failure> {
        if cell.bytes.is_empty() {
            return Ok(f64::NAN);
        }
        match number::parse(cell.bytes) {
            Some(number) if number.length == cell.bytes.len() => Ok(number.value),
            _ => Err(Box::new(
                Diagnostic::new(Code::InvalidNumber, format!("{what} is not a number"))
                    .at(self.cursor.locate(cell))
                    .expected_found("a number, or an empty cell", quote(cell.bytes))
                    .help("export the file again"),
            )),
        }
    }
}

/// The words of a line. If the line has tabs, names may contain spaces.
pub(crate) fn words(line: Word<'_>) -> Vec<Word<'_>> {
    let mut found = cells(line);
    found.retain(|cell| !cell.bytes.is_empty());
    found
}

/// The cells of a line: between tabs, or if the line has no tabs, between spaces.
pub(crate) fn cells(line: Word<'_>) -> Vec<Word<'_>> {
    let has_tabs = line.bytes.contains(&b'\t');
    let is_end = |byte: &u8| if has_tabs { *byte == b'\t' } else { is_space(*byte) };
    let mut offset = line.offset;
    let mut found = Vec::new();
    for cell in line.bytes.split(is_end) {
        let blanks = cell.iter().take_while(|byte| is_space(**byte)).count();
        let word = Word {
            bytes: cell.trim_ascii(),
            offset: offset + blanks,
        };
        if has_tabs || !word.bytes.is_empty() {
            found.push(word);
        }
        offset += cell.len() + 1;
    }
    found
}
