//! The words of a layer: names, numbers, strings and single bytes, separated by spaces and comments.

use mocap_scene::error::{Code, Diagnostic, Location};

use crate::Failure;
use crate::text::{Cursor, Word};

pub(super) struct Tokens<'a> {
    cursor: Cursor<'a>,
}

impl<'a> Tokens<'a> {
    /// The words after the first line.
    pub(super) fn new(text: &'a [u8]) -> Self {
        let mut cursor = Cursor::new(text);
        cursor.take_while(|byte| byte != b'\n' && byte != b'\r');
        Self { cursor }
    }

    /// The next byte on the line.
    pub(super) fn peek_on_line(&mut self) -> Option<u8> {
        self.cursor.skip_blanks();
        self.cursor.peek()
    }

    /// The start of the next word, for [`Self::back_to`].
    pub(super) fn offset(&self) -> usize {
        self.cursor.offset()
    }

    pub(super) fn back_to(&mut self, offset: usize) {
        self.cursor.set_offset(offset);
    }

    /// The next byte that is neither space nor comment.
    pub(super) fn peek(&mut self) -> Option<u8> {
        loop {
            self.cursor.skip_spaces();
            let rest = &self.cursor.text()[self.cursor.offset()..];
            match rest {
                [b'#', ..] | [b'/', b'/', ..] => {
                    self.cursor.take_while(|byte| byte != b'\n' && byte != b'\r');
                }
                [b'/', b'*', ..] => {
                    let end = memchr::memmem::find(&rest[2..], b"*/");
                    self.pass(end.map_or(rest.len(), |end| end + 4));
                }
                _ => return rest.first().copied(),
            }
        }
    }

    pub(super) fn pass(&mut self, bytes: usize) {
        self.cursor.set_offset(self.cursor.offset() + bytes);
    }

    pub(super) fn expect(&mut self, byte: u8) -> Result<(), Failure> {
        if self.peek() != Some(byte) {
            return Err(self.unexpected(&char::from(byte).to_string()));
        }
        self.pass(1);
        Ok(())
    }

    pub(super) fn word(&mut self) -> Result<Word<'a>, Failure> {
        self.peek();
        let word = self.cursor.take_while(is_word);
        match word.bytes {
            b"" => Err(self.unexpected("a word")),
            _ => Ok(word),
        }
    }

    pub(super) fn number(&mut self) -> Result<f64, Failure> {
        self.peek();
        let offset = self.cursor.offset();
        let rest = &self.cursor.text()[offset..];
        match fast_float2::parse_partial::<f64, _>(rest) {
            Ok((number, length)) if length > 0 => {
                self.pass(length);
                Ok(number)
            }
            _ => Err(self.unexpected("a number")),
        }
    }

    /// A string in quotes, single or triple, with escapes.
    pub(super) fn string(&mut self) -> Result<String, Failure> {
        let quote = self.peek().filter(|byte| matches!(byte, b'"' | b'\''));
        let quote = quote.ok_or_else(|| self.unexpected("a string in quotes"))?;
        let rest = &self.cursor.text()[self.cursor.offset()..];
        let long = [quote; 3];
        let mark: &[u8] = if rest.starts_with(&long) { &long } else { &long[..1] };
        let mut bytes = Vec::new();
        let mut at = mark.len();
        loop {
            match rest.get(at) {
                None => {
                    let message = "the file ends within a string";
                    let offset = self.cursor.offset();
                    let start = self.cursor.locate(Word { bytes: mark, offset });
                    return Err(Diagnostic::new(Code::UnexpectedEnd, message).at(start).into());
                }
                Some(_) if rest[at..].starts_with(mark) => break,
                Some(b'\\') => {
                    let (byte, length) = escaped(&rest[at + 1..]);
                    bytes.extend(byte);
                    at += 1 + length;
                }
                Some(byte) => {
                    bytes.push(*byte);
                    at += 1;
                }
            }
        }
        self.pass(at + mark.len());
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    /// The text up to a byte, for a path or a file name.
    pub(super) fn delimited(&mut self, end: u8) -> Result<String, Failure> {
        self.pass(1);
        let word = self.cursor.take_while(|byte| byte != end && byte != b'\n');
        match self.cursor.peek() {
            Some(found) if found == end => {
                self.pass(1);
                Ok(text_of(word))
            }
            _ => Err(self.unexpected(&char::from(end).to_string())),
        }
    }

    /// A file name between `@` and `@`, or between `@@@` and `@@@`. A name between `@@@` may contain an `@`.
    pub(super) fn asset(&mut self) -> Result<String, Failure> {
        let rest = &self.cursor.text()[self.cursor.offset()..];
        let Some(name) = rest.strip_prefix(b"@@@") else {
            return self.delimited(b'@');
        };
        // A backslash makes `@@@` part of the name.
        let is_mark = |at: &usize| *at == 0 || name[at - 1] != b'\\';
        let Some(mut end) = memchr::memmem::find_iter(name, b"@@@").find(is_mark) else {
            return Err(self.unexpected("@@@"));
        };
        // An `@` directly before the mark belongs to the name.
        while name.get(end + 3) == Some(&b'@') {
            end += 1;
        }
        self.pass(end + 6);
        Ok(String::from_utf8_lossy(&name[..end]).replace("\\@@@", "@@@"))
    }

    /// The location of the word at an offset of the layer.
    pub(super) fn locate(text: &[u8], offset: usize) -> Location {
        let mut cursor = Cursor::new(text);
        cursor.set_offset(offset);
        let word = cursor.take_while(|byte| is_word(byte) || matches!(byte, b'+' | b'-'));
        // The colon after a time does not belong to the number.
        let bytes = word.bytes.strip_suffix(b":").unwrap_or(word.bytes);
        cursor.locate(Word { bytes, ..word })
    }

    /// The end of the text.
    pub(super) fn end(&self) -> Location {
        self.cursor.locate_end()
    }

    pub(super) fn unexpected(&mut self, expected: &str) -> Failure {
        match self.peek() {
            None => Diagnostic::new(Code::UnexpectedEnd, "the file is cut off")
                .at(self.cursor.locate_end())
                .expected_found(expected, "the end of the file")
                .into(),
            Some(_) => {
                let offset = self.cursor.offset();
                let rest = &self.cursor.text()[offset..];
                let length = rest
                    .iter()
                    .take_while(|byte| is_word(**byte))
                    .count()
                    .clamp(1, rest.len().max(1));
                let bytes = &rest[..length];
                self.unexpected_word(Word { bytes, offset }, expected)
            }
        }
    }

    pub(super) fn unexpected_word(&self, word: Word<'_>, expected: &str) -> Failure {
        let found: String = text_of(word).chars().take(40).collect();
        let message = format!("{found:?} cannot stand here");
        Diagnostic::new(Code::UnexpectedToken, message)
            .at(self.cursor.locate(word))
            .expected_found(expected, format!("{found:?}"))
            .into()
    }
}

pub(super) fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b':' | b'.' | b'|') || byte >= 0x80
}

pub(super) fn text_of(word: Word<'_>) -> String {
    String::from_utf8_lossy(word.bytes).into_owned()
}

/// The byte for an escape sequence, as in C, and the length of the sequence.
fn escaped(rest: &[u8]) -> (Option<u8>, usize) {
    let digits = |radix: u32, from: usize, most: usize| {
        let digits = rest.iter().skip(from).take(most);
        let digits = digits.map_while(|digit| char::from(*digit).to_digit(radix));
        digits.fold((0_u32, from), |(value, length), digit| {
            (value * radix + digit, length + 1)
        })
    };
    let byte = match rest.first() {
        Some(b'a') => 7,
        Some(b'b') => 8,
        Some(b't') => b'\t',
        Some(b'n') => b'\n',
        Some(b'v') => 11,
        Some(b'f') => 12,
        Some(b'r') => b'\r',
        Some(b'x') => {
            let (value, length) = digits(16, 1, 2);
            return (Some(value as u8), length);
        }
        Some(b'0'..=b'7') => {
            let (value, length) = digits(8, 0, 3);
            return (Some(value as u8), length);
        }
        other => return (other.copied(), 1),
    };
    (Some(byte), 1)
}
