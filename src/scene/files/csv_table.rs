//! Text tables by RFC 4180. Some of them are tables of points, which are motions, so an output must not replace them.

use std::borrow::Cow;
use std::collections::HashMap;

/// The two possible starts of a table of arrays from this program. The second is quoted as one cell, for a spreadsheet.
const OWN_HEADS: [&str; 2] = ["# {\"frame_rate\":", "\"# {\"\"frame_rate\"\":"];

/// The column names must end within this number of bytes.
pub(crate) const CSV_HEAD: usize = 64 << 10;

/// Whether the text begins with the header of this program's arrays.
#[doc(hidden)]
pub fn is_own_csv(head: &[u8]) -> bool {
    OWN_HEADS.iter().any(|own| head.starts_with(own.as_bytes()))
}

/// A name as a field of RFC 4180. A name with a comma, a quote or a line end is quoted, and its quotes are doubled.
///
/// Spreadsheets evaluate a field that begins with `=`, `+`, `-`, `@`, a tab or a line end, quoted or not. With
/// `for_spreadsheet`, such a name gets the prefix `'`, by which a spreadsheet recognises text. Numbers need no prefix.
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

/// Whether the text begins like a table of Motive.
#[doc(hidden)]
pub fn is_motive_csv(head: &[u8]) -> bool {
    head.strip_prefix(b"\xEF\xBB\xBF")
        .unwrap_or(head)
        .starts_with(b"Format Version,")
}

/// Whether the text begins with the columns of Live Link Face.
#[doc(hidden)]
pub fn is_face_csv(head: &[u8]) -> bool {
    let head = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    let names = b"timecode,blendshapecount,";
    head.get(..names.len())
        .is_some_and(|start| start.eq_ignore_ascii_case(names))
}

/// Whether the text begins with the column names of a table of points, or like a table of Motive or Live Link Face.
#[doc(hidden)]
pub fn is_csv_of_points(head: &[u8]) -> bool {
    if is_motive_csv(head) || is_face_csv(head) {
        return true;
    }
    let head = &head[..head.len().min(CSV_HEAD)];
    // The bytes are the beginning of a file, so they may end within a character.
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => std::str::from_utf8(&head[..error.valid_up_to()]).unwrap_or(""),
        Err(_) => return false,
    };
    let mut names = Vec::new();
    Records::new(text).names(&mut names) && PointColumns::of(&names).is_some()
}

/// Reads the records of a table.
#[derive(Clone)]
#[doc(hidden)]
pub struct Records<'a> {
    rest: &'a str,
    separator: u8,
    /// The line of the last record, from 1.
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

    /// The next line, unparsed.
    #[doc(hidden)]
    pub fn whole_line(&mut self) -> &'a str {
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.line = self.next_line;
        self.next_line += 1;
        line.trim_end_matches('\r')
    }

    /// Reads the column names from the first line that is not empty and not a comment. The most frequent of comma,
    /// semicolon and tab in that line becomes the separator.
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

    /// Reads the cells of the next record. `false` at the end.
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

    /// The next cell, and its end.
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

/// The columns of a table that hold positions.
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
    /// A row for each frame, with three columns for each point.
    Wide {
        time: Option<usize>,
        points: Vec<[usize; 3]>,
    },
}

impl PointColumns {
    /// The columns with these names; `None` if the table has no points.
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
        // There may be as many columns as bytes, so avoid a quadratic search.
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
        // Tables of rotations and of robot joints may have such columns, but most of their columns are different.
        let is_of_points = points.len() >= LEAST_POINTS && 2 * 3 * points.len() >= names.len();
        is_of_points.then_some(Self::Wide { time, points })
    }
}

/// The smallest number of points at which three columns per point are not a coincidence.
const LEAST_POINTS: usize = 3;

/// The point whose column has this axis: `hip` for `hip_x`, `hip.x`, `hip:x`, `hip x` and `x_hip`.
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
