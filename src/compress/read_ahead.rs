//! Reading ahead: values that are needed soon are brought into the cache, one joint after the other.
//!
//! A pose takes one value of every joint, and the values of a joint lie in sequence, one for each frame. Processors
//! foresee accesses to a few sequences at a time. There are more joints than that, and without this most of the time
//! goes into waiting for memory.

use std::hint::black_box;
use std::ops::Range;

/// The frames that are read together: of a hundred joints they take about as much as the smallest second cache.
const FRAMES: usize = 64;

/// The bytes that processors read at once.
const CACHE_LINE: usize = 64;

/// The frames before this one have been read.
#[derive(Default)]
pub(super) struct FrameReader(usize);

impl FrameReader {
    /// Where `frame` has not been read, calls `read` with it and some frames after it, up to `end`.
    #[inline(always)]
    pub(super) fn reach(&mut self, frame: usize, end: usize, read: impl FnOnce(Range<usize>)) {
        if frame >= self.0 {
            let frames = frame..end.min(frame + FRAMES);
            self.0 = frames.end;
            read(frames);
        }
    }
}

/// Reads `number` of one value in each line of the cache, for those of the values that there are.
pub(super) fn read<T>(values: &[T], range: Range<usize>, number: impl Fn(&T) -> f32) {
    let values = &values[range.start.min(values.len())..range.end.min(values.len())];
    let every = (CACHE_LINE / size_of::<T>()).max(1);
    black_box(values.iter().step_by(every).map(number).sum::<f32>());
}
