//! Prefetching: loads values that are needed soon into the cache, joint by joint.
//!
//! A pose takes one value of every joint, and the values of a joint are consecutive, one for each frame. Processors
//! predict accesses to a few sequences at a time, but there are more joints. Without prefetching, most of the time is
//! spent waiting for memory.

use std::hint::black_box;
use std::ops::Range;

/// The number of frames to read together. For a hundred joints, the values of these frames fill about the smallest
/// second-level cache.
const FRAMES: usize = 64;

/// The bytes that processors read at once.
const CACHE_LINE: usize = 64;

/// The first frame that has not been read.
#[derive(Default)]
pub(super) struct FrameReader(usize);

impl FrameReader {
    /// If `frame` has not been read, calls `read` with a range of frames. The range starts at `frame` and ends at `end`
    /// at the latest.
    #[inline(always)]
    pub(super) fn reach(&mut self, frame: usize, end: usize, read: impl FnOnce(Range<usize>)) {
        if frame >= self.0 {
            let frames = frame..end.min(frame + FRAMES);
            self.0 = frames.end;
            read(frames);
        }
    }
}

/// In each cache line of a range of `values`, reads the number that `number` takes from one value. Ignores indices
/// beyond the end.
pub(super) fn read<T>(values: &[T], range: Range<usize>, number: impl Fn(&T) -> f32) {
    let values = &values[range.start.min(values.len())..range.end.min(values.len())];
    let every = (CACHE_LINE / size_of::<T>()).max(1);
    black_box(values.iter().step_by(every).map(number).sum::<f32>());
}
