//! The frame nearest to a query, exactly: boxes around 16, 64 and 1,024 frames. A box is left out where its nearest
//! point is farther than the best frame so far. Holden's demonstration has boxes around consecutive frames. Here the
//! frames are split in halves along the feature in which they spread most, and the halves again, as in a k-d tree
//! (Friedman, Bentley and Finkel, 1977), so that boxes are small.
//!
//! Features are compared less their mean, over the deviation of their group (the positions of a foot are one), times
//! a weight. A distance is a sum of squares in one fixed order, and that of a box in the same order of smaller
//! squares, so rounding leaves no frame out.

use std::ops::Range;

use super::database::Database;
use super::features::FEATURES;
use crate::math::wide;

/// The groups of features and their weights: those of Holden's demonstration.
const GROUPS: [(Range<usize>, f32); 7] = [
    (0..3, 0.75),
    (3..6, 0.75),
    (6..9, 1.0),
    (9..12, 1.0),
    (12..15, 1.0),
    (15..21, 1.0),
    (21..27, 1.5),
];
/// Frames of a box, the large ones first; each a multiple of the next.
const SIZES: [usize; 3] = [1024, 64, 16];
/// Frames at the end of a clip that are not found: after them there is a third of a second at most.
const ENDS: usize = 20;

type Row = [f32; FEATURES];

/// The frames of a database, to find the one nearest to a query.
///
/// ```
/// use mocap::matching::{Database, FeatureTree, IndexedClip};
///
/// let scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
/// let database = Database::new(IndexedClip::of(&scene, "walk.bvh", false));
/// let tree = FeatureTree::new(&database);
/// let query = tree.normalized(&database.clips()[0].features()[100]);
/// assert_eq!(tree.nearest(&query, f32::INFINITY, 0..0), Some((100, 0.0)));
/// assert!(tree.nearest(&query, f32::INFINITY, 80..120).is_some_and(|(frame, distance)| frame < 80 && distance > 0.0));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct FeatureTree {
    mean: Row,
    /// The deviation of the group, over its weight.
    scale: Row,
    /// The frames that can be found, so that those of a box stand together.
    frames: Vec<u32>,
    /// Their features.
    rows: Vec<Row>,
    /// For each of [`SIZES`] the least and the largest values of the frames of each box.
    boxes: [Vec<[Row; 2]>; 3],
}

impl FeatureTree {
    /// The frames of all clips, in their order; the last third of a second of a clip is never found.
    pub fn new(database: &Database) -> Self {
        let rows: Vec<Row> = database.features().copied().collect();
        let mut found = Vec::with_capacity(rows.len());
        let mut first = 0;
        for clip in database.clips() {
            let count = clip.features().len();
            found.extend(first..first + count.saturating_sub(ENDS) as u32);
            first += count as u32;
        }
        Self::of_rows(rows, found)
    }

    /// Any frames, all of which are found.
    pub fn of_frames(frames: &[[f32; FEATURES]]) -> Self {
        Self::of_rows(frames.to_vec(), (0..frames.len() as u32).collect())
    }

    fn of_rows(mut rows: Vec<Row>, mut frames: Vec<u32>) -> Self {
        let (mean, scale) = statistics(&rows);
        for row in &mut rows {
            *row = std::array::from_fn(|column| (row[column] - mean[column]) / scale[column]);
        }
        halve(&mut frames, &rows);
        let rows: Vec<Row> = frames.iter().map(|frame| rows[*frame as usize]).collect();
        let boxes = SIZES.map(|size| rows.chunks(size).map(bounds).collect());
        Self {
            mean,
            scale,
            frames,
            rows,
            boxes,
        }
    }

    /// Features as they are compared.
    pub fn normalized(&self, features: &[f32; FEATURES]) -> [f32; FEATURES] {
        std::array::from_fn(|column| (features[column] - self.mean[column]) / self.scale[column])
    }

    /// The squared distance of two normalized rows.
    pub(super) fn distance(&self, a: &[f32; FEATURES], b: &[f32; FEATURES]) -> f32 {
        squared_distance(a, b)
    }

    /// The frame nearest to a normalized query, of those nearer than `limit`, a squared distance, and not in `except`;
    /// with its squared distance. Of equally near ones, one.
    pub fn nearest(&self, query: &[f32; FEATURES], limit: f32, except: Range<usize>) -> Option<(usize, f32)> {
        let mut best = Best {
            frame: usize::MAX,
            distance: limit,
            except,
        };
        search(self, query, &mut best);
        (best.frame != usize::MAX).then_some((best.frame, best.distance))
    }
}

struct Best {
    frame: usize,
    distance: f32,
    except: Range<usize>,
}

wide::dispatch! {
    fn search(tree: &FeatureTree, query: &Row, best: &mut Best) {
        // The nearest of the largest boxes first, for an early limit.
        let mut nearest = (0, f32::INFINITY);
        for (index, bounds) in tree.boxes[0].iter().enumerate() {
            let distance = to_box(query, bounds, nearest.1);
            if distance < nearest.1 {
                nearest = (index, distance);
            }
        }
        look_into(tree, query, best, nearest.0);
        for (index, bounds) in tree.boxes[0].iter().enumerate() {
            if index != nearest.0 && to_box(query, bounds, best.distance) < best.distance {
                look_into(tree, query, best, index);
            }
        }
    }
}

/// Looks at the frames of one of the largest boxes.
#[inline(always)]
fn look_into(tree: &FeatureTree, query: &Row, best: &mut Best, large: usize) {
    let boxes = |level: usize, within: usize, of: usize| {
        let each = SIZES[of] / SIZES[level];
        within * each..((within + 1) * each).min(tree.boxes[level].len())
    };
    for middle in boxes(1, large, 0) {
        if to_box(query, &tree.boxes[1][middle], best.distance) >= best.distance {
            continue;
        }
        for small in boxes(2, middle, 1) {
            if to_box(query, &tree.boxes[2][small], best.distance) >= best.distance {
                continue;
            }
            let frames = small * SIZES[2]..((small + 1) * SIZES[2]).min(tree.rows.len());
            for place in frames {
                let distance = squared_distance(query, &tree.rows[place]);
                let frame = tree.frames[place] as usize;
                if distance < best.distance && !best.except.contains(&frame) {
                    (best.frame, best.distance) = (frame, distance);
                }
            }
        }
    }
}

/// Lanes that are summed side by side.
const LANES: usize = 8;
/// The first of the numbers that are summed first, those of the trajectory: what they add is more than the limit for
/// almost every box.
const FIRST: usize = 11;

/// The sum of the squares of all differences.
#[inline(always)]
fn squared_distance(a: &Row, b: &Row) -> f32 {
    let mut sums = [0.0; LANES];
    for column in (FIRST..FEATURES).chain(0..FIRST) {
        let difference = a[column] - b[column];
        sums[column % LANES] += difference * difference;
    }
    sum(sums)
}

/// The same to the nearest point of a box, or a part of it that reaches the limit.
#[inline(always)]
fn to_box(query: &Row, [least, most]: &[Row; 2], limit: f32) -> f32 {
    let mut sums = [0.0; LANES];
    let outside = |column: usize| {
        let value = query[column];
        let (below, above) = (least[column] - value, value - most[column]);
        let outside = if below > above { below } else { above };
        if outside > 0.0 { outside } else { 0.0 }
    };
    for column in FIRST..FEATURES {
        let outside = outside(column);
        sums[column % LANES] += outside * outside;
    }
    let part = sum(sums);
    if part >= limit {
        return part;
    }
    for column in 0..FIRST {
        let outside = outside(column);
        sums[column % LANES] += outside * outside;
    }
    sum(sums)
}

#[inline(always)]
fn sum([a, b, c, d, e, f, g, h]: [f32; LANES]) -> f32 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// Puts frames that are near each other together: those below and above the middle of the number in which they are
/// farthest apart, and so on. Where they are divided a box ends.
fn halve(frames: &mut [u32], rows: &[Row]) {
    let Some(size) = SIZES.into_iter().find(|size| frames.len() > *size) else {
        return;
    };
    let [least, most] = bounds(frames.iter().map(|frame| &rows[*frame as usize]));
    let extent = |column: &usize| most[*column] - least[*column];
    let widest = (0..FEATURES)
        .max_by(|a, b| extent(a).total_cmp(&extent(b)))
        .unwrap_or(0);
    let middle = (frames.len() / 2).next_multiple_of(size);
    let value = |frame: &u32| rows[*frame as usize][widest];
    frames.select_nth_unstable_by(middle, |a, b| value(a).total_cmp(&value(b)).then(a.cmp(b)));
    let (below, above) = frames.split_at_mut(middle);
    halve(below, rows);
    halve(above, rows);
}

/// The box around frames.
fn bounds<'a>(rows: impl IntoIterator<Item = &'a Row>) -> [Row; 2] {
    let mut bounds = [[f32::INFINITY; FEATURES], [f32::NEG_INFINITY; FEATURES]];
    for row in rows {
        for column in 0..FEATURES {
            bounds[0][column] = bounds[0][column].min(row[column]);
            bounds[1][column] = bounds[1][column].max(row[column]);
        }
    }
    bounds
}

/// The mean of each number, and the deviation of its group over the weight of the group.
pub(super) fn statistics(rows: &[Row]) -> (Row, Row) {
    let count = rows.len().max(1) as f64;
    let mut sums = [0.0_f64; FEATURES];
    for row in rows {
        for (sum, value) in sums.iter_mut().zip(row) {
            *sum += f64::from(*value);
        }
    }
    let mean = sums.map(|sum| sum / count);
    let mut squares = [0.0_f64; FEATURES];
    for row in rows {
        for ((square, value), mean) in squares.iter_mut().zip(row).zip(&mean) {
            *square += (f64::from(*value) - mean).powi(2);
        }
    }
    let mut scale = [1.0; FEATURES];
    for (group, weight) in GROUPS {
        let deviations = squares[group.clone()].iter().map(|square| (square / count).sqrt());
        let deviation = deviations.sum::<f64>() / group.len() as f64;
        // What never changes tells no frames apart.
        scale[group].fill((deviation as f32).max(1e-6) / weight);
    }
    (mean.map(|mean| mean as f32), scale)
}
