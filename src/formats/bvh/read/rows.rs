//! Reads the rows of the MOTION section as blocks of columns.
//!
//! In nearly every file a row is a line. [`Block::read_plain_row`] reads such rows fast. [`segments`] reads many of
//! them with several threads, or without holding the text in memory. At the first line that is not a plain row,
//! [`layout`] scans the rest of the text once to find the layout of the rows. Afterwards the careful path reads the
//! lines that the fast path cannot.

#[doc(hidden)]
pub(crate) mod block;
pub(crate) mod layout;
#[doc(hidden)]
pub(crate) mod pieces;
mod segments;
#[cfg(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128")))]
pub(crate) mod short;

use std::ops::Range;

use mocap_scene::error::{Code, Diagnostic};

pub(super) use self::block::Block;
use self::layout::Layout;
use self::pieces::Pieces;
use super::Failure;
use super::channel::ChannelKind;
use super::decimals::accept_comma;
use super::hierarchy::{Hierarchy, Joint};
use super::motion::Header;
use crate::text::{Cursor, Word, is_line_end, is_space, number, quote};
use crate::warnings::{Warnings, missing_frames};
use crate::{Blocks, ReadOptions};

/// Receives the rows of a file, block by block.
pub(super) trait Sink {
    /// A writable range of frames.
    type Frames<'a>: Frames
    where
        Self: 'a;

    /// Reserves memory for further frames. The frames may never be added.
    fn reserve(&mut self, frames: usize);

    /// Appends frames.
    fn append(&mut self, block: &Block);

    /// Allocates the following frames with several threads. The caller fills them in any order. Called after the first
    /// frame.
    fn extend(&mut self, frames: usize, threads: usize) -> Self::Frames<'_>;

    /// Keeps only the first `frames` frames.
    fn truncate(&mut self, frames: usize);

    /// The number of frames, including allocated ones.
    fn frames(&self) -> usize;
}

/// A writable range of frames, which can be split among threads.
pub(super) trait Frames: Sized + Send {
    /// Splits off the first `frames` frames, or all if there are fewer.
    fn split_off(&mut self, frames: usize) -> Self;

    /// Fills the first frames of the range, and removes them from the range.
    fn fill(&mut self, block: &Block);
}

/// The rest of a large file, which is not in memory.
#[derive(Clone, Copy)]
pub(super) struct Rest<'a> {
    pub(super) blocks: &'a dyn Blocks,
    /// The number of bytes in the file before the text.
    pub(super) before: usize,
}

/// Reads the declared rows and passes them to `sink` block by block. If there is a `rest`, the text of the cursor is
/// only the beginning of the file.
#[allow(clippy::too_many_arguments, reason = "called once")]
pub(super) fn read<'a>(
    cursor: &mut Cursor<'a>,
    rest: Option<Rest<'a>>,
    hierarchy: &Hierarchy,
    header: &Header,
    options: &ReadOptions,
    warnings: &mut Warnings,
    release: &Release<'_>,
    sink: &mut impl Sink,
) -> Result<(), Failure> {
    if hierarchy.channel_count == 0 {
        warnings.push(Code::NoMotion, || {
            Diagnostic::new(Code::NoMotion, "no joint has CHANNELS, so nothing is animated")
        });
        return Ok(());
    }
    let mut rows = Rows {
        text: cursor.text(),
        cursor,
        hierarchy,
        header,
        all_rows: options.all_rows,
        warnings,
        sink,
        block: Block::new(hierarchy.channel_count),
        last_row: hierarchy.joints.iter().flat_map(rest_values).collect(),
        rows: 0,
        layout: None,
        release,
        released: 0,
        threads: segments::thread_count(options.threads),
    };
    if let Some(rest) = rest {
        rows.read_rest(rest)?;
    }
    rows.read_all()?;
    rows.flush();
    rows.report_the_rest();
    Ok(())
}

/// The values of a joint's channels in the rest pose.
fn rest_values(joint: &Joint) -> impl Iterator<Item = f64> {
    joint.channels.iter().map(|&kind| match kind {
        ChannelKind::Position(axis) => f64::from(joint.offset[axis as usize]),
        ChannelKind::Rotation(_) => 0.0,
        ChannelKind::Scale(_) => 1.0,
    })
}

/// Called with a range of bytes that were read.
pub(super) type Release<'a> = dyn Fn(Range<usize>) + Sync + 'a;

/// The number of read bytes that are passed to [`Release`] together.
const RELEASED: usize = 1 << 20;

struct Rows<'a, 'c, S> {
    text: &'a [u8],
    cursor: &'c mut Cursor<'a>,
    hierarchy: &'c Hierarchy,
    header: &'c Header,
    all_rows: bool,
    warnings: &'c mut Warnings,
    sink: &'c mut S,
    block: Block,
    /// The row before the block. Its values replace values of the block that are not finite.
    last_row: Vec<f64>,
    /// Rows read so far, including dropped ones.
    rows: u64,
    /// The layout of the rows. `None` as long as every row was a plain line.
    layout: Option<Layout>,
    release: &'c Release<'c>,
    /// The start of the text that was not released yet.
    released: usize,
    /// The number of threads for segments.
    threads: usize,
}

impl<'a, S: Sink> Rows<'a, '_, S> {
    fn read_all(&mut self) -> Result<(), Failure> {
        while self.all_rows || self.rows < self.header.frames {
            self.cursor.skip_spaces();
            if self.cursor.peek().is_none() {
                break;
            }
            if self.layout != Some(Layout::Stream) && self.read_plain_row() {
                if self.rows == 1 {
                    self.read_segments();
                }
                continue;
            }
            // A second take begins before all declared rows, or text follows the last row.
            if self.is_take_ahead() || self.rows >= self.header.frames && !self.is_number_ahead() {
                break;
            }
            let layout = match self.layout {
                Some(layout) => layout,
                None => self.find_layout()?,
            };
            self.layout = Some(layout);
            self.read_careful_row(layout)?;
        }
        Ok(())
    }

    fn find_layout(&mut self) -> Result<Layout, Failure> {
        let most = if self.all_rows { u64::MAX } else { self.header.frames };
        let found = layout::find(
            self.cursor,
            self.hierarchy.channel_count,
            self.header.frames,
            self.rows,
            most,
        );
        let no_rule = match found {
            Ok(layout) => return Ok(layout),
            Err(no_rule) => no_rule,
        };
        // The error for a word that is not a number says more than the error for a wrong count of values.
        self.read_values(Layout::Lines)?;
        Err(no_rule)
    }

    /// Reads a plain row. The cursor does not move for any other row.
    fn read_plain_row(&mut self) -> bool {
        let start = self.cursor.offset();
        let length = self.block.read_plain_row(&self.text[start..]);
        if let Some(length) = length {
            self.cursor.set_offset(start + length);
            self.finish_row();
        }
        length.is_some()
    }

    /// Reads the rows after the first with several threads, up to the first row that is not plain.
    fn read_segments(&mut self) {
        let start = self.cursor.offset();
        if self.is_for_several_threads() && self.text.len() - start >= segments::WORTHWHILE {
            let pieces = Pieces::new(self.text, start, None);
            let read = self.read_pieces(pieces, start, self.text.len());
            let read = read.expect("memory can always be read");
            self.cursor.set_offset(read.end);
            self.released = read.end;
        }
    }

    /// Reads rows of a file that is not in memory, up to the first row that is not plain. To read that row, the whole
    /// text must be in memory.
    fn read_rest(&mut self, rest: Rest<'a>) -> Result<(), Failure> {
        self.cursor.skip_spaces();
        let start = self.cursor.offset();
        let is_whole_line = self.text[start..].iter().any(|&byte| is_line_end(byte));
        let is_wanted = self.all_rows || self.header.frames > 0;
        let mut end = start;
        if is_whole_line && is_wanted && self.read_plain_row() {
            let start = self.cursor.offset();
            let pieces = Pieces::new(self.text, start, Some(rest.blocks));
            let read = self.read_pieces(pieces, start, rest.blocks.size())?;
            if read.is_all {
                self.cursor.set_offset(self.text.len());
                return Ok(());
            }
            end = read.end;
        }
        self.text = &rest.blocks.whole()?[rest.before..];
        *self.cursor = Cursor::new(self.text);
        self.cursor.set_offset(end);
        Ok(())
    }

    fn is_for_several_threads(&self) -> bool {
        self.threads >= 2 && self.has_text_for_joints()
    }

    /// Whether a row has at least as many numbers as there are joints. A joint without channels needs memory although
    /// it has no text.
    fn has_text_for_joints(&self) -> bool {
        self.hierarchy.joints.len() <= self.hierarchy.channel_count
    }

    /// Reads plain rows after the first row, whose text ends at `start`. `size` is the length of the whole text.
    fn read_pieces(&mut self, pieces: Pieces<'_>, start: usize, size: usize) -> Result<segments::Read, Failure> {
        self.flush();
        let most = if self.all_rows { u64::MAX } else { self.header.frames };
        // Every value takes at least a digit and a space.
        let possible = size.saturating_sub(start) / (2 * self.hierarchy.channel_count) + 1;
        let most = usize::try_from(most - self.rows).unwrap_or(usize::MAX).min(possible);
        let read = if self.is_for_several_threads() {
            let before = self.sink.frames();
            let frames = self.sink.extend(most, self.threads);
            let read = segments::read(pieces, start, self.threads, most, &self.last_row, frames)?;
            self.sink.truncate(before + read.rows);
            read
        } else {
            if self.has_text_for_joints() {
                self.sink.reserve(most);
            }
            let read = segments::read_alone(pieces, start, most, &self.last_row, |block| self.sink.append(block))?;
            self.sink.truncate(self.sink.frames());
            read
        };
        self.rows += read.rows as u64;
        self.last_row.clone_from(&read.last_row);
        Ok(read)
    }

    /// Reads a row in any spelling with only one meaning. Drops a line with a wrong number of values.
    fn read_careful_row(&mut self, layout: Layout) -> Result<(), Failure> {
        let start = self.cursor.offset();
        let channel_count = self.hierarchy.channel_count;
        let found = self.read_values(layout)?;
        if found == channel_count {
            self.block.frames += 1;
            self.finish_row();
        } else {
            self.rows += 1;
            self.warnings.tally(Code::RowLength, || {
                let line = self.text[start..]
                    .split(|&byte| is_line_end(byte))
                    .next()
                    .unwrap_or_default();
                Diagnostic::new(
                    Code::RowLength,
                    "the row has the wrong number of values and was dropped",
                )
                .at(self.cursor.locate(Word {
                    bytes: line.trim_ascii_end(),
                    offset: start,
                }))
                .expected_found(format!("{channel_count} values"), format!("{found}"))
                .help("each dropped row makes the motion one frame shorter; correct the row or export the file again")
            });
        }
        Ok(())
    }

    /// Reads the values of one row, and returns their number.
    fn read_values(&mut self, layout: Layout) -> Result<usize, Failure> {
        let channel_count = self.hierarchy.channel_count;
        let mut found = 0;
        let mut rest: Option<Word<'a>> = None;
        while let Some(word) = rest.take().or_else(|| self.next_word(layout)) {
            rest = match self.read_value(word, found) {
                // The file ends inside a number.
                Err(_) if self.is_cut_off(word) && found < channel_count => break,
                read => read?,
            };
            found += 1;
            if layout == Layout::Stream && found == channel_count {
                if let Some(rest) = rest {
                    // The rest of a run of numbers begins the next row.
                    self.cursor.set_offset(rest.offset);
                }
                break;
            }
        }
        Ok(found)
    }

    /// Whether the file has whole rows and ends with this word, without a line end.
    fn is_cut_off(&self, word: Word<'_>) -> bool {
        self.rows > 0 && word.offset + word.bytes.len() == self.text.len()
    }

    /// The next word of the row; `None` at its end.
    fn next_word(&mut self, layout: Layout) -> Option<Word<'a>> {
        match layout {
            Layout::Lines => self.cursor.skip_blanks(),
            Layout::Stream => self.cursor.skip_spaces(),
        }
        let word = self.cursor.take_while(|byte| !is_space(byte));
        (!word.bytes.is_empty()).then_some(word)
    }

    fn is_take_ahead(&self) -> bool {
        let next = self.cursor.peek_word();
        next.is_some_and(|word| word.is("HIERARCHY") || word.is("MOTION"))
    }

    fn is_number_ahead(&self) -> bool {
        self.cursor
            .peek_word()
            .is_some_and(|word| number::parse(word.bytes).is_some())
    }

    /// Reads one value into its column. Returns the rest of the word if it holds another number.
    fn read_value(&mut self, word: Word<'a>, column: usize) -> Result<Option<Word<'a>>, Failure> {
        let number = number::parse(word.bytes).filter(|number| {
            let after = word.bytes.get(number.length);
            number.length > 0 && after.is_none_or(|byte| matches!(byte, b'-' | b'+'))
        });
        let Some(number) = number else {
            return Err(self.invalid_number(word, column));
        };
        let taken = Word {
            bytes: &word.bytes[..number.length],
            ..word
        };
        if number.comma {
            accept_comma(
                self.cursor,
                &self.hierarchy.decimals,
                self.header.start,
                taken,
                self.warnings,
            )?;
        }
        if column < self.hierarchy.channel_count {
            let frame = self.block.frames;
            let index = column * self.block.stride;
            self.block.values[index + frame] = if number.value.is_finite() {
                number.value
            } else {
                self.warn_of_non_finite(taken, column);
                if frame == 0 {
                    self.last_row[column]
                } else {
                    self.block.values[index + frame - 1]
                }
            };
        }
        if number.length == word.bytes.len() {
            return Ok(None);
        }
        self.warnings.tally(Code::SplitNumber, || {
            Diagnostic::new(
                Code::SplitNumber,
                "two numbers have no space between them, and were split",
            )
            .at(self.cursor.locate(word))
            .expected_found("a space before the sign", quote(word.bytes))
        });
        Ok(Some(Word {
            bytes: &word.bytes[number.length..],
            offset: word.offset + number.length,
        }))
    }

    fn warn_of_non_finite(&mut self, word: Word<'_>, column: usize) {
        self.warnings.tally(Code::NonFiniteValue, || {
            let (joint, kind) = self.hierarchy.column(column);
            Diagnostic::new(
                Code::NonFiniteValue,
                "the value is not finite; the last finite value of the channel was used",
            )
            .at(self.cursor.locate(word))
            .in_joint(&joint.name)
            .expected_found(format!("a number for {}", kind.name()), quote(word.bytes))
        });
    }

    fn invalid_number(&self, word: Word<'_>, column: usize) -> Failure {
        let diagnostic = Diagnostic::new(Code::InvalidNumber, format!("{} is not a number", quote(word.bytes)))
            .at(self.cursor.locate(word));
        let diagnostic = match column < self.hierarchy.channel_count {
            true => {
                let (joint, kind) = self.hierarchy.column(column);
                diagnostic
                    .in_joint(&joint.name)
                    .expected_found(format!("the value of {}", kind.name()), quote(word.bytes))
            }
            false => diagnostic.expected_found("the end of the row", quote(word.bytes)),
        };
        Box::new(
            if word.bytes.iter().any(|byte| matches!(byte, b'[' | b']' | b'(' | b')')) {
                diagnostic.help("the writer printed an array: remove the brackets")
            } else if word.bytes.contains(&b',') {
                diagnostic.help("separate values by spaces")
            } else {
                diagnostic
            },
        )
    }

    fn finish_row(&mut self) {
        self.rows += 1;
        if self.block.is_full() {
            self.flush();
        }
    }

    fn flush(&mut self) {
        if let Some(last_row) = self.block.last_row() {
            self.last_row = last_row;
            self.sink.append(&self.block);
            self.block.frames = 0;
        }
        let offset = self.cursor.offset();
        if offset - self.released >= RELEASED {
            (self.release)(self.released..offset);
            self.released = offset;
        }
    }

    /// Warns if the file has more or fewer rows than it declares.
    fn report_the_rest(&mut self) {
        self.cursor.skip_spaces();
        let after = layout::after_the_rows(self.cursor, self.hierarchy.channel_count, self.layout);
        let (declared, found) = (self.header.frames, self.rows + after.rows);
        if declared > found {
            self.warnings.push(Code::MissingFrames, || {
                missing_frames(declared, found).at(self.cursor.locate(self.header.frames_word(self.text)))
            });
        }
        if declared < found {
            self.warnings.push(Code::FrameCount, || {
                let advice = if !self.all_rows {
                    "the rows beyond that number were ignored; {all-rows} reads them"
                } else {
                    "all rows of the file were read"
                };
                Diagnostic::new(
                    Code::FrameCount,
                    "the motion has more rows than the number after Frames:",
                )
                .at(self.cursor.locate(self.header.frames_word(self.text)))
                .expected_found(format!("{declared} rows"), format!("{found}"))
                .help(advice)
            });
        }
        if let Some((line, numbers)) = after.other_line {
            self.warnings.push(Code::TrailingText, || {
                let message = "a line after the last row has a different number of values, and was ignored";
                let mut warning = Diagnostic::new(Code::TrailingText, message)
                    .at(self.cursor.locate(line))
                    .expected_found(
                        format!("{} values, or the end of the file", self.hierarchy.channel_count),
                        format!("{numbers}"),
                    );
                warning.count = after.other_lines;
                warning
            });
        }
        if let Some(word) = after.text {
            self.warnings.push(Code::TrailingText, || {
                Diagnostic::new(Code::TrailingText, "text follows the last row, and was ignored")
                    .at(self.cursor.locate(word))
                    .expected_found("the end of the file", quote(word.bytes))
            });
        }
        if self.rows == 0 {
            self.warnings.push(Code::NoMotion, || {
                Diagnostic::new(
                    Code::NoMotion,
                    "no frame was read: the scene has a skeleton and no animation",
                )
                .at(self.cursor.locate(self.header.frames_word(self.text)))
            });
        }
    }
}
