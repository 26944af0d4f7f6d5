//! Lines of standard input, of bounded length.

use std::io::{self, BufRead};

use super::protocol::Fault;

/// The longest message in bytes. A job with a map of every bone has some thousands.
pub(super) const LONGEST: usize = 1 << 20;

/// What comes next.
pub(super) enum Line {
    Text(Vec<u8>),
    /// More bytes than are taken; they were read and left out.
    TooLong,
    End,
}

/// The next line, without its end.
pub(super) fn read(input: &mut impl BufRead) -> io::Result<Line> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_is_too_long_is_left_out_and_the_next_is_read() {
        let mut bytes = vec![b'a'; 10 * LONGEST];
        bytes.extend_from_slice(b"\nb\n\nc");
        let mut input = io::BufReader::with_capacity(7, &bytes[9 * LONGEST - 1..]);
        assert!(matches!(read(&mut input), Ok(Line::TooLong)));
        for expected in ["b", "", "c"] {
            assert!(matches!(read(&mut input), Ok(Line::Text(line)) if line == expected.as_bytes()));
        }
        assert!(matches!(read(&mut input), Ok(Line::End)));
        let mut input = io::BufReader::new(&bytes[9 * LONGEST..]);
        assert!(matches!(read(&mut input), Ok(Line::Text(line)) if line.len() == LONGEST));
    }
}
