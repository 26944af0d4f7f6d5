//! Key frame reduction: chooses the frames that keep a key, and interpolates between keys.
//!
//! Reduction is line simplification by the opening-window algorithm: each key is as far from the previous key as the
//! error allows (N. Meratnia and R. A. de By, "Spatiotemporal Compression Techniques for Moving Point Objects", EDBT
//! 2004). Refinement restores keys if the error is too large after all, as in the algorithm of Ramer, Douglas and
//! Peucker.

use std::ops::Range;

/// The frames at which a track has keys, in ascending order. The first and the last frame always have one.
#[doc(hidden)]
pub type KeyFrames = Vec<u32>;

/// A key at every frame.
pub fn every_frame(frames: usize) -> KeyFrames {
    (0..frames as u32).collect()
}

/// Removes key frames. For every two consecutive keys that remain, `fits(from, to)` holds. Adjacent frames have no
/// frame between them and always fit.
///
/// An exponential search finds the distance to the next key, starting from the previous distance. The number of calls
/// of `fits` per key is about the logarithm of the change of the distance.
pub fn reduce(frames: usize, mut fits: impl FnMut(usize, usize) -> bool) -> KeyFrames {
    let mut key_frames = vec![0];
    let last = frames.saturating_sub(1);
    let (mut from, mut guess) = (0, 1);
    while from < last {
        let longest = last - from;
        // The largest distance known to fit, and the smallest known not to fit.
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
    /// The index of the key before the new key, among the keys before any insertion.
    pub after: usize,
}

/// Which frames get a key, if the error of a frame between two keys is too large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refine {
    /// The frame with the largest error.
    Worst,
    /// Every frame between the two keys.
    All,
}

/// Inserts keys between consecutive keys where the error of a frame is above `bound`. Returns the insertions, and the
/// range of frames that each changes: from the previous key up to the next key, which is excluded.
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
    // Backwards, so that no value is overwritten before it moves.
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

/// The frames between two keys with their interpolation factors. They run from the middle outwards, because the error
/// is usually largest in the middle.
pub fn between(ticks: &[f64], from: usize, to: usize) -> impl Iterator<Item = (usize, f32)> {
    let middle = usize::midpoint(from, to);
    let frames = (middle..to).chain((from + 1..middle).rev());
    frames.map(move |frame| (frame, alpha(ticks, from, to, frame)))
}

/// Calls `visit(frame, key, alpha)` for every frame of `ranges`. `key` is the index of the last key at or before the
/// frame. `alpha` is the interpolation factor from this key to the next, and 0 at a key. Each range starts at a key and
/// ends before a key.
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
