//! Finds the most similar windows of two clips: the local minima of the matrix of their distances.

use std::ops::Range;

use mocap_scene::math::spread::spread;

use super::bound::{Bound, SLACK};
use super::clouds::{CloudSpace, Clouds};
use super::distance::Window;
use super::near::{Block, LANES, NeighbourIndex};

/// The number of windows in a tile. A tile is large, because windows at its edges overlap other tiles and are computed
/// twice. A tile is small enough for the second-level cache.
const TILE: usize = 96;

/// A pair of windows whose distance is a local minimum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Minimum {
    /// The two clips.
    pub(super) clips: [usize; 2],
    /// The first frame of each of the two windows.
    pub(super) starts: [usize; 2],
    /// The distance between the two windows, in metres.
    pub(super) distance: f32,
}

/// The distances between all windows of clip `a` and all windows of clip `b`, row by row.
pub(super) fn matrix(space: &CloudSpace, window: &Window, a: &Clouds, b: &Clouds) -> Vec<f32> {
    let (height, width) = (window.count(a), window.count(b));
    let starts: Vec<usize> = (0..height).step_by(TILE).collect();
    let bands = spread(&starts, |start| {
        band(space, window, (a, *start, (start + TILE).min(height)), b, 0..width)
    });
    bands.concat()
}

/// The local minima of the distances between windows of all clips, if they are below `threshold`, in the order of clips
/// and frames. The search skips overlapping windows of one clip, and pairs whose lower bound is above `threshold`.
pub(super) fn minima(space: &CloudSpace, window: &Window, clips: &[Clouds], threshold: f32) -> Vec<Minimum> {
    let numbers = Bound::new(space, window, clips).numbers(space, window, clips);
    let near = NeighbourIndex::new(&numbers);
    drop(numbers);
    let limit = (threshold * (1.0 + SLACK.0) + SLACK.1).powi(2);
    let places: Vec<usize> = (0..near.blocks().len()).collect();
    let found: Vec<Vec<Minimum>> = spread(&places, |place| {
        let (mut pairs, mut found) = (Vec::new(), Vec::new());
        near.of(*place, limit, &mut pairs);
        for (other, bits) in &pairs {
            let [own, other] = [*place, *other].map(|place| near.blocks()[place]);
            let (first, second, bits) = match (own.clip, own.start) <= (other.clip, other.start) {
                true => (own, other, *bits),
                false => (other, own, transposed(bits)),
            };
            let pair = Pair {
                space,
                window,
                clips: [&clips[first.clip], &clips[second.clip]],
                is_same: first.clip == second.clip,
                threshold,
            };
            let Some(rectangle) = pair.around(first, second, bits) else {
                continue;
            };
            let minima = pair.minima(rectangle).into_iter();
            found.extend(minima.map(|(starts, distance)| Minimum {
                clips: [first.clip, second.clip],
                starts,
                distance,
            }));
        }
        found
    });
    let mut found = found.concat();
    found.sort_unstable_by_key(|minimum| (minimum.clips, minimum.starts));
    found
}

/// A range of windows of one clip, and a range of windows of another clip or of the same clip.
type Rectangle = [Range<usize>; 2];

/// Transposes a matrix of eight by eight bits: rows become columns.
fn transposed(rows: &[u8; LANES]) -> [u8; LANES] {
    let bit = |row: usize, column: usize| (rows[row] >> column & 1) << row;
    std::array::from_fn(|column| (0..LANES).fold(0, |bits, row| bits | bit(row, column)))
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
    /// The first window that may pair with `row`. Within one clip, this window is the first window that does not
    /// overlap `row`.
    fn least(&self, row: usize) -> usize {
        if self.is_same { row + self.window.frames() } else { 0 }
    }

    /// The smallest rectangle with all near pairs of two blocks.
    fn around(&self, first: Block, second: Block, bits: [u8; LANES]) -> Option<Rectangle> {
        let cells = (0..LANES).flat_map(|row| (0..LANES).map(move |column| (row, column)));
        let near = cells.filter(|(row, column)| bits[*row] >> column & 1 == 1);
        let near = near.map(|(row, column)| [first.start + row, second.start + column]);
        let mut near = near.filter(|[row, column]| *column >= self.least(*row));
        let [row, column] = near.next()?;
        let begin = [row..row + 1, column..column + 1];
        Some(near.fold(begin, |[rows, columns], [row, column]| {
            [
                rows.start..row + 1,
                columns.start.min(column)..columns.end.max(column + 1),
            ]
        }))
    }

    /// The local minima within a rectangle.
    fn minima(&self, [rows, columns]: Rectangle) -> Vec<([usize; 2], f32)> {
        let [height, width] = self.clips.map(|clip| self.window.count(clip));
        // The rectangle is extended by a row and a column on each side, because a distance is a minimum only if its
        // neighbours are not smaller.
        let above = rows.start.saturating_sub(1)..(rows.end + 1).min(height);
        let beside = columns.start.saturating_sub(1)..(columns.end + 1).min(width);
        let [a, b] = self.clips;
        let distances = self
            .window
            .distances(self.space, (a, above.clone()), (b, beside.clone()));
        let at = |row: usize, column: usize| distances[(row - above.start) * beside.len() + column - beside.start];
        let mut found = Vec::new();
        for row in rows {
            for column in self.least(row).max(columns.start)..columns.end {
                let own = at(row, column);
                if own > self.threshold {
                    continue;
                }
                let is_least = (row.saturating_sub(1)..above.end.min(row + 2)).all(|other_row| {
                    (column.saturating_sub(1)..beside.end.min(column + 2)).all(|other| {
                        let distance = at(other_row, other);
                        // If neighbouring distances are equal, the first one counts as the minimum.
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

/// The distances between some rows and some columns, tile by tile.
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
