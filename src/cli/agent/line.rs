//! Lines of standard input, of bounded length.

use std::io::{self, BufRead};

use super::protocol::Fault;

/// The longest message in bytes. A job with a map of every bone has a few thousand.
pub const LONGEST: usize = 1 << 20;

/// A line that was read from standard input.
pub enum Line {
    Text(Vec<u8>),
    /// A line with too many bytes, which were read and dropped.
    TooLong,
    End,
}

/// The next line, without its end.
pub fn read(input: &mut impl BufRead) -> io::Result<Line> {
    let (mut line, mut is_too_long, mut is_begun) = (Vec::new(), false, false);
    loop {
        let bytes = match input.fill_buf() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            bytes => bytes?,
        };
        let end = bytes.iter().position(|byte| *byte == b'\n');
        let part = &bytes[..end.unwrap_or(bytes.len())];
        is_too_long |= line.len() + part.len() > LONGEST;
        if !is_too_long {
            line.extend_from_slice(part);
        }
        let is_end = bytes.is_empty();
        is_begun |= !is_end;
        let read = part.len() + usize::from(end.is_some());
        input.consume(read);
        if end.is_some() || is_end {
            return Ok(match (is_begun, is_too_long) {
                (false, _) => Line::End,
                (true, true) => Line::TooLong,
                (true, false) => Line::Text(line),
            });
        }
    }
}

pub(super) fn too_long() -> Fault {
    Fault::invalid_request(format!("a message has at most {LONGEST} bytes; this line has more"))
}
