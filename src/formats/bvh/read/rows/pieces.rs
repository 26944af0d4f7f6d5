//! The text of the rows in pieces of whole lines: cut from memory, or read from a file block by block.

use crate::{Blocks, Failure};

/// The smallest piece of memory in bytes. Such a piece is large enough to make the overhead small. It is small enough
/// to stay in the second-level cache while its lines are counted and its numbers are read.
pub const LENGTH: usize = 1 << 18;

/// A piece of the text that consists of whole lines.
#[derive(Debug, PartialEq)]
pub struct Piece<'a> {
    pub text: &'a [u8],
    /// The offset of the first byte of the piece.
    pub offset: usize,
    pub lines: usize,
}

/// The remaining pieces.
pub struct Pieces<'a> {
    /// The rest of the text. If there are blocks, the text before the blocks.
    text: &'a [u8],
    /// The offset of the next piece.
    offset: usize,
    blocks: Option<&'a dyn Blocks>,
    /// The beginning of a line that ends in the next block.
    begun: Vec<u8>,
    /// The byte that ends a line.
    line_end: u8,
}

impl<'a> Pieces<'a> {
    /// The lines after the line that contains `start`. `blocks` follow the text.
    pub fn new(text: &'a [u8], start: usize, blocks: Option<&'a dyn Blocks>) -> Self {
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

    /// The next piece, stored in `buffer` if it comes from blocks; `None` after the last piece.
    pub fn next<'b>(&mut self, buffer: &'b mut Vec<u8>) -> Result<Option<Piece<'b>>, Failure>
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
            // The earlier bytes have no line end, except for the text before the first block.
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

/// The number of lines, without empty lines at the end.
pub fn count_lines(text: &[u8], line_end: u8) -> usize {
    let text = text.trim_ascii_end();
    memchr::memchr_iter(line_end, text).count() + usize::from(!text.is_empty())
}
