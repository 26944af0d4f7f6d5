//! Which frames keep a key.

use std::ops::Range;

/// The frames of the keys of a track, in order. The first and the last frame always have one.
pub(crate) type Grid = Vec<u32>;

/// Every frame.
pub(super) fn all(frames: usize) -> Grid {
    (0..frames as u32).collect()
}

/// As few keys as it takes that `fits(from, to)` holds for every two that follow one another, found by going as far as
/// possible from each. Two neighbouring frames have none between them, so they always fit.
///
/// The reach of one key is a good guess for that of the next. From there it grows or shrinks by doubled steps, so that
/// the cost of a key grows with its reach and not with the square of it.
pub(super) fn farthest(frames: usize, mut fits: impl FnMut(usize, usize) -> bool) -> Grid {
    let mut grid = vec![0];
    let last = frames.saturating_sub(1);
    let (mut from, mut guess) = (0, 1);
    while from < last {
        let longest = last - from;
        // The largest reach known to fit, and the smallest known not to.
        let (mut good, mut bad) = (1, longest + 1);
        let mut reach = guess.clamp(1, longest);
        while good + 1 < bad {
            reach = reach.clamp(good + 1, bad - 1);
            if fits(from, from + reach) {
                good = reach;
                reach = if bad > longest {
                    reach + 1 + reach / 2
                } else {
                    usize::midpoint(good, bad)
                };
            } else {
                bad = reach;
                reach = usize::midpoint(good, bad);
            }
        }
        from += good;
        guess = good;
        grid.push(from as u32);
    }
    grid
}

/// A frame that gets its key back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Insertion {
    pub(super) frame: usize,
    /// The place of the key before it, in the grid as it was.
    pub(super) after: usize,
}

/// How many frames between two keys get theirs back where one is too far off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Amount {
    /// That whose error is the largest.
    Worst,
    /// All of them.
    All,
}

/// Gives keys back, between every two, where the error of a frame is beyond `bound`. Gives these, and for each two the
/// frames from the key before to the one after, this left out.
pub(super) fn refine<T: Copy + PartialOrd>(
    grid: &mut Grid,
    errors: &[T],
    bound: T,
    amount: Amount,
) -> (Vec<Insertion>, Vec<Range<usize>>) {
    let (mut insertions, mut stretches) = (Vec::new(), Vec::new());
    for (after, pair) in grid.windows(2).enumerate() {
        let (key, next) = (pair[0] as usize, pair[1] as usize);
        let (mut worst, mut largest) = (None, bound);
        for (frame, error) in std::iter::zip(key + 1..next, &errors[key + 1..next]) {
            if *error > largest {
                (worst, largest) = (Some(frame), *error);
            }
        }
        let Some(worst) = worst else { continue };
        let frames = match amount {
            Amount::Worst => worst..worst + 1,
            Amount::All => key + 1..next,
        };
        insertions.extend(frames.map(|frame| Insertion { frame, after }));
        stretches.push(key..next);
    }
    let frames: Vec<u32> = insertions.iter().map(|insertion| insertion.frame as u32).collect();
    insert(grid, &insertions, &frames);
    (insertions, stretches)
}

/// Puts new values behind others, in place.
pub(super) fn insert<T: Copy>(values: &mut Vec<T>, insertions: &[Insertion], new: &[T]) {
    let mut end = values.len();
    values.extend_from_slice(new);
    // From the end on, so that nothing is written over that is still to be moved.
    for (place, (insertion, value)) in std::iter::zip(insertions, new).enumerate().rev() {
        let first = insertion.after + 1;
        values.copy_within(first..end, first + place + 1);
        values[first + place] = *value;
        end = first;
    }
}

/// The frames of some stretches.
pub(super) fn frames(stretches: &[Range<usize>]) -> impl Iterator<Item = usize> {
    stretches.iter().cloned().flatten()
}

/// How far a frame is from one key to the next.
fn share(ticks: &[f64], from: usize, to: usize, frame: usize) -> f32 {
    ((ticks[frame] - ticks[from]) / (ticks[to] - ticks[from])) as f32
}

/// The frames between two keys, and how far each is from one to the other. From the middle outwards: the error is most
/// often largest there.
pub(super) fn inner(ticks: &[f64], from: usize, to: usize) -> impl Iterator<Item = (usize, f32)> {
    let middle = usize::midpoint(from, to);
    let frames = (middle..to).chain((from + 1..middle).rev());
    frames.map(move |frame| (frame, share(ticks, from, to, frame)))
}

/// The keys around the frames of some stretches, each of which begins at a key and ends before one: calls
/// `with(frame, key, share)` for each, `share` being how far it is from `key` to the next. At a key the share is 0.
pub(super) fn between(
    grid: &[u32],
    ticks: &[f64],
    stretches: &[Range<usize>],
    mut with: impl FnMut(usize, usize, f32),
) {
    for stretch in stretches {
        let first = grid.partition_point(|key| (*key as usize) < stretch.start);
        for key in first..grid.len() {
            let from = grid[key] as usize;
            if from >= stretch.end {
                break;
            }
            with(from, key, 0.0);
            if let Some(&to) = grid.get(key + 1) {
                let to = to as usize;
                for frame in from + 1..to {
                    with(frame, key, share(ticks, from, to, frame));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::slice;

    use super::*;

    #[test]
    fn keys_are_as_far_apart_as_they_may_be() {
        for reach in [1, 2, 3, 7, 100] {
            let grid = farthest(50, |from, to| to - from <= reach);
            let expected: Vec<u32> = (0..49).step_by(reach).chain([49]).collect();
            assert_eq!(grid, expected, "{reach}");
        }
        assert_eq!(farthest(0, |_, _| true), [0]);
        assert_eq!(farthest(1, |_, _| true), [0]);
        assert_eq!(farthest(2, |_, _| true), [0, 1]);
    }

    #[test]
    fn a_frame_that_is_too_far_off_gets_its_key_back() {
        let errors = [0.0, 2.0, 3.0, 0.5, 1.5, 0.0];
        let mut grid = vec![0, 3, 5];
        let insertion = |frame, after| Insertion { frame, after };
        let found = refine(&mut grid, &errors, 1.0, Amount::Worst);
        assert_eq!(found, (vec![insertion(2, 0), insertion(4, 1)], vec![0..3, 3..5]));
        assert_eq!(grid, [0, 2, 3, 4, 5]);
        let stretches = slice::from_ref(&(0..2)).to_vec();
        let found = refine(&mut grid, &errors, 1.0, Amount::Worst);
        assert_eq!(found, (vec![insertion(1, 0)], stretches));
        assert_eq!(grid, [0, 1, 2, 3, 4, 5]);
        assert_eq!(refine(&mut grid, &errors, 1.0, Amount::Worst), (vec![], vec![]));

        let mut grid = vec![0, 3, 5];
        let found = refine(&mut grid, &errors, 1.8, Amount::All);
        let stretches = slice::from_ref(&(0..3)).to_vec();
        assert_eq!(found, (vec![insertion(1, 0), insertion(2, 0)], stretches));
        assert_eq!(grid, [0, 1, 2, 3, 5]);
    }

    #[test]
    fn every_frame_lies_between_its_keys() {
        let ticks = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0];
        let mut found = Vec::new();
        between(&[0, 3, 5], &ticks, slice::from_ref(&(0..6)), |frame, key, share| {
            found.push((frame, key, share));
        });
        let expected = [
            (0, 0, 0.0),
            (1, 0, 0.5),
            (2, 0, 0.75),
            (3, 1, 0.0),
            (4, 1, 0.5),
            (5, 2, 0.0),
        ];
        assert_eq!(found, expected);
        let mut found = Vec::new();
        between(&[0, 2, 3, 5], &ticks, &[0..2, 3..5], |frame, key, _| {
            found.push((frame, key));
        });
        assert_eq!(found, [(0, 0), (1, 0), (3, 2), (4, 2)]);
    }

    #[test]
    fn new_values_stand_behind_the_others() {
        let mut values = vec!["a", "c", "d", "e", "g"];
        let insertion = |after| Insertion { frame: 0, after };
        insert(
            &mut values,
            &[insertion(0), insertion(3), insertion(4)],
            &["b", "f", "h"],
        );
        assert_eq!(values, ["a", "b", "c", "d", "e", "f", "g", "h"]);
    }
}
