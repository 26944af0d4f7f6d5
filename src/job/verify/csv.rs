//! Reads the `.csv` files of `fk`, without code of the writer. A file has a comment with the header as JSON, the column
//! names, and a row for each frame and joint, as in RFC 4180.

use mocap_scene::error::Result;

use super::arrays::{ArrayFile, Header, invalid};

/// Whether the file begins with a header in a comment. In files for spreadsheets, the comment is one quoted cell.
pub(super) fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"# {") || bytes.starts_with(b"\"# {\"\"")
}

/// The arrays of a file.
///
/// # Errors
/// [`Code::InvalidArrays`](mocap_scene::Code::InvalidArrays).
pub(super) fn read(bytes: &[u8]) -> Result<ArrayFile> {
    let text = std::str::from_utf8(bytes).map_err(|_| invalid("the file is not text"))?;
    let mut records = Records { rest: text, line: 0 };
    let comment = match text.starts_with('#') {
        true => records.comment()?,
        false => records.next()?.unwrap_or_default().concat(),
    };
    let header = Header::from_json(comment.strip_prefix("# ").unwrap_or_default())?;
    let rotation = header.rotation.columns();
    let columns = records.next()?.unwrap_or_default();
    let expected: Vec<&str> = ["frame", "time", "joint", "x", "y", "z"]
        .into_iter()
        .chain(rotation.iter().copied())
        .collect();
    let further: Vec<&str> = columns.iter().skip(expected.len()).map(String::as_str).collect();
    let (has_velocities, has_contacts) = match further[..] {
        [] => (false, false),
        ["contact"] => (false, true),
        ["vx", "vy", "vz"] => (true, false),
        ["vx", "vy", "vz", "contact"] => (true, true),
        _ => return Err(invalid(format!("the columns end with {}", further.join(",")))),
    };
    if !columns
        .iter()
        .map(String::as_str)
        .take(expected.len())
        .eq(expected.iter().copied())
    {
        return Err(invalid(format!("the columns do not begin with {}", expected.join(","))));
    }
    let (mut positions, mut rotations, mut velocities) = (Vec::new(), Vec::new(), Vec::new());
    let of_position = expected.len() - rotation.len();
    let of_velocity = expected.len() + if has_velocities { 3 } else { 0 };
    let count = header.joints.len();
    let mut row = 0;
    while let Some(record) = records.next()? {
        let (frame, joint) = (row / count.max(1), row % count.max(1));
        let at_line = format!("line {}", records.line);
        if record.len() != columns.len() {
            return Err(invalid(format!(
                "{at_line} has {} cells, not {}",
                record.len(),
                columns.len()
            )));
        }
        // Names that a spreadsheet would read as formulas have a mark before them.
        let name = header.joints.get(joint).map_or("", |joint| &joint.name);
        let is_name = record[2] == name || record[2].strip_prefix('\'') == Some(name);
        let time = record[1].parse::<f64>().unwrap_or(f64::NAN);
        let is_time = (time * header.frame_rate - frame as f64).abs() < 1e-6;
        if record[0] != frame.to_string() || !is_time || !is_name {
            let found = record[..3].join(",");
            return Err(invalid(format!(
                "{at_line} is not frame {frame} of joint {name:?}, but {found:?}"
            )));
        }
        let numbers = |cells: &[String]| {
            let numbers = cells.iter().map(|cell| cell.parse::<f32>());
            let numbers = numbers.collect::<Result<Vec<_>, _>>();
            numbers.map_err(|_| invalid(format!("{at_line} has a cell that is not a number")))
        };
        positions.extend(numbers(&record[3..of_position])?);
        rotations.extend(numbers(&record[of_position..expected.len()])?);
        velocities.extend(numbers(&record[expected.len()..of_velocity])?);
        if has_contacts && !["0", "1"].contains(&record[of_velocity].as_str()) {
            return Err(invalid(format!("{at_line} has a contact that is neither 0 nor 1")));
        }
        row += 1;
    }
    if row % count.max(1) != 0 {
        return Err(invalid("the last frame does not have all joints"));
    }
    Ok(ArrayFile {
        frames: row / count.max(1),
        header,
        positions,
        rotations,
        velocities: has_velocities.then_some(velocities),
    })
}

/// The part of a file that is not yet read, record by record.
struct Records<'a> {
    rest: &'a str,
    /// The line of the last record, from 1.
    line: usize,
}

impl Records<'_> {
    /// The next line, not split into cells.
    fn comment(&mut self) -> Result<String> {
        let (line, rest) = self
            .rest
            .split_once('\n')
            .ok_or_else(|| invalid("the file is cut off"))?;
        self.rest = rest;
        self.line += 1;
        Ok(line.to_owned())
    }

    /// The cells of the next record. Each record must end with a line break.
    fn next(&mut self) -> Result<Option<Vec<String>>> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        self.line += 1;
        let mut cells = vec![String::new()];
        let mut is_quoted = false;
        let mut characters = self.rest.char_indices().peekable();
        while let Some((at, character)) = characters.next() {
            let cell = cells.last_mut().expect("there is always one");
            match character {
                '"' if is_quoted && characters.next_if(|&(_, next)| next == '"').is_some() => cell.push('"'),
                '"' => is_quoted = !is_quoted,
                ',' if !is_quoted => cells.push(String::new()),
                '\n' if !is_quoted => {
                    self.rest = &self.rest[at + 1..];
                    return Ok(Some(cells));
                }
                _ => cell.push(character),
            }
        }
        Err(invalid(format!("line {} is cut off", self.line)))
    }
}
