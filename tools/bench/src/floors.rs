//! Measures the least work of any reader and any writer.

use std::fs;
use std::io;
use std::path::Path;

/// Reads every byte once.
pub(crate) fn count_lines(text: &[u8]) -> usize {
    memchr::memchr_iter(b'\n', text).count()
}

/// Parses every number of a string as a correctly rounded `f64`. Only their sum is kept.
pub(crate) fn tokenise(text: &[u8]) -> f64 {
    let mut rest = text;
    let mut sum = 0.0;
    loop {
        while let [b' ' | b'\t' | b'\r' | b'\n', after @ ..] = rest {
            rest = after;
        }
        let Ok((value, length)) = fast_float2::parse_partial::<f64, _>(rest) else {
            return sum;
        };
        sum += value;
        rest = &rest[length..];
    }
}

/// The part of a BVH file with the numbers of the motion.
pub(crate) fn rows(text: &[u8]) -> &[u8] {
    let start = memchr::memmem::find(text, b"Frame Time:").map_or(0, |start| start + 11);
    let line_end = memchr::memchr(b'\n', &text[start..]).map_or(text.len(), |end| start + end);
    &text[line_end..]
}

/// Puts bytes into a new file.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    fs::write(path, bytes)
}
