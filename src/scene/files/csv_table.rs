//! Tables of text, as RFC 4180 states them, and which of them have points: a table of positions is read, and is nothing
//! that an output may replace.

use std::borrow::Cow;
use std::collections::HashMap;

/// What the first line of the arrays of this program begins with; the second is one cell for a spreadsheet.
const OWN_HEADS: [&str; 2] = ["# {\"frame_rate\":", "\"# {\"\"frame_rate\"\":"];

/// Bytes in which the names of the columns end.
pub(crate) const CSV_HEAD: usize = 64 << 10;

/// Whether the text begins with the header of this program's arrays.
#[doc(hidden)]
pub fn is_own_csv(head: &[u8]) -> bool {
    OWN_HEADS.iter().any(|own| head.starts_with(own.as_bytes()))
}

/// A name as a field of RFC 4180: one with a comma, a quote or a line end is quoted, and its quotes doubled.
///
/// Spreadsheets calculate what begins with `=`, `+`, `-`, `@`, a tab or a line end, whether it is quoted or not. With
/// `for_spreadsheet`, such a name gets a `'` before it, which a spreadsheet takes as the mark of a text. Numbers need
/// none.
///
/// ```
/// use mocap::files::csv_field;
///
/// assert_eq!(csv_field("Hips", true), "Hips");
/// assert_eq!(csv_field("=1+1", false), "=1+1");
/// assert_eq!(csv_field("=SUM(A1,A2)", true), "\"'=SUM(A1,A2)\"");
/// ```
pub fn csv_field(text: &str, for_spreadsheet: bool) -> String {
    let is_formula = for_spreadsheet && text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    let mark = if is_formula { "'" } else { "" };
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{mark}{}\"", text.replace('"', "\"\""))
    } else {
        format!("{mark}{text}")
    }
}

/// Whether the text begins as the tables of Motive do.
#[doc(hidden)]
pub fn is_motive_csv(head: &[u8]) -> bool {
    head.strip_prefix(b"\xEF\xBB\xBF")
        .unwrap_or(head)
        .starts_with(b"Format Version,")
}

/// Whether the text begins with the names of the columns of a table of points, or as the tables of Motive do.
#[doc(hidden)]
pub fn is_csv_of_points(head: &[u8]) -> bool {
    if is_motive_csv(head) {
        return true;
    }
    let head = &head[..head.len().min(CSV_HEAD)];
    // A character may be cut in two at the end.
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => std::str::from_utf8(&head[..error.valid_up_to()]).unwrap_or(""),
        Err(_) => return false,
    };
    let mut names = Vec::new();
    Records::new(text).names(&mut names) && PointColumns::of(&names).is_some()
}

/// The records of a table, one after the other.
#[derive(Clone)]
#[doc(hidden)]
pub struct Records<'a> {
    rest: &'a str,
    separator: u8,
    /// Of the record that was read last, from 1.
    #[doc(hidden)]
    pub line: usize,
    next_line: usize,
}

impl<'a> Records<'a> {
    #[doc(hidden)]
    pub fn new(text: &'a str) -> Self {
        Self {
            rest: text.trim_start_matches('\u{feff}'),
            separator: b',',
            line: 0,
            next_line: 1,
        }
    }

    /// The next line, whatever is in it.
    #[doc(hidden)]
    pub fn whole_line(&mut self) -> &'a str {
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.line = self.next_line;
        self.next_line += 1;
        line.trim_end_matches('\r')
    }

    /// The names of the columns, in the first line that is not empty and no comment. Cells end where most of the
    /// separators of that line are: commas, semicolons or tabs.
    #[doc(hidden)]
    pub fn names(&mut self, names: &mut Vec<Cow<'a, str>>) -> bool {
        while self.rest.starts_with(['#', '\n', '\r']) {
            self.whole_line();
        }
        let line = self.rest.split('\n').next().unwrap_or("");
        let count = |separator: &u8| line.bytes().filter(|byte| byte == separator).count();
        self.separator = [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',');
        self.next(names)
    }

    /// The cells of the next record; `false` at the end.
    #[doc(hidden)]
    pub fn next(&mut self, cells: &mut Vec<Cow<'a, str>>) -> bool {
        cells.clear();
        if self.rest.is_empty() {
            return false;
        }
        self.line = self.next_line;
        loop {
            let (cell, end) = self.cell();
            let ends = end.is_none_or(|end| self.rest.as_bytes()[end] == b'\n');
            self.rest = end.map_or("", |end| &self.rest[end + 1..]);
            if !ends {
                cells.push(cell);
                continue;
            }
            cells.push(match cell {
                Cow::Borrowed(cell) => Cow::Borrowed(cell.trim_end_matches('\r')),
                made => made,
            });
            self.next_line += 1;
            return true;
        }
    }

    /// The next cell, and where it ends.
    fn cell(&mut self) -> (Cow<'a, str>, Option<usize>) {
        let bytes = self.rest.as_bytes();
        let end_after = |at: usize| memchr::memchr2(self.separator, b'\n', &bytes[at..]).map(|end| at + end);
        if !self.rest.starts_with('"') {
            let end = end_after(0);
            return (Cow::Borrowed(&self.rest[..end.unwrap_or(bytes.len())]), end);
        }
        let (mut at, mut text) = (1, String::new());
        loop {
            let Some(quote) = memchr::memchr(b'"', &bytes[at..]).map(|quote| at + quote) else {
                text.push_str(&self.rest[at..]);
                return (Cow::Owned(text), None);
            };
            text.push_str(&self.rest[at..quote]);
            at = quote + 1;
            if bytes.get(at) != Some(&b'"') {
                break;
            }
            text.push('"');
            at += 1;
        }
        self.next_line += text.bytes().filter(|byte| *byte == b'\n').count();
        (Cow::Owned(text), end_after(at))
    }
}

/// Which columns of a table have positions.
#[derive(Debug, PartialEq)]
#[doc(hidden)]
pub enum PointColumns {
    /// A row for each frame and point.
    Long {
        frame: Option<usize>,
        time: Option<usize>,
        name: usize,
        xyz: [usize; 3],
    },
    /// A row for each frame, and three columns for each point.
    Wide {
        time: Option<usize>,
        points: Vec<[usize; 3]>,
    },
}

impl PointColumns {
    /// The columns with these names; `None` where they are no points.
    #[doc(hidden)]
    pub fn of(names: &[impl AsRef<str>]) -> Option<Self> {
        let names: Vec<String> = names.iter().map(|name| name.as_ref().trim().to_lowercase()).collect();
        let find = |known: &[&str]| names.iter().position(|name| known.contains(&name.as_str()));
        let time = find(&["time", "seconds", "timestamp", "t"]);
        if let (Some(name), Some(x), Some(y), Some(z)) = (
            find(&["joint", "point", "marker", "landmark", "keypoint", "name", "label"]),
            find(&["x"]),
            find(&["y"]),
            find(&["z"]),
        ) {
            let frame = find(&["frame", "frame_index", "frame_id"]);
            let xyz = [x, y, z];
            return Some(Self::Long { frame, time, name, xyz });
        }
        // There may be as many columns as bytes.
        let of_axis = |axis: char| {
            let columns = names.iter().enumerate().rev();
            let columns = columns.filter_map(|(index, name)| Some((point_of(name, axis)?, index)));
            columns.collect::<HashMap<&str, usize>>()
        };
        let (of_y, of_z) = (of_axis('y'), of_axis('z'));
        let of_x = names
            .iter()
            .enumerate()
            .filter_map(|(x, name)| Some((point_of(name, 'x')?, x)));
        let points: Vec<[usize; 3]> = of_x
            .filter_map(|(point, x)| Some([x, *of_y.get(point)?, *of_z.get(point)?]))
            .collect();
        // Rotations and joints of robots have such columns too, among many others.
        let is_of_points = points.len() >= LEAST_POINTS && 2 * 3 * points.len() >= names.len();
        is_of_points.then_some(Self::Wide { time, points })
    }
}

/// Points from which on three columns each are no chance.
const LEAST_POINTS: usize = 3;

/// The point of which a column has this axis: `hip` of `hip_x`, `hip.x`, `hip:x`, `hip x` and `x_hip`.
#[doc(hidden)]
pub fn point_of(column: &str, axis: char) -> Option<&str> {
    let separators = ['_', '.', ':', ' ', '-', '/'];
    let axes = [axis, axis.to_ascii_uppercase()];
    let before = column
        .strip_suffix(axes)
        .and_then(|point| point.strip_suffix(separators));
    let after = || {
        column
            .strip_prefix(axes)
            .and_then(|point| point.strip_prefix(separators))
    };
    before.or_else(after).filter(|point| !point.is_empty())
}
