//! Reads plain rows piece by piece, with one thread or several.
//!
//! The line counts of earlier pieces give the index of a piece's first frame. With this index, each thread writes its
//! keys directly to their final place. The keys from the first line that is not a plain row on are discarded, and the
//! careful path reads these lines again. Therefore the result does not depend on the number of threads.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::thread;

use super::pieces::{Piece, Pieces};
use super::{Block, Frames};
use crate::Failure;
use crate::text::is_space;

/// The smallest number of bytes in memory for which a second thread saves time.
pub(super) const WORTHWHILE: usize = 2 << 20;

/// The result of reading pieces.
pub(super) struct Read {
    pub(super) rows: usize,
    /// The offset after the last row that was read.
    pub(super) end: usize,
    pub(super) last_row: Vec<f64>,
    /// Whether only spaces follow the rows.
    pub(super) is_all: bool,
}

impl Read {
    /// The result without any row. The rows begin at `start`, and `last_row` is the row before them.
    fn nothing(start: usize, last_row: &[f64]) -> Self {
        Self {
            rows: 0,
            end: start,
            last_row: last_row.to_vec(),
            is_all: true,
        }
    }

    /// Adds the rows of the next piece.
    fn add(&mut self, segment: Segment) {
        self.rows += segment.rows;
        self.end = segment.end;
        self.is_all = segment.is_whole;
        if let Some(last_row) = segment.last_row {
            self.last_row = last_row;
        }
    }
}

/// The rows of one piece.
struct Segment {
    rows: usize,
    last_row: Option<Vec<f64>>,
    /// The offset after the last plain row of the piece.
    end: usize,
    /// Whether every line is a plain row that was requested, and all its keys are written.
    is_whole: bool,
}

/// The pieces and the frames that no thread has taken yet.
struct Turn<'a, F> {
    pieces: Pieces<'a>,
    frames: F,
    left: usize,
    taken: usize,
    failure: Option<Failure>,
}

impl<'a, F: Frames> Turn<'a, F> {
    /// The next piece with its index, and the frames of its rows.
    fn take<'b>(&mut self, buffer: &'b mut Vec<u8>) -> Option<(usize, Piece<'b>, usize, F)>
    where
        'a: 'b,
    {
        let piece = match self.pieces.next(buffer) {
            Ok(piece) => piece?,
            Err(failure) => {
                self.failure.get_or_insert(failure);
                return None;
            }
        };
        let rows = piece.lines.min(self.left);
        self.left -= rows;
        self.taken += 1;
        Some((self.taken - 1, piece, rows, self.frames.split_off(rows)))
    }
}

/// The requested number of threads, or else the number of cores.
pub(super) fn thread_count(asked: Option<NonZeroUsize>) -> usize {
    asked
        .or_else(|| thread::available_parallelism().ok())
        .map_or(1, NonZeroUsize::get)
}

/// Reads plain rows of the pieces into `frames`, which holds `most` frames, with several threads.
///
/// The text of the previous row, `last_row`, ends at `start`.
pub(super) fn read<F: Frames>(
    pieces: Pieces<'_>,
    start: usize,
    threads: usize,
    most: usize,
    last_row: &[f64],
    frames: F,
) -> Result<Read, Failure> {
    let turn = Mutex::new(Turn {
        pieces,
        frames,
        left: most,
        taken: 0,
        failure: None,
    });
    let segments = Mutex::new(Vec::new());
    // Set by the first piece that is not whole: the pieces after it are discarded.
    let is_over = AtomicBool::new(false);
    let work = || {
        let mut block = Block::new(last_row.len());
        let mut buffer = Vec::new();
        while !is_over.load(Ordering::Relaxed) {
            let Some((index, piece, rows, mut frames)) = lock(&turn).take(&mut buffer) else {
                break;
            };
            let segment = read_piece(&piece, rows, &mut block, |block| frames.fill(block));
            if !segment.is_whole {
                is_over.store(true, Ordering::Relaxed);
            }
            lock(&segments).push((index, segment));
        }
    };
    thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    if let Some(failure) = lock(&turn).failure.take() {
        return Err(failure);
    }
    let mut segments = std::mem::take(&mut *lock(&segments));
    segments.sort_unstable_by_key(|&(index, _)| index);
    let mut read = Read::nothing(start, last_row);
    for (_, segment) in segments {
        read.add(segment);
        if !read.is_all {
            break;
        }
    }
    Ok(read)
}

/// Locks a mutex. A mutex is poisoned only if a thread panics, which would be a defect of this module.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("nothing panics while it holds this lock")
}

/// Reads at most `most` plain rows of the pieces with one thread, and passes them to `append` block by block.
pub(super) fn read_alone(
    mut pieces: Pieces<'_>,
    start: usize,
    most: usize,
    last_row: &[f64],
    mut append: impl FnMut(&Block),
) -> Result<Read, Failure> {
    let mut block = Block::new(last_row.len());
    let mut buffer = Vec::new();
    let mut read = Read::nothing(start, last_row);
    while read.is_all
        && let Some(piece) = pieces.next(&mut buffer)?
    {
        let rows = piece.lines.min(most - read.rows);
        read.add(read_piece(&piece, rows, &mut block, &mut append));
    }
    Ok(read)
}

/// Reads at most `rows` plain rows, and passes them to `put` block by block.
fn read_piece(piece: &Piece<'_>, rows: usize, block: &mut Block, mut put: impl FnMut(&Block)) -> Segment {
    let mut segment = Segment {
        rows: 0,
        last_row: None,
        end: piece.offset,
        is_whole: false,
    };
    block.frames = 0;
    loop {
        let rest = &piece.text[segment.end - piece.offset..];
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
            put(block);
            block.frames = 0;
        }
        if length.is_none() {
            segment.is_whole = segment.rows == rows && spaces == rest.len();
            return segment;
        }
    }
}
