//! Reads plain rows with several threads.
//!
//! The text is cut at line ends into segments whose bounds depend only on the text. The number of lines before a
//! segment gives the index of its first frame, so each thread writes its keys directly to their final place. Everything
//! after the first line that is not a plain row is discarded and read again by the careful path, so the result does not
//! depend on the number of threads.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex};
use std::thread;

use super::{Block, Frames, Release};
use crate::format::text::is_space;

/// Bytes of a segment: enough to make its overhead small, and few enough that it is still in the second-level cache
/// when its numbers are read after its lines were counted.
const LENGTH: usize = 1 << 18;

/// Segments whose text is released together, because every release interrupts the other processors.
const RELEASED: usize = 16;

/// The least bytes for which a second thread saves time.
pub(super) const WORTHWHILE: usize = 2 << 20;

/// The result of all segments.
pub(super) struct Read {
    pub(super) rows: usize,
    /// The offset behind the last row that was read.
    pub(super) end: usize,
    pub(super) last_row: Vec<f64>,
}

/// The rows of one segment.
struct Segment {
    index: usize,
    rows: usize,
    last_row: Option<Vec<f64>>,
    /// Behind its last plain row.
    end: usize,
    /// Whether every line is a plain row, and its keys are written.
    is_whole: bool,
}

/// The frames that no segment has taken yet, and the segment that takes the next ones.
struct Turn<F> {
    index: usize,
    frames: F,
    left: usize,
}

/// The number of threads asked for, or else of cores.
pub(super) fn thread_count(asked: Option<NonZeroUsize>) -> usize {
    asked
        .or_else(|| thread::available_parallelism().ok())
        .map_or(1, NonZeroUsize::get)
}

/// Reads plain rows from `start` on into `frames`, which holds `most` frames.
///
/// `last_row` is the row before.
pub(super) fn read<F: Frames>(
    text: &[u8],
    start: usize,
    threads: usize,
    most: usize,
    last_row: &[f64],
    release: &Release<'_>,
    frames: F,
) -> Read {
    let line_end = line_end(&text[start..]);
    // Behind the row before.
    let first_line = memchr::memchr(line_end, &text[start..]).map_or(text.len(), |end| start + end + 1);
    let next = AtomicUsize::new(0);
    let stop = AtomicUsize::new(usize::MAX);
    let turn = Mutex::new(Turn {
        index: 0,
        frames,
        left: most,
    });
    let (is_next, segments) = (Condvar::new(), Mutex::new(Vec::new()));
    let work = || {
        let mut block = Block::new(last_row.len());
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(range) = range(text, first_line, index, line_end) else {
                break;
            };
            let lines = count_lines(&text[range.clone()], line_end);
            let mut turn = is_next
                .wait_while(turn.lock().expect(NO_PANIC), |turn| turn.index < index)
                .expect(NO_PANIC);
            let (is_wanted, rows) = (turn.left > 0, lines.min(turn.left));
            let frames = turn.frames.split_off(rows);
            turn.left -= rows;
            turn.index += 1;
            drop(turn);
            is_next.notify_all();
            // The segments after one that is not whole are discarded.
            if !is_wanted || stop.load(Ordering::Relaxed) < index {
                break;
            }
            let segment = read_segment(text, range, index, rows, &mut block, frames);
            if (index + 1).is_multiple_of(RELEASED) {
                // Only segments further back: other threads may still be reading the last ones.
                let offset = |segments: usize| first_line + (index + 1).saturating_sub(segments) * LENGTH;
                release(offset(2 * RELEASED)..offset(RELEASED));
            }
            if !segment.is_whole {
                stop.fetch_min(index, Ordering::Relaxed);
            }
            segments.lock().expect(NO_PANIC).push(segment);
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    put_together(segments.into_inner().expect(NO_PANIC), start, last_row)
}

/// The locks are poisoned only if a thread panics, which would be a defect of this module.
const NO_PANIC: &str = "nothing panics while it holds this lock";

/// The result of the segments up to and including the first that is not whole.
fn put_together(mut segments: Vec<Segment>, start: usize, last_row: &[f64]) -> Read {
    let mut read = Read {
        rows: 0,
        end: start,
        last_row: last_row.to_vec(),
    };
    segments.sort_unstable_by_key(|segment| segment.index);
    for (index, segment) in segments.into_iter().enumerate() {
        if segment.index != index {
            break;
        }
        read.rows += segment.rows;
        read.end = segment.end;
        if let Some(last_row) = segment.last_row {
            read.last_row = last_row;
        }
        if !segment.is_whole {
            break;
        }
    }
    read
}

/// The byte that ends a line: the last byte of the first line end.
fn line_end(text: &[u8]) -> u8 {
    match memchr::memchr2(b'\n', b'\r', text).map(|end| &text[end..]) {
        Some([b'\r', after @ ..]) if after.first() != Some(&b'\n') => b'\r',
        _ => b'\n',
    }
}

/// The number of lines; a last line without an end counts.
fn count_lines(text: &[u8], line_end: u8) -> usize {
    let unfinished = text.last().is_some_and(|&last| last != line_end);
    memchr::memchr_iter(line_end, text).count() + usize::from(unfinished)
}

/// The range of a segment; `None` after the last.
fn range(text: &[u8], start: usize, index: usize, line_end: u8) -> Option<Range<usize>> {
    // The first line that begins at `offset` or later.
    let line_start = |offset: usize| match text.get(offset.saturating_sub(1)..) {
        Some(rest) => offset - 1 + memchr::memchr(line_end, rest).map_or(rest.len(), |end| end + 1),
        None => text.len(),
    };
    let from = start + index * LENGTH;
    (from < text.len()).then(|| {
        let first = if index == 0 { start } else { line_start(from) };
        first..line_start(from + LENGTH)
    })
}

/// Reads `rows` plain rows at most.
fn read_segment(
    text: &[u8],
    range: Range<usize>,
    index: usize,
    rows: usize,
    block: &mut Block,
    mut frames: impl Frames,
) -> Segment {
    let mut segment = Segment {
        index,
        rows: 0,
        last_row: None,
        end: range.start,
        is_whole: false,
    };
    block.frames = 0;
    loop {
        let rest = &text[segment.end..range.end];
        let spaces = rest.iter().take_while(|byte| is_space(**byte)).count();
        let length = match segment.rows < rows {
            true => block.read_plain_row(&rest[spaces..]),
            false => None,
        };
        if let Some(length) = length {
            segment.end += spaces + length;
            segment.rows += 1;
        }
        if block.is_full() || length.is_none() {
            segment.last_row = block.last_row().or(segment.last_row);
            frames.fill(block);
            block.frames = 0;
        }
        if length.is_none() {
            segment.is_whole = segment.rows == rows && spaces == rest.len();
            return segment;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_cover_the_text_and_begin_lines() {
        for line_end in ["\n", "\r", "\r\n"] {
            let line = format!("{}{line_end}", "1 ".repeat(300));
            let text = line.repeat(3 * LENGTH / line.len() + 7).into_bytes();
            let end = line_end.bytes().last().unwrap();
            assert_eq!(super::line_end(&text), end);
            let ranges: Vec<_> = (0..).map_while(|index| range(&text, 5, index, end)).collect();
            assert_eq!(ranges.len(), 4);
            let lines = ranges.iter().map(|range| count_lines(&text[range.clone()], end));
            assert_eq!(lines.sum::<usize>(), text.len() / line.len());
            assert_eq!((ranges[0].start, ranges[3].end), (5, text.len()));
            for pair in ranges.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
                assert_eq!(text[pair[0].end - 1], end);
            }
        }
    }

    #[test]
    fn a_line_longer_than_a_segment_is_in_one() {
        let text = [&vec![b'1'; 5 * LENGTH / 2][..], b"\n2\n"].concat();
        let ranges: Vec<_> = (0..).map_while(|index| range(&text, 0, index, b'\n')).collect();
        let line = 5 * LENGTH / 2 + 1;
        assert_eq!(ranges, [0..line, line..line, line..line + 2]);
    }
}
