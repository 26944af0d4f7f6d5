//! Tests how the server of `mocap mcp` reads lines of standard input.

use std::io;

use mocap_cli::internals::line::{LONGEST, Line, read};

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
