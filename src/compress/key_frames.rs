//! Key frame reduction: which frames keep a key, and what lies between two keys.
//!
//! Reduction is line simplification by the opening-window algorithm: from one key the next is as far away as the error
//! allows (N. Meratnia and R. A. de By, "Spatiotemporal Compression Techniques for Moving Point Objects", EDBT 2004).
//! Refinement gives keys back where the error is too large after all, as in the algorithm of Ramer, Douglas and
//! Peucker.

use std::ops::Range;

/// The frames at which a track has keys, ascending. The first and the last frame always have one.
#[doc(hidden)]
pub type KeyFrames = Vec<u32>;

/// A key at every frame.
pub fn every_frame(frames: usize) -> KeyFrames {
    (0..frames as u32).collect()
}

/// The key frames that are left if `fits(from, to)` has to hold for every two keys in sequence. Two frames that follow
/// one another have no frame between them and always fit.
///
/// The distance to the next key is found by exponential search, which starts from the previous distance. The number of
/// calls for a key is about the logarithm of the change of the distance.
pub fn reduce(frames: usize, mut fits: impl FnMut(usize, usize) -> bool) -> KeyFrames {
    let mut key_frames = vec![0];
    let last = frames.saturating_sub(1);
    let (mut from, mut guess) = (0, 1);
    while from < last {
        let longest = last - from;
        // The largest distance that is known to fit, and the smallest that is known not to.
        let (mut good, mut bad) = (1, longest + 1);
        let mut distance = guess.clamp(1, longest);
        while good + 1 < bad {
            distance = distance.clamp(good + 1, bad - 1);
            if fits(from, from + distance) {
                good = distance;
                distance = if bad > longest {
                    distance + 1 + distance / 2
                } else {
                    usize::midpoint(good, bad)
                };
            } else {
                bad = distance;
                distance = usize::midpoint(good, bad);
            }
        }
        from += good;
        guess = good;
        key_frames.push(from as u32);
    }
    key_frames
}

/// A key to insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Insertion {
    /// The frame of the new key.
    pub frame: usize,
    /// The index of the key before it, among the keys as they were before any insertion.
    pub after: usize,
}

/// Which frames between two keys get a key where the error of one is too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refine {
    /// The frame with the largest error.
    Worst,
    /// Every frame.
    All,
}

/// Inserts keys between every two where the error of a frame is above `bound`. Returns the insertions, and the range of
/// frames that each changes: from the key before it up to the key after it, which is not part of the range.
pub fn refine<T: Copy + PartialOrd>(
    key_frames: &mut KeyFrames,
    errors: &[T],
    bound: T,
    refine: Refine,
) -> (Vec<Insertion>, Vec<Range<usize>>) {
    let (mut insertions, mut changed) = (Vec::new(), Vec::new());
    for (after, pair) in key_frames.windows(2).enumerate() {
        let (key, next) = (pair[0] as usize, pair[1] as usize);
        let (mut worst, mut largest) = (None, bound);
        for (frame, error) in std::iter::zip(key + 1..next, &errors[key + 1..next]) {
            if *error > largest {
                (worst, largest) = (Some(frame), *error);
            }
        }
        let Some(worst) = worst else { continue };
        let frames = match refine {
            Refine::Worst => worst..worst + 1,
            Refine::All => key + 1..next,
        };
        insertions.extend(frames.map(|frame| Insertion { frame, after }));
        changed.push(key..next);
    }
    let frames: Vec<u32> = insertions.iter().map(|insertion| insertion.frame as u32).collect();
    insert(key_frames, &insertions, &frames);
    (insertions, changed)
}

/// Inserts `new` values, one per insertion.
pub fn insert<T: Copy>(values: &mut Vec<T>, insertions: &[Insertion], new: &[T]) {
    let mut end = values.len();
    values.extend_from_slice(new);
    // Backwards, so that no value is overwritten before it is moved.
    for (index, (insertion, value)) in std::iter::zip(insertions, new).enumerate().rev() {
        let first = insertion.after + 1;
        values.copy_within(first..end, first + index + 1);
        values[first + index] = *value;
        end = first;
    }
}

/// The interpolation factor of a frame between the keys at `from` (0) and `to` (1).
pub(super) fn alpha(ticks: &[f64], from: usize, to: usize, frame: usize) -> f32 {
    ((ticks[frame] - ticks[from]) / (ticks[to] - ticks[from])) as f32
}

/// The frames between two keys with their interpolation factors, from the middle outwards, because the error is most
/// often largest in the middle.
pub fn between(ticks: &[f64], from: usize, to: usize) -> impl Iterator<Item = (usize, f32)> {
    let middle = usize::midpoint(from, to);
    let frames = (middle..to).chain((from + 1..middle).rev());
    frames.map(move |frame| (frame, alpha(ticks, from, to, frame)))
}

/// Calls `visit(frame, key, alpha)` for every frame of `ranges`. `key` is the index of the last key that is not after
/// the frame. `alpha` is the interpolation factor from there to the next key, 0 at a key. Each range starts at a key
/// and ends before one.
pub fn for_each_frame(
    key_frames: &[u32],
    ticks: &[f64],
    ranges: &[Range<usize>],
    mut visit: impl FnMut(usize, usize, f32),
) {
    for range in ranges {
        let first = key_frames.partition_point(|key| (*key as usize) < range.start);
        for key in first..key_frames.len() {
            let from = key_frames[key] as usize;
            if from >= range.end {
                break;
            }
            visit(from, key, 0.0);
            if let Some(&to) = key_frames.get(key + 1) {
                let to = to as usize;
                for frame in from + 1..to {
                    visit(frame, key, alpha(ticks, from, to, frame));
                }
            }
        }
    }
}
