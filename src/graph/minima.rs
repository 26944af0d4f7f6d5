//! The moments of two clips that are most alike: local minima of the matrix of their distances.

use std::ops::Range;

use super::bound::{BLOCK, Bounds, Rectangle};
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
/// clip that overlap are no pair. Blocks of windows that cannot be so near are not compared.
pub(super) fn minima(space: &CloudSpace, window: &Window, clips: &[Clouds], threshold: f32) -> Vec<Minimum> {
    let bounds = Bounds::of(space, window, clips);
    let blocks = |clip: usize| window.count(&clips[clip]).div_ceil(BLOCK);
    let work = (0..clips.len()).flat_map(|clip| (0..blocks(clip)).map(move |block| (clip, block)));
    let work: Vec<(usize, usize)> = work.collect();
    let found: Vec<Vec<Minimum>> = spread(&work, |(first, block)| {
        let mut found = Vec::new();
        for second in *first..clips.len() {
            let pair = Pair {
                space,
                window,
                clips: [&clips[*first], &clips[second]],
                is_same: *first == second,
                threshold,
            };
            let apart = (*first == second).then(|| window.frames());
            for near in bounds[*first].near(*block, &bounds[second], threshold, apart) {
                let minima = pair.minima(near).into_iter();
                found.extend(minima.map(|(starts, distance)| Minimum {
                    clips: [*first, second],
                    starts,
                    distance,
                }));
            }
        }
        found
    });
    let mut found = found.concat();
    found.sort_by_key(|minimum| (minimum.clips, minimum.starts));
    found
}

/// Two clips that are compared.
struct Pair<'a> {
    space: &'a CloudSpace,
    window: &'a Window,
    clips: [&'a Clouds; 2],
    is_same: bool,
    threshold: f32,
}

impl Pair<'_> {
    /// The minima of some rows and some columns.
    fn minima(&self, [rows, columns]: Rectangle) -> Vec<([usize; 2], f32)> {
        let [height, width] = self.clips.map(|clip| self.window.count(clip));
        // A row and a column more on each side are neighbours.
        let above = rows.start.saturating_sub(1)..(rows.end + 1).min(height);
        let beside = columns.start.saturating_sub(1)..(columns.end + 1).min(width);
        let [a, b] = self.clips;
        let distances = self
            .window
            .distances(self.space, (a, above.clone()), (b, beside.clone()));
        let at = |row: usize, column: usize| distances[(row - above.start) * beside.len() + column - beside.start];
        let mut found = Vec::new();
        for row in rows {
            let least = if self.is_same { row + self.window.frames() } else { 0 };
            for column in least.max(columns.start)..columns.end {
                let own = at(row, column);
                if own > self.threshold {
                    continue;
                }
                let is_least = (row.saturating_sub(1)..above.end.min(row + 2)).all(|other_row| {
                    (column.saturating_sub(1)..beside.end.min(column + 2)).all(|other| {
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
}

/// The distances of some rows to some columns, tile by tile.
fn band(
    space: &CloudSpace,
    window: &Window,
    (a, start, end): (&Clouds, usize, usize),
    b: &Clouds,
    columns: Range<usize>,
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
