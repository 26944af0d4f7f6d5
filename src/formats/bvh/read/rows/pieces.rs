//! The text of the rows in pieces of whole lines: cut from memory, or read from a file block by block.

use crate::{Blocks, Failure};

/// Bytes of a piece of memory, at least: enough to make its overhead small, and few enough that it is still in the
/// second-level cache when its numbers are read after its lines were counted.
const LENGTH: usize = 1 << 18;

/// Some whole lines.
#[derive(Debug, PartialEq)]
pub(super) struct Piece<'a> {
    pub(super) text: &'a [u8],
    /// Where it begins.
    pub(super) offset: usize,
    pub(super) lines: usize,
}

/// The pieces that were not taken yet.
pub(super) struct Pieces<'a> {
    /// The rest of the text, or, where there are blocks, what was read before them.
    text: &'a [u8],
    /// Where the next piece begins.
    offset: usize,
    blocks: Option<&'a dyn Blocks>,
    /// The beginning of a line that ends in the next block.
    begun: Vec<u8>,
    /// The byte that ends a line.
    line_end: u8,
}

impl<'a> Pieces<'a> {
    /// The lines after the one in which `start` is. `blocks` follow the text.
    pub(super) fn new(text: &'a [u8], start: usize, blocks: Option<&'a dyn Blocks>) -> Self {
        let line_end = line_end(&text[start..]);
        let offset = memchr::memchr(line_end, &text[start..]).map_or(text.len(), |end| start + end + 1);
        Self {
            text: &text[offset..],
            offset,
            blocks,
            begun: Vec::new(),
            line_end,
        }
    }

    /// The next piece, which is in `buffer` if it comes from blocks; `None` after the last.
    pub(super) fn next<'b>(&mut self, buffer: &'b mut Vec<u8>) -> Result<Option<Piece<'b>>, Failure>
    where
        'a: 'b,
    {
        let text = match self.blocks {
            None => self.take_lines(),
            Some(blocks) => self.read_lines(blocks, buffer)?,
        };
        let offset = self.offset;
        self.offset += text.len();
        Ok((!text.is_empty()).then(|| Piece {
            text,
            offset,
            lines: count_lines(text, self.line_end),
        }))
    }

    fn take_lines(&mut self) -> &'a [u8] {
        let last = (LENGTH - 1).min(self.text.len());
        let length = memchr::memchr(self.line_end, &self.text[last..]).map_or(self.text.len(), |end| last + end + 1);
        let (piece, rest) = self.text.split_at(length);
        self.text = rest;
        piece
    }

    fn read_lines<'b>(&mut self, blocks: &dyn Blocks, buffer: &'b mut Vec<u8>) -> Result<&'b [u8], Failure> {
        buffer.clear();
        buffer.extend_from_slice(std::mem::take(&mut self.text));
        buffer.append(&mut self.begun);
        loop {
            let before = buffer.len();
            let is_end = blocks.read(buffer)? == 0;
            // What was there before has no line end, except what was read before the first block.
            if let Some(end) = memchr::memrchr(self.line_end, &buffer[before..]) {
                self.begun.extend_from_slice(&buffer[before + end + 1..]);
                buffer.truncate(before + end + 1);
                return Ok(buffer);
            }
            if is_end {
                return Ok(buffer);
            }
        }
    }
}

/// The byte that ends a line: the last byte of the first line end.
fn line_end(text: &[u8]) -> u8 {
    match memchr::memchr2(b'\n', b'\r', text).map(|end| &text[end..]) {
        Some([b'\r', after @ ..]) if after.first() != Some(&b'\n') => b'\r',
        _ => b'\n',
    }
}

/// The number of lines without the empty ones at the end.
fn count_lines(text: &[u8], line_end: u8) -> usize {
    let text = text.trim_ascii_end();
    memchr::memchr_iter(line_end, text).count() + usize::from(!text.is_empty())
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    /// Bytes in blocks of a few.
    struct FewBytes<'a>(Mutex<&'a [u8]>, usize);

    impl Blocks for FewBytes<'_> {
        fn read(&self, block: &mut Vec<u8>) -> Result<usize, Failure> {
            let mut rest = self.0.lock().unwrap();
            let (next, after) = rest.split_at(self.1.min(rest.len()));
            block.extend_from_slice(next);
            *rest = after;
            Ok(next.len())
        }

        fn whole(&self) -> Result<&[u8], Failure> {
            unreachable!("pieces do not need it")
        }

        fn size(&self) -> usize {
            0
        }
    }

    fn lengths(mut pieces: Pieces<'_>) -> Vec<(usize, usize, usize)> {
        let mut buffer = Vec::new();
        let mut found = Vec::new();
        while let Some(piece) = pieces.next(&mut buffer).unwrap() {
            found.push((piece.offset, piece.text.len(), piece.lines));
        }
        found
    }

    #[test]
    fn pieces_cover_the_text_and_end_with_lines() {
        for line_end in ["\n", "\r", "\r\n"] {
            let line = format!("{}{line_end}", "1 ".repeat(300));
            let text = line.repeat(3 * LENGTH / line.len() + 7).into_bytes();
            let expected = text.len() / line.len() - 1;
            let memory = lengths(Pieces::new(&text, 5, None));
            assert_eq!(memory.len(), 4, "{line_end:?}");
            let (beginning, rest) = text.split_at(1000);
            let few = FewBytes(Mutex::new(rest), 3001);
            let blocks = lengths(Pieces::new(beginning, 5, Some(&few)));
            for pieces in [memory, blocks] {
                let mut end = line.len();
                for (offset, length, _) in &pieces {
                    assert_eq!((*offset, length % line.len()), (end, 0), "{line_end:?}");
                    end += length;
                }
                assert_eq!(end, text.len());
                assert_eq!(pieces.iter().map(|(_, _, lines)| lines).sum::<usize>(), expected);
            }
        }
    }

    #[test]
    fn a_line_longer_than_a_piece_is_in_one() {
        let text = [b"0\n", &vec![b'1'; 5 * LENGTH / 2][..], b"\n2"].concat();
        let line = 5 * LENGTH / 2 + 1;
        assert_eq!(lengths(Pieces::new(&text, 0, None)), [(2, line, 1), (2 + line, 1, 1)]);
        let few = FewBytes(Mutex::new(&text[3..]), 1000);
        let blocks = lengths(Pieces::new(&text[..3], 0, Some(&few)));
        assert_eq!(blocks, [(2, line, 1), (2 + line, 1, 1)]);
    }

    #[test]
    fn nothing_follows_a_line_without_an_end() {
        assert_eq!(lengths(Pieces::new(b"1 2", 1, None)), []);
        let few = FewBytes(Mutex::new(b""), 10);
        assert_eq!(lengths(Pieces::new(b"1 2\n3", 0, Some(&few))), [(4, 1, 1)]);
    }

    #[test]
    fn empty_lines_at_the_end_are_not_counted() {
        let line_counts = [&b"1\n2\n"[..], b"1\n\n2", b"1\n\n \n", b"\n\n", b""].map(|text| count_lines(text, b'\n'));
        assert_eq!(line_counts, [2, 3, 1, 0, 0]);
    }
}
