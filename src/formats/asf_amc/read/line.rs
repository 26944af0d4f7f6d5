//! Lines of words, and the numbers in them.

use glam::DVec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::FARTHEST;

use crate::Failure;
use crate::text::{Cursor, Word, is_line_end, is_space, number, quote};

/// The lines of a file that contain a word, without comments.
pub(super) struct Lines<'a> {
    cursor: Cursor<'a>,
}

impl<'a> Lines<'a> {
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self {
            cursor: Cursor::new(text),
        }
    }

    /// The words of the next line; at least one.
    pub(super) fn next_line(&mut self) -> Option<Vec<Word<'a>>> {
        let mut words = Vec::new();
        self.read_line(&mut words).then_some(words)
    }

    /// Replaces `words` by the words of the next line. `false` at the end of the text.
    pub(super) fn read_line(&mut self, words: &mut Vec<Word<'a>>) -> bool {
        words.clear();
        loop {
            self.cursor.skip_blanks();
            match self.cursor.peek() {
                Some(b'#') => {
                    self.cursor.take_while(|byte| !is_line_end(byte));
                }
                Some(byte) if !is_line_end(byte) => {
                    let word = self.cursor.take_while(|byte| !is_space(byte) && byte != b'#');
                    words.push(word);
                }
                Some(_) if words.is_empty() => self.cursor.skip_spaces(),
                _ => return !words.is_empty(),
            }
        }
    }

    /// The words of the next line, without advancing.
    pub(super) fn peek_line(&self) -> Option<Vec<Word<'a>>> {
        let cursor = self.cursor.clone();
        Self { cursor }.next_line()
    }

    /// The first word of the next line, without advancing.
    pub(super) fn peek_word(&self) -> Option<Word<'a>> {
        Some(self.peek_line()?[0])
    }

    /// Whether the text ends with this word, without a final line end.
    pub(super) fn end_with(&self, word: Word<'_>) -> bool {
        word.offset + word.bytes.len() == self.cursor.text().len()
    }

    /// A diagnostic at `word`.
    pub(super) fn at(&self, word: Word<'_>, code: Code, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(code, message).at(self.cursor.locate(word))
    }

    /// The error for a `word` where `expected` should be.
    pub(super) fn unexpected(&self, word: Word<'_>, expected: impl Into<String>) -> Failure {
        let message = format!("{} is not allowed here", quote(word.bytes));
        Box::new(
            self.at(word, Code::UnexpectedToken, message)
                .expected_found(expected, quote(word.bytes)),
        )
    }

    /// A diagnostic at the end of the text.
    pub(super) fn at_end(&self, code: Code, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(code, message).at(self.cursor.locate_end())
    }

    /// The error for a file that ends where `expected` should be.
    pub(super) fn ended(&self, message: impl Into<String>, expected: impl Into<String>) -> Failure {
        Box::new(
            self.at_end(Code::UnexpectedEnd, message)
                .expected_found(expected, "the end of the file"),
        )
    }

    /// The line of `word`, from 1.
    pub(super) fn line_number(&self, word: Word<'_>) -> usize {
        self.cursor.locate(word).line
    }

    /// The word at `index` of a line, as a number. It must be finite, and small enough for kinematics.
    pub(super) fn number(&self, line: &[Word<'_>], index: usize, what: &str) -> Result<f64, Failure> {
        let Some(&word) = line.get(index) else {
            let last = line[line.len() - 1];
            return Err(Box::new(
                self.at(last, Code::InvalidNumber, "a number is missing after this word")
                    .expected_found(what, "the end of the line"),
            ));
        };
        match number::parse(word.bytes).filter(|number| number.length == word.bytes.len()) {
            Some(number) if number.value.abs() <= FARTHEST => Ok(number.value),
            Some(_) => {
                let message = format!("a number of a bone must be finite and below {FARTHEST:e}");
                let diagnostic = self.at(word, Code::NonFiniteOffset, message);
                Err(Box::new(diagnostic.expected_found(what, quote(word.bytes))))
            }
            None => Err(self.invalid_number(word, what)),
        }
    }

    /// The error for a `word` that is not a number.
    pub(super) fn invalid_number(&self, word: Word<'_>, expected: &str) -> Failure {
        let message = format!("{} is not a number", quote(word.bytes));
        Box::new(
            self.at(word, Code::InvalidNumber, message)
                .expected_found(expected, quote(word.bytes)),
        )
    }

    /// The three numbers after the keyword of a line.
    pub(super) fn vector(&self, line: &[Word<'_>]) -> Result<DVec3, Failure> {
        let keyword = quote(line[0].bytes);
        let component =
            |index: usize, letter: char| self.number(line, index, &format!("the {letter} value of {keyword}"));
        Ok(DVec3::new(component(1, 'X')?, component(2, 'Y')?, component(3, 'Z')?))
    }
}
