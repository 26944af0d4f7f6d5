//! The moments of two clips that are most alike: local minima of the matrix of their distances.

use super::clouds::{CloudSpace, Clouds};
use super::distance::Window;
use crate::math::spread::spread;

/// Windows in a tile: large enough that its edges, where windows overlap other tiles, cost little; small enough for the
/// second cache.
const TILE: usize = 96;

/// Two windows that are most alike among those around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Minimum {
    /// The clips.
    pub(super) clips: [usize; 2],
    /// The first frames of both windows.
    pub(super) starts: [usize; 2],
    /// In metres.
    pub(super) distance: f32,
}

/// What is compared: tiles of the matrix of two clips.
struct Work {
    clips: [usize; 2],
    start: usize,
}

/// The distances of all windows of two clips, row by row.
pub(super) fn matrix(space: &CloudSpace, window: &Window, a: &Clouds, b: &Clouds) -> Vec<f32> {
    let (height, width) = (window.count(a), window.count(b));
    let starts: Vec<usize> = (0..height).step_by(TILE).collect();
    let bands = spread(&starts, |start| {
        band(space, window, (a, *start, (start + TILE).min(height)), b, 0..width)
    });
    bands.concat()
}

/// The local minima below `threshold` of the distances of all clips, in the order of clips and frames. Windows of one
/// clip that overlap are no pair.
pub(super) fn minima(space: &CloudSpace, window: &Window, clips: &[Clouds], threshold: f32) -> Vec<Minimum> {
    let mut work = Vec::new();
    for first in 0..clips.len() {
        for second in first..clips.len() {
            for start in (0..window.count(&clips[first])).step_by(TILE) {
                let clips = [first, second];
                work.push(Work { clips, start });
            }
        }
    }
    let found: Vec<Vec<Minimum>> = spread(&work, |work| {
        let [a, b] = work.clips.map(|clip| &clips[clip]);
        let is_same = work.clips[0] == work.clips[1];
        of_band(space, window, (a, work.start), (b, is_same), threshold)
            .into_iter()
            .map(|(starts, distance)| Minimum {
                clips: work.clips,
                starts,
                distance,
            })
            .collect()
    });
    found.concat()
}

/// The minima of the rows from `start` to the next tile.
fn of_band(
    space: &CloudSpace,
    window: &Window,
    (a, start): (&Clouds, usize),
    (b, is_same): (&Clouds, bool),
    threshold: f32,
) -> Vec<([usize; 2], f32)> {
    let (height, width) = (window.count(a), window.count(b));
    let end = (start + TILE).min(height);
    // A row and a column more on each side are neighbours.
    let (above, below) = (start.saturating_sub(1), (end + 1).min(height));
    let first = if is_same {
        (above + window.frames()).saturating_sub(2)
    } else {
        0
    };
    if first >= width {
        return Vec::new();
    }
    let columns = width - first;
    let distances = band(space, window, (a, above, below), b, first..width);
    let at = |row: usize, column: usize| distances[(row - above) * columns + column - first];
    let mut found = Vec::new();
    for row in start..end {
        let least = if is_same { row + window.frames() } else { 0 };
        for column in least..width {
            let own = at(row, column);
            if own > threshold {
                continue;
            }
            let is_least = (row.saturating_sub(1)..below.min(row + 2)).all(|other_row| {
                (column.saturating_sub(1).max(first)..width.min(column + 2)).all(|other| {
                    let distance = at(other_row, other);
                    // Of equal ones the first counts.
                    distance > own || (distance == own && (other_row, other) >= (row, column))
                })
            });
            if is_least {
                found.push(([row, column], own));
            }
        }
    }
    found
}

/// The distances of some rows to some columns, tile by tile.
fn band(
    space: &CloudSpace,
    window: &Window,
    (a, start, end): (&Clouds, usize, usize),
    b: &Clouds,
    columns: std::ops::Range<usize>,
) -> Vec<f32> {
    let width = columns.len();
    let mut band = vec![0.0; (end - start) * width];
    for left in columns.clone().step_by(TILE) {
        let tile = left..(left + TILE).min(columns.end);
        let distances = window.distances(space, (a, start..end), (b, tile.clone()));
        for (row, values) in distances.chunks_exact(tile.len()).enumerate() {
            let cell = row * width + left - columns.start;
            band[cell..cell + values.len()].copy_from_slice(values);
        }
    }
    band
}
