//! Shared by all text formats: decoding, and a cursor over words and lines.
//!
//! The cursor holds only a byte offset. Lines and columns are counted only for a diagnostic, so that valid files do not
//! pay for them.

pub(crate) mod number;
pub(crate) mod table;

use std::borrow::Cow;

use mocap_scene::error::{Code, Diagnostic, Location};

use crate::Failure;

/// The bytes of a text file as UTF-8 or as a superset of ASCII, without a byte order mark.
///
/// UTF-16 is recognised by its byte order mark, or by a NUL in every second of the first bytes. Bytes that are not
/// UTF-8 are kept: such bytes matter only in names, which `decode_name` reads as Latin-1.
pub fn decode(bytes: &[u8]) -> Result<Cow<'_, [u8]>, Failure> {
    let text = match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => Cow::Borrowed(rest),
        [0xFF, 0xFE, rest @ ..] => Cow::Owned(decode_utf16(rest, u16::from_le_bytes)),
        [0xFE, 0xFF, rest @ ..] => Cow::Owned(decode_utf16(rest, u16::from_be_bytes)),
        [1..=255, 0, 1..=255, 0, ..] => Cow::Owned(decode_utf16(bytes, u16::from_le_bytes)),
        [0, 1..=255, 0, 1..=255, ..] => Cow::Owned(decode_utf16(bytes, u16::from_be_bytes)),
        _ => Cow::Borrowed(bytes),
    };
    if text.iter().all(u8::is_ascii_whitespace) {
        return Err(Box::new(Diagnostic::new(Code::EmptyFile, "the file is empty")));
    }
    Ok(text)
}

/// Whether the first `PAGE` bytes contain a NUL byte. Such a file is not text.
pub(crate) fn is_binary(text: &[u8]) -> bool {
    /// The number of bytes in which a NUL shows that a file is not text.
    const PAGE: usize = 4096;
    text[..text.len().min(PAGE)].contains(&0)
}

fn decode_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Vec<u8> {
    let (pairs, _) = bytes.as_chunks::<2>();
    char::decode_utf16(pairs.iter().map(|&pair| unit(pair)))
        .map(|char| char.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect::<String>()
        .into_bytes()
}

/// Whether the outermost element of an XML file probably has this name.
pub(crate) fn begins_with_element(bytes: &[u8], name: &str) -> bool {
    let Ok(text) = decode(&bytes[..bytes.len().min(64 << 10)]) else {
        return false;
    };
    let mut rest = text.trim_ascii_start();
    while let Some(start) = ["<?", "<!--", "<!"]
        .into_iter()
        .find(|start| rest.starts_with(start.as_bytes()))
    {
        let end: &[u8] = if start == "<!--" { b"-->" } else { b">" };
        match rest.windows(end.len()).position(|bytes| bytes == end) {
            Some(found) => rest = rest[found + end.len()..].trim_ascii_start(),
            None => return false,
        }
    }
    let after = rest
        .strip_prefix(b"<")
        .and_then(|rest| rest.strip_prefix(name.as_bytes()));
    after.is_some_and(|after| {
        after
            .first()
            .is_none_or(|byte| byte.is_ascii_whitespace() || matches!(byte, b'>' | b'/'))
    })
}

/// A name as text: UTF-8 if valid, otherwise Latin-1, in which every byte is a character.
pub(crate) fn decode_name(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(name) => name.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// Text of the file, quoted for a message and cut to a readable length.
pub(crate) fn quote(bytes: &[u8]) -> String {
    /// The largest number of characters in a quotation, which fit on a terminal line.
    const LONGEST: usize = 40;
    let text = decode_name(bytes);
    if text.chars().count() <= LONGEST {
        format!("\"{}\"", text.escape_debug())
    } else {
        let start: String = text.chars().take(LONGEST).collect();
        format!("\"{}...\"", start.escape_debug())
    }
}

/// A run of bytes and where it starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word<'a> {
    pub bytes: &'a [u8],
    pub offset: usize,
}

impl Word<'_> {
    /// Whether the word is this keyword, in any case.
    pub(crate) fn is(&self, keyword: &str) -> bool {
        self.bytes.eq_ignore_ascii_case(keyword.as_bytes())
    }

    /// The rest of the word after this keyword, in any case.
    pub(crate) fn strip_prefix(&self, keyword: &str) -> Option<Self> {
        let (start, rest) = self.bytes.split_at_checked(keyword.len())?;
        start.eq_ignore_ascii_case(keyword.as_bytes()).then_some(Self {
            bytes: rest,
            offset: self.offset + keyword.len(),
        })
    }
}

/// The white space of C's `isspace`.
pub(crate) fn is_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

/// Whether the byte ends a line.
pub(crate) fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// A position in a string.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    text: &'a [u8],
    offset: usize,
}

impl<'a> Cursor<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Self { text, offset: 0 }
    }

    pub(crate) fn text(&self) -> &'a [u8] {
        self.text
    }

    pub(crate) fn offset(&self) -> usize {
        self.offset
    }

    pub(crate) fn set_offset(&mut self, offset: usize) {
        self.offset = offset;
    }

    pub(crate) fn peek(&self) -> Option<u8> {
        self.text.get(self.offset).copied()
    }

    /// Advances while `condition` holds, and returns the bytes passed.
    pub(crate) fn take_while(&mut self, condition: impl Fn(u8) -> bool) -> Word<'a> {
        let rest = &self.text[self.offset..];
        let length = rest.iter().position(|&byte| !condition(byte)).unwrap_or(rest.len());
        let word = Word {
            bytes: &rest[..length],
            offset: self.offset,
        };
        self.offset += length;
        word
    }

    pub(crate) fn skip_spaces(&mut self) {
        self.take_while(is_space);
    }

    /// Skips spaces and tabs, and stays on the line.
    pub(crate) fn skip_blanks(&mut self) {
        self.take_while(|byte| is_space(byte) && !is_line_end(byte));
    }

    /// The next word. A brace is a separate word.
    pub fn next_word(&mut self) -> Option<Word<'a>> {
        self.skip_spaces();
        let offset = self.offset;
        if let Some(b'{' | b'}') = self.peek() {
            self.offset += 1;
            return Some(Word {
                bytes: &self.text[offset..offset + 1],
                offset,
            });
        }
        let word = self.take_while(|byte| !is_space(byte) && !matches!(byte, b'{' | b'}'));
        (!word.bytes.is_empty()).then_some(word)
    }

    pub(crate) fn peek_word(&self) -> Option<Word<'a>> {
        self.clone().next_word()
    }

    /// The rest of the line up to a brace, without surrounding spaces: a name, which may contain spaces.
    pub fn next_name(&mut self) -> Word<'a> {
        self.skip_blanks();
        let mut word = self.take_while(|byte| !is_line_end(byte) && !matches!(byte, b'{' | b'}'));
        word.bytes = word.bytes.trim_ascii_end();
        word
    }

    /// The line and column of `word`.
    pub fn locate(&self, word: Word<'_>) -> Location {
        let before = &self.text[..word.offset];
        let line_start = before
            .iter()
            .rposition(|&byte| is_line_end(byte))
            .map_or(0, |end| end + 1);
        let ends = before.iter().filter(|&&byte| is_line_end(byte)).count();
        let pairs = before.windows(2).filter(|pair| pair == b"\r\n").count();
        let column = 1 + char_count(&self.text[line_start..word.offset]);
        let (text, text_column) = self.excerpt(line_start, word.offset, column);
        Location {
            line: 1 + ends - pairs,
            column,
            length: char_count(word.bytes).max(1),
            text,
            text_column,
        }
    }

    /// The text around a position, and the column of its first character. A row of motion may be megabytes long, so the
    /// text is cut.
    fn excerpt(&self, line_start: usize, offset: usize, column: usize) -> (String, usize) {
        /// The number of bytes in an excerpt before the error.
        const BYTES_BEFORE: usize = 60;

        /// The number of bytes in an excerpt after the error.
        const BYTES_AFTER: usize = 100;
        let is_continuation = |byte: &u8| byte & 0xC0 == 0x80;
        let near = &self.text[offset.saturating_sub(BYTES_BEFORE).max(line_start)..offset];
        let near = &near[near.iter().take_while(|byte| is_continuation(byte)).count()..];
        let rest = &self.text[offset..];
        let line_end = rest.iter().take(BYTES_AFTER).position(|&byte| is_line_end(byte));
        let mut end = line_end.unwrap_or(rest.len().min(BYTES_AFTER));
        while rest.get(end).is_some_and(is_continuation) {
            end += 1;
        }
        let text = decode_name(&[near, &rest[..end]].concat());
        (text.trim_end().to_owned(), column - char_count(near))
    }

    /// The last line and column of the text.
    pub(crate) fn locate_end(&self) -> Location {
        let end = self.text.trim_ascii_end().len();
        self.locate(Word {
            bytes: b"",
            offset: end,
        })
    }
}

/// The offsets of line starts, for a reader that needs the line numbers of many positions.
pub struct LineIndex {
    starts: Vec<usize>,
}

impl LineIndex {
    /// The lines of `text`. CR, LF and CRLF each end a line.
    pub fn new(text: &[u8]) -> Self {
        let is_last_of_end = |&end: &usize| !(text[end] == b'\r' && text.get(end + 1) == Some(&b'\n'));
        let ends = memchr::memchr2_iter(b'\r', b'\n', text).filter(is_last_of_end);
        Self {
            starts: ends.map(|end| end + 1).collect(),
        }
    }

    /// The line, from 1, of the byte at `offset`.
    pub fn line(&self, offset: usize) -> usize {
        1 + self.starts.partition_point(|&start| start <= offset)
    }
}

/// The number of characters in UTF-8 text, or of bytes in other text.
fn char_count(bytes: &[u8]) -> usize {
    std::str::from_utf8(bytes).map_or(bytes.len(), |text| text.chars().count())
}
