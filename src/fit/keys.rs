//! Which frames keep a key.

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

/// Gives a key back, between every two, to the frame whose error is the largest, where that is beyond `bound`. Tells
/// whether there was one.
pub(super) fn refine<T: Copy + PartialOrd>(grid: &mut Grid, errors: &[T], bound: T) -> bool {
    let mut refined = Vec::with_capacity(grid.len() + grid.len() / 16);
    for (place, &key) in grid.iter().enumerate() {
        refined.push(key);
        let Some(&next) = grid.get(place + 1) else { continue };
        let (mut worst, mut largest) = (None, bound);
        for frame in key + 1..next {
            if errors[frame as usize] > largest {
                (worst, largest) = (Some(frame), errors[frame as usize]);
            }
        }
        refined.extend(worst);
    }
    let is_finer = refined.len() > grid.len();
    *grid = refined;
    is_finer
}

/// The keys around every frame: calls `with(frame, key, share)` for each, `share` being how far it is from `key` to the
/// next. At a key the share is 0.
pub(super) fn between(grid: &[u32], ticks: &[f64], mut with: impl FnMut(usize, usize, f32)) {
    for key in 0..grid.len() {
        let from = grid[key] as usize;
        with(from, key, 0.0);
        if let Some(&to) = grid.get(key + 1) {
            let span = ticks[to as usize] - ticks[from];
            for frame in from + 1..to as usize {
                with(frame, key, ((ticks[frame] - ticks[from]) / span) as f32);
            }
        }
    }
}

#[cfg(test)]
mod tests {
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
        assert!(refine(&mut grid, &errors, 1.0));
        assert_eq!(grid, [0, 2, 3, 4, 5]);
        assert!(refine(&mut grid, &errors, 1.0));
        assert_eq!(grid, [0, 1, 2, 3, 4, 5]);
        assert!(!refine(&mut grid, &errors, 1.0));
    }

    #[test]
    fn every_frame_lies_between_its_keys() {
        let ticks = [0.0, 1.0, 1.5, 2.0, 3.0, 4.0];
        let mut found = Vec::new();
        between(&[0, 3, 5], &ticks, |frame, key, share| found.push((frame, key, share)));
        let expected = [
            (0, 0, 0.0),
            (1, 0, 0.5),
            (2, 0, 0.75),
            (3, 1, 0.0),
            (4, 1, 0.5),
            (5, 2, 0.0),
        ];
        assert_eq!(found, expected);
    }
}
