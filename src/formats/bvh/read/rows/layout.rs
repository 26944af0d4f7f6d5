//! Finds the layout of a file's rows.

use mocap_scene::error::{Code, Diagnostic};

use super::super::Failure;
use crate::text::{Cursor, Word, is_line_end, is_space, number};

/// Where a row of the file ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// A row is a line. Lines with another number of values are rare, and broken.
    Lines,
    /// Line ends have no meaning: rows are wrapped, or a line holds several rows.
    Stream,
}

/// Finds the layout of the text from the current position. Each of the `rows_before` lines before this position was a
/// whole row.
///
/// If each line is a row, the text after the next `most` rows does not matter, because it will not be read.
pub fn find(
    cursor: &Cursor<'_>,
    channel_count: usize,
    declared: u64,
    rows_before: u64,
    most: u64,
) -> Result<Layout, Failure> {
    let lines = || {
        Lines { cursor: cursor.clone() }
            .take_while(Line::is_numeric)
            .map(|line| line.numbers)
    };
    let count = |most: usize| {
        let whole = lines().take(most).filter(|&numbers| numbers == channel_count).count();
        let broken = lines().take(most).filter(|&numbers| numbers != channel_count).count();
        (rows_before + whole as u64, broken as u64)
    };
    let are_lines = |(whole, broken): (u64, u64)| whole > 0 && (broken <= 1 || broken * 10 <= whole);
    if are_lines(count(usize::MAX)) {
        return Ok(Layout::Lines);
    }
    let values: u64 = rows_before * channel_count as u64 + lines().map(|numbers| numbers as u64).sum::<u64>();
    if values == declared * channel_count as u64 || rows_end_at_line_ends(lines(), channel_count) {
        return Ok(Layout::Stream);
    }
    let most = usize::try_from(most.saturating_sub(rows_before)).unwrap_or(usize::MAX);
    let (whole, broken) = count(most);
    if are_lines((whole, broken)) {
        return Ok(Layout::Lines);
    }
    Err(Box::new(no_rule(
        cursor,
        channel_count,
        whole,
        broken,
        lines().take(most),
    )))
}

/// Whether wrapped or joined rows fit the lines: every row ends at a line end, except a last row that is cut off.
fn rows_end_at_line_ends(lines: impl Iterator<Item = usize>, channel_count: usize) -> bool {
    let mut rows = 0;
    let mut pending = 0;
    for numbers in lines {
        pending += numbers;
        if pending % channel_count == 0 {
            rows += pending / channel_count;
            pending = 0;
        } else if pending > channel_count {
            return false;
        }
    }
    rows > 0
}

fn no_rule(
    cursor: &Cursor<'_>,
    channel_count: usize,
    whole: u64,
    broken: u64,
    lines: impl Iterator<Item = usize> + Clone,
) -> Diagnostic {
    let wrong = lines.filter(|&numbers| numbers != channel_count);
    let (least, most) = (wrong.clone().min().unwrap_or(0), wrong.max().unwrap_or(0));
    let found = match least == most {
        true => format!("{most} values"),
        false => format!("{least} to {most} values"),
    };
    let message = match whole {
        0 => "no row has as many values as the hierarchy has channels".to_owned(),
        _ => format!("{broken} of {} rows have the wrong number of values", whole + broken),
    };
    let first = Lines { cursor: cursor.clone() }.find(|line| line.numbers != channel_count);
    let diagnostic = Diagnostic::new(Code::RowLength, message)
        .expected_found(
            format!("{channel_count} values in each row, one for each channel"),
            found,
        )
        .help("the motion belongs to another hierarchy, or its writer has a bug: export the file again");
    match first {
        Some(line) => diagnostic.at(cursor.locate(line.word)),
        None => diagnostic,
    }
}

/// The text after the rows that were read.
#[derive(Debug, Default)]
pub(super) struct TrailingText<'a> {
    /// The number of further rows.
    pub(super) rows: u64,
    /// The first line of numbers that is not a row, and its count of numbers.
    pub(super) other_line: Option<(Word<'a>, usize)>,
    /// The number of lines with numbers that are not rows.
    pub(super) other_lines: u64,
    /// The first line that does not begin with a number.
    pub(super) text: Option<Word<'a>>,
}

/// Examines the text after the rows that were read. Without a layout, every row was a line.
pub(super) fn after_the_rows<'a>(
    cursor: &Cursor<'a>,
    channel_count: usize,
    layout: Option<Layout>,
) -> TrailingText<'a> {
    let mut after = TrailingText::default();
    let mut values = 0;
    for line in (Lines { cursor: cursor.clone() }) {
        if !line.is_numeric() {
            after.text = Some(line.word);
            break;
        }
        if layout == Some(Layout::Stream) {
            values += line.numbers as u64;
        } else if line.numbers == channel_count {
            after.rows += 1;
        } else {
            after.other_line.get_or_insert((line.word, line.numbers));
            after.other_lines += 1;
        }
    }
    after.rows += values / channel_count as u64;
    after
}

/// A line that is not blank.
struct Line<'a> {
    word: Word<'a>,
    numbers: usize,
}

impl Line<'_> {
    /// Whether the line begins like a row.
    fn is_numeric(&self) -> bool {
        let word = self.word.bytes.split(|&byte| is_space(byte)).next().unwrap_or_default();
        number::parse(word).is_some()
    }
}

/// The lines that start at the cursor, without blank lines.
#[derive(Clone)]
struct Lines<'a> {
    cursor: Cursor<'a>,
}

impl<'a> Iterator for Lines<'a> {
    type Item = Line<'a>;

    fn next(&mut self) -> Option<Line<'a>> {
        self.cursor.skip_spaces();
        let word = self.cursor.take_while(|byte| !is_line_end(byte));
        (!word.bytes.is_empty()).then(|| Line {
            word,
            numbers: count_numbers(word.bytes),
        })
    }
}

/// The count of numbers in a line. A sign after a digit or a point begins another number.
pub fn count_numbers(line: &[u8]) -> usize {
    let mut before = b' ';
    let mut count = 0;
    for &byte in line {
        let begins_word = is_space(before) && !is_space(byte);
        let splits = matches!(byte, b'-' | b'+') && (before.is_ascii_digit() || before == b'.');
        count += usize::from(begins_word || splits);
        before = byte;
    }
    count
}
