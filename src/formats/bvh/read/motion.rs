//! Reads the header of the MOTION section: the number of frames and the frame time.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{self, limit_exceeded};

use super::Failure;
use super::decimals::accept_comma;
use super::hierarchy::Hierarchy;
use crate::text::{Cursor, Word, number, quote};
use crate::warnings::Warnings;
use crate::{ReadOptions, STATE_THE_RATE};

/// The lines between MOTION and the first row.
#[derive(Debug)]
pub(super) struct Header {
    /// The number after `Frames:`.
    pub(super) frames: u64,
    /// The location of the number after `Frames:`.
    pub(super) frames_word: (usize, usize),
    /// Frames per second: 1 / frame time, or the caller's frame rate.
    pub(super) frame_rate: f64,
    /// The byte offset of MOTION.
    pub(super) start: usize,
}

impl Header {
    /// The number after `Frames:`, for a diagnostic.
    pub(super) fn frames_word<'a>(&self, text: &'a [u8]) -> Word<'a> {
        let (offset, end) = self.frames_word;
        Word {
            bytes: &text[offset..end],
            offset,
        }
    }
}

/// Reads `"MOTION" "Frames:" n "Frame Time:" seconds`, in any case, with or without spaces around the colons. `None` if
/// the file ends with its hierarchy.
pub(super) fn read_header(
    cursor: &mut Cursor<'_>,
    hierarchy: &Hierarchy,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Option<Header>, Failure> {
    let Some(motion) = cursor.peek_word() else {
        warn_of_no_motion(cursor, warnings);
        return Ok(None);
    };
    if motion.is("MOTION") {
        cursor.next_word();
    } else {
        warnings.push(Code::MissingMotion, || {
            Diagnostic::new(Code::MissingMotion, "there is no MOTION before this line")
                .at(cursor.locate(motion))
                .expected_found("MOTION", quote(motion.bytes))
        });
        if !has_rows(cursor.clone()) {
            cursor.set_offset(cursor.text().len());
            warn_of_no_motion(cursor, warnings);
            return Ok(None);
        }
    }
    let frames_word = read_value(cursor, &["Frames"])
        .ok_or_else(|| missing_line(cursor, "Frames: followed by the number of frames"))?;
    let frames = read_frame_count(cursor, hierarchy, options, frames_word)?;
    let (frame_rate, decimal_comma) = read_frame_rate(cursor, options)?;
    if let Some(word) = decimal_comma {
        accept_comma(cursor, &hierarchy.decimals, motion.offset, word, warnings)?;
    }
    Ok(Some(Header {
        frames,
        frames_word: (frames_word.offset, frames_word.offset + frames_word.bytes.len()),
        frame_rate,
        start: motion.offset,
    }))
}

fn warn_of_no_motion(cursor: &Cursor<'_>, warnings: &mut Warnings) {
    let message = "the file has no MOTION: the scene has a skeleton and no animation";
    warnings.push(Code::NoMotion, || {
        Diagnostic::new(Code::NoMotion, message).at(cursor.locate_end())
    });
}

/// Whether numbers follow the lines `Frames:` and `Frame Time:`.
fn has_rows(mut cursor: Cursor<'_>) -> bool {
    let _ = read_value(&mut cursor, &["Frames"]);
    let _ = read_value(&mut cursor, &["Frame", "Time"]);
    cursor
        .peek_word()
        .is_some_and(|word| number::parse(word.bytes).is_some())
}

fn read_frame_count(
    cursor: &Cursor<'_>,
    hierarchy: &Hierarchy,
    options: &ReadOptions,
    word: Word<'_>,
) -> Result<u64, Failure> {
    let frames = std::str::from_utf8(word.bytes)
        .ok()
        .and_then(|digits| digits.parse::<u64>().ok());
    let Some(frames) = frames else {
        return Err(Box::new(
            Diagnostic::new(
                Code::InvalidNumber,
                format!("{} is not a number of frames", quote(word.bytes)),
            )
            .at(cursor.locate(word))
            .expected_found("a whole number, 0 or more", quote(word.bytes)),
        ));
    };
    let limit = options.limits.max_values;
    let values = frames.saturating_mul(hierarchy.channel_count.max(1) as u64);
    if values > limit {
        return Err(Box::new(
            limit_exceeded(
                format!("at most {limit} values"),
                format!("{frames} frames of {} channels", hierarchy.channel_count),
            )
            .at(cursor.locate(word)),
        ));
    }
    Ok(frames)
}

/// The frame rate, and the word of the frame time if it has a decimal comma.
fn read_frame_rate<'a>(cursor: &mut Cursor<'a>, options: &ReadOptions) -> Result<(f64, Option<Word<'a>>), Failure> {
    let before = cursor.offset();
    let word = read_value(cursor, &["Frame", "Time"]);
    if word.is_none() {
        cursor.set_offset(before);
    }
    let number = word.and_then(|word| number::parse(word.bytes).filter(|number| number.length == word.bytes.len()));
    let comma = word.filter(|_| number.is_some_and(|number| number.comma));
    if let Some(frame_rate) = options.retime {
        return Ok((frame_rate, comma));
    }
    match number {
        Some(number) if number.value.is_finite() && number.value > 0.0 => {
            match limits::frame_rate(Code::FrameTime, 1.0 / number.value) {
                Ok(frame_rate) => Ok((frame_rate, comma)),
                Err(_) => Err(Box::new(invalid_frame_time(cursor, word, "0.000001 to 10000 seconds"))),
            }
        }
        _ => Err(Box::new(invalid_frame_time(
            cursor,
            word,
            "a finite number of seconds above 0",
        ))),
    }
}

fn invalid_frame_time(cursor: &Cursor<'_>, word: Option<Word<'_>>, expected: &str) -> Diagnostic {
    let diagnostic = match word {
        Some(word) => Diagnostic::new(Code::FrameTime, format!("{} is not a frame time", quote(word.bytes)))
            .at(cursor.locate(word))
            .expected_found(expected, quote(word.bytes)),
        None => missing_line_diagnostic(cursor, Code::FrameTime, &format!("Frame Time: followed by {expected}")),
    };
    diagnostic.help(STATE_THE_RATE)
}

fn missing_line(cursor: &Cursor<'_>, expected: &str) -> Failure {
    Box::new(missing_line_diagnostic(cursor, Code::MissingKeyword, expected))
}

fn missing_line_diagnostic(cursor: &Cursor<'_>, code: Code, expected: &str) -> Diagnostic {
    let (location, found) = match cursor.peek_word() {
        Some(word) => (cursor.locate(word), quote(word.bytes)),
        None => (cursor.locate_end(), "the end of the file".to_owned()),
    };
    let line = expected.split(':').next().unwrap_or(expected);
    Diagnostic::new(code, format!("MOTION has no line \"{line}:\""))
        .at(location)
        .expected_found(expected, found)
}

/// The word after these keywords and a colon, in a line such as `Frame Time: 0.1`, `FRAMES :10` or `FrameTime:0.1`.
///
/// The cursor does not move if the keywords are missing.
fn read_value<'a>(cursor: &mut Cursor<'a>, keywords: &[&str]) -> Option<Word<'a>> {
    let mut ahead = cursor.clone();
    for keyword in keywords {
        ahead.skip_spaces();
        let letters = ahead.take_while(|byte| byte.is_ascii_alphabetic());
        if let Some(glued) = letters.strip_prefix(keyword) {
            ahead.set_offset(glued.offset);
        } else {
            return None;
        }
    }
    ahead.skip_spaces();
    ahead.take_while(|byte| byte == b':');
    let word = ahead.next_word().unwrap_or(Word {
        bytes: b"",
        offset: ahead.offset(),
    });
    *cursor = ahead;
    Some(word)
}
