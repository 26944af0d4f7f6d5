//! Plain rows by several threads.
//!
//! The text is cut at line ends into segments whose places depend on the text alone. Each is read by the same code as
//! rows one after the other, into a [`Sink`] of its own, and the sinks are put together in order: the result is that of
//! one thread. What follows the first row that is not plain is thrown away and left to the careful path.

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;

use super::{Block, Release, Sink};
use crate::format::text::is_space;

/// Bytes of a segment: enough to make the start of one cheap, few enough that those under way take little memory.
pub(super) const LENGTH: usize = 1 << 20;

/// What was read together.
pub(super) struct Read {
    pub(super) rows: u64,
    /// Where the text goes on.
    pub(super) end: usize,
    pub(super) last_row: Vec<f64>,
}

/// The rows of one segment.
struct Segment<S> {
    part: S,
    rows: u64,
    last_row: Option<Vec<f64>>,
    /// Behind its last plain row.
    end: usize,
    /// Whether every row is plain.
    is_whole: bool,
}

/// The threads asked for, else one a core.
pub(super) fn thread_count(asked: Option<NonZeroUsize>) -> usize {
    asked
        .or_else(|| thread::available_parallelism().ok())
        .map_or(1, NonZeroUsize::get)
}

/// Reads plain rows from `start` on into `sink`, segment by segment, as long as they are not more than `most`.
///
/// `last_row` is the row before.
pub(super) fn read<S: Sink + Send + Sync>(
    text: &[u8],
    start: usize,
    threads: usize,
    most: u64,
    last_row: &[f64],
    release: &Release<'_>,
    sink: &mut S,
) -> Read {
    let mut read = Read {
        rows: 0,
        end: start,
        last_row: last_row.to_vec(),
    };
    let empty = sink.part();
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    // Bounded, so that segments which are read do not pile up before those that are put together.
    let (sender, receiver) = mpsc::sync_channel(threads);
    let work = |sender: SyncSender<(usize, Segment<S>)>| {
        let mut block = Block::new(last_row.len());
        while !stopped.load(Ordering::Relaxed) {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(range) = range(text, start, index) else { break };
            let segment = read_segment(text, range.clone(), &mut block, empty.part());
            release(range);
            if sender.send((index, segment)).is_err() {
                break;
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads {
            let sender = sender.clone();
            scope.spawn(|| work(sender));
        }
        drop(sender);
        let mut early = BTreeMap::new();
        for index in 0.. {
            let segment = next_in_order(&receiver, &mut early, index);
            let Some(segment) = segment.filter(|segment| segment.rows <= most - read.rows) else {
                break;
            };
            sink.extend(segment.part);
            read.rows += segment.rows;
            read.end = segment.end;
            if let Some(last_row) = segment.last_row {
                read.last_row = last_row;
            }
            if !segment.is_whole {
                break;
            }
        }
        stopped.store(true, Ordering::Relaxed);
        // Whoever waits to send a segment that is no longer wanted goes on, and ends.
        drop(receiver);
    });
    read
}

/// The segment at `index`, when it is there. Those that come before their turn wait in `early`.
fn next_in_order<S>(receiver: &Receiver<(usize, S)>, early: &mut BTreeMap<usize, S>, index: usize) -> Option<S> {
    while !early.contains_key(&index) {
        let (other, segment) = receiver.recv().ok()?;
        early.insert(other, segment);
    }
    early.remove(&index)
}

/// Where a segment begins and ends; nothing behind the last.
fn range(text: &[u8], start: usize, index: usize) -> Option<Range<usize>> {
    // The first line that begins at `offset` or later.
    let line_start = |offset: usize| match text.get(offset.saturating_sub(1)..) {
        Some(rest) => offset - 1 + memchr::memchr2(b'\n', b'\r', rest).map_or(rest.len(), |end| end + 1),
        None => text.len(),
    };
    let from = start + index * LENGTH;
    (from < text.len()).then(|| {
        let first = if index == 0 { start } else { line_start(from) };
        first..line_start(from + LENGTH)
    })
}

fn read_segment<S: Sink>(text: &[u8], range: Range<usize>, block: &mut Block, part: S) -> Segment<S> {
    let mut segment = Segment {
        part,
        rows: 0,
        last_row: None,
        end: range.start,
        is_whole: false,
    };
    block.frames = 0;
    loop {
        let rest = &text[segment.end..range.end];
        let spaces = rest.iter().take_while(|byte| is_space(**byte)).count();
        segment.is_whole = spaces == rest.len();
        let length = block.read_plain_row(&rest[spaces..]);
        if let Some(length) = length {
            segment.end += spaces + length;
            segment.rows += 1;
        }
        if block.is_full() || length.is_none() {
            segment.last_row = block.last_row().or(segment.last_row);
            segment.part.append(block);
            block.frames = 0;
        }
        if length.is_none() {
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
            let ranges: Vec<_> = (0..).map_while(|index| range(&text, 5, index)).collect();
            assert_eq!(ranges.len(), 4);
            assert_eq!((ranges[0].start, ranges[3].end), (5, text.len()));
            for pair in ranges.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
                assert!(matches!(text[pair[0].end - 1], b'\n' | b'\r'));
            }
        }
    }

    #[test]
    fn a_line_longer_than_a_segment_is_in_one() {
        let text = [&[b'1'; 5 * LENGTH / 2][..], b"\n2\n"].concat();
        let ranges: Vec<_> = (0..).map_while(|index| range(&text, 0, index)).collect();
        let line = 5 * LENGTH / 2 + 1;
        assert_eq!(ranges, [0..line, line..line, line..line + 2]);
    }
}
