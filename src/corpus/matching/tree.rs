//! The frame nearest to a query, exactly: a tree of boxes around 8, 64, 512, ... frames. A box is left out where its
//! nearest point is farther than the best frame so far; of eight boxes the nearest is looked into first. Holden's
//! demonstration has boxes around consecutive frames. Here the frames are split in halves along the feature with the
//! widest spread, and the halves again. Boxes are then small, as in a k-d tree (Friedman, Bentley and Finkel, 1977).
//! Eight frames, or boxes, stand side by side in memory, and are compared at once.
//!
//! Features are compared less their mean, over the deviation of their group (the positions of a foot are one), times a
//! weight. Boxes stand along the principal axes of all frames (Pearson, 1901; Sproull, 1991, for k-d trees). Many
//! features are nearly equal, so boxes along the features themselves are mostly empty. Distances of frames are those of
//! the features; a box counts as nearer by what rounding can do, so it leaves no frame out.

use std::ops::Range;

use mocap_scene::math::{principal, wide};

use super::database::Database;
use super::features::FEATURES;

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
/// Frames of the smallest boxes, and boxes of the next larger one.
const FAN: usize = 8;
/// Levels of boxes at most: of 8^11 frames, more than 32 bits count.
const LEVELS: usize = 11;
/// Rounds in which each principal axis is sought. Axes that are not quite the principal ones are as right, and boxes
/// hardly larger.
const ROUNDS: usize = 50;
/// Frames at the end of a clip that are not found: after them there is a third of a second at most.
const ENDS: usize = 20;

type Row = [f32; FEATURES];

/// A number of eight frames, or of eight boxes.
type Lanes = [f32; FAN];

/// Eight frames, or as many as there are: what is missing is infinitely far.
type Leaf = [Lanes; FEATURES];

/// Eight boxes: their least and their largest values.
#[derive(Clone, Debug)]
struct Boxes {
    least: Leaf,
    most: Leaf,
}

/// The frames of a database, to find the one nearest to a query.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
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
    /// The principal axes of the frames, that of the largest variance first.
    axes: Box<[[f64; FEATURES]; FEATURES]>,
    /// How far the farthest frame is from the mean.
    farthest: f32,
    /// The frames that can be found, ordered so that the frames of a box are together.
    frames: Vec<u32>,
    /// Their features.
    leaves: Vec<Leaf>,
    /// The boxes around leaves, then those around eight of these, and so on until there are eight at most.
    levels: Vec<Vec<Boxes>>,
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
        let axes = axes_of(&rows);
        let turned: Vec<Row> = rows.iter().map(|row| along(&axes, row)).collect();
        halve(&mut frames, &turned);
        let row = |frame: &u32| &rows[*frame as usize];
        let leaves = frames.chunks(FAN).map(|frames| side_by_side(frames.iter().map(row)));
        let leaves = leaves.collect();
        let turned = |frame: &u32| [&turned[*frame as usize]; 2];
        let mut around: Vec<[Row; 2]> = frames
            .chunks(FAN)
            .map(|frames| bounds(frames.iter().map(turned)))
            .collect();
        let mut levels = Vec::new();
        while !around.is_empty() {
            let boxes = around.chunks(FAN).map(|boxes| Boxes {
                least: side_by_side(boxes.iter().map(|[least, _]| least)),
                most: side_by_side(boxes.iter().map(|[_, most]| most)),
            });
            levels.push(boxes.collect());
            if around.len() <= FAN {
                break;
            }
            let larger = around
                .chunks(FAN)
                .map(|boxes| bounds(boxes.iter().map(|[least, most]| [least, most])));
            around = larger.collect();
        }
        Self {
            farthest: rows.iter().map(length).fold(0.0, f32::max),
            mean,
            scale,
            axes,
            frames,
            leaves,
            levels,
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
            rounding: ROUNDING * (length(query) + self.farthest),
            limit: 0.0,
        };
        best.set(usize::MAX, limit);
        search(self, query, &along(&self.axes, query), &mut best);
        (best.frame != usize::MAX).then_some((best.frame, best.distance))
    }
}

/// The rounding error of the numbers along the axes, of two rows, as a fraction of their lengths. It is half a unit in
/// the last place of each, and as much again for the sums of squares.
const ROUNDING: f32 = 2.0 * f32::EPSILON;

struct Best {
    frame: usize,
    distance: f32,
    except: Range<usize>,
    rounding: f32,
    /// The limit for the squared distance of a box: the distance of the best frame, with a margin for rounding.
    limit: f32,
}

impl Best {
    fn set(&mut self, frame: usize, distance: f32) {
        let limit = distance.sqrt() * (1.0 + 2.0 * FEATURES as f32 * f32::EPSILON) + self.rounding;
        (self.frame, self.distance, self.limit) = (frame, distance, limit * limit);
    }
}

wide::dispatch! {
    fn search(tree: &FeatureTree, query: &Row, turned: &Row, best: &mut Best) {
        let Some(top) = tree.levels.len().checked_sub(1) else { return };
        // Of each level the eight boxes that are looked into, and how far those are that were not yet.
        let mut open = [(0, [f32::INFINITY; FAN]); LEVELS];
        open[top] = (0, to_boxes(turned, &tree.levels[top][0], best.limit));
        let mut level = top;
        loop {
            let (place, distances) = &mut open[level];
            let (lane, distance) = least(distances);
            if distance >= best.limit {
                if level == top {
                    return;
                }
                level += 1;
                continue;
            }
            distances[lane] = f32::INFINITY;
            let within = *place * FAN + lane;
            match level {
                0 => look_into(tree, query, best, within),
                _ => {
                    level -= 1;
                    open[level] = (within, to_boxes(turned, &tree.levels[level][within], best.limit));
                }
            }
        }
    }
}

/// Looks at the frames of a leaf.
#[inline(always)]
fn look_into(tree: &FeatureTree, query: &Row, best: &mut Best, leaf: usize) {
    let distances = to_frames(query, &tree.leaves[leaf]);
    for (lane, distance) in distances.into_iter().enumerate() {
        if distance < best.distance {
            let frame = tree.frames[leaf * FAN + lane] as usize;
            if !best.except.contains(&frame) {
                best.set(frame, distance);
            }
        }
    }
}

/// The smallest of eight numbers, and which it is.
#[inline(always)]
fn least(numbers: &Lanes) -> (usize, f32) {
    let mut least = (0, numbers[0]);
    for (lane, number) in numbers.iter().enumerate() {
        if *number < least.1 {
            least = (lane, *number);
        }
    }
    least
}

/// Sums that are made side by side, so that none waits for the one before.
const SUMS: usize = 4;
/// The axes that are summed first: what they add is more than the limit for almost every box.
const FIRST: usize = 8;

/// The sum of the squares of all differences.
fn squared_distance(a: &Row, b: &Row) -> f32 {
    let mut sums = [0.0; SUMS];
    for column in 0..FEATURES {
        let difference = a[column] - b[column];
        sums[column % SUMS] += difference * difference;
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// The squared distances from a query to the eight frames of a leaf.
#[inline(always)]
fn to_frames(query: &Row, frames: &Leaf) -> Lanes {
    let mut sums = [[0.0; FAN]; SUMS];
    for column in 0..FEATURES {
        add(&mut sums[column % SUMS], query[column], &frames[column]);
    }
    total(&sums)
}

#[inline(always)]
fn add(sum: &mut Lanes, value: f32, others: &Lanes) {
    for (sum, other) in sum.iter_mut().zip(others) {
        let difference = value - other;
        *sum += difference * difference;
    }
}

/// The squared distances from a query to the nearest points of eight boxes, along the axes. Stops at a part of each sum
/// where that part reaches the limit for all boxes.
#[inline(always)]
fn to_boxes(query: &Row, boxes: &Boxes, limit: f32) -> Lanes {
    let mut sums = [[0.0; FAN]; SUMS];
    for column in 0..FIRST {
        add_outside(&mut sums[column % SUMS], query[column], boxes, column);
    }
    let part = total(&sums);
    if least(&part).1 >= limit {
        return part;
    }
    for column in FIRST..FEATURES {
        add_outside(&mut sums[column % SUMS], query[column], boxes, column);
    }
    total(&sums)
}

#[inline(always)]
fn add_outside(sum: &mut Lanes, value: f32, boxes: &Boxes, column: usize) {
    let (least, most) = (&boxes.least[column], &boxes.most[column]);
    for lane in 0..FAN {
        let (below, above) = (least[lane] - value, value - most[lane]);
        let outside = if below > above { below } else { above };
        let outside = if outside > 0.0 { outside } else { 0.0 };
        sum[lane] += outside * outside;
    }
}

/// The sums of eight frames or boxes, in the order of [`squared_distance`].
#[inline(always)]
fn total([a, b, c, d]: &[Lanes; SUMS]) -> Lanes {
    let mut total = [0.0; FAN];
    for lane in 0..FAN {
        total[lane] = (a[lane] + c[lane]) + (b[lane] + d[lane]);
    }
    total
}

/// Up to eight rows, number by number.
fn side_by_side<'a>(rows: impl Iterator<Item = &'a Row>) -> Leaf {
    let mut lanes = [[f32::INFINITY; FAN]; FEATURES];
    for (lane, row) in rows.enumerate() {
        for (numbers, value) in lanes.iter_mut().zip(row) {
            numbers[lane] = *value;
        }
    }
    lanes
}

/// Puts frames that are near each other together: those below and above the middle of the number in which they are
/// farthest apart, and so on. Where they are divided a box ends.
fn halve(frames: &mut [u32], rows: &[Row]) {
    if frames.len() <= FAN {
        return;
    }
    let [least, most] = bounds(frames.iter().map(|frame| [&rows[*frame as usize]; 2]));
    let extent = |column: &usize| most[*column] - least[*column];
    let widest = (0..FEATURES)
        .max_by(|a, b| extent(a).total_cmp(&extent(b)))
        .unwrap_or(0);
    let size = std::iter::successors(Some(FAN), |size| size.checked_mul(FAN));
    let size = size.take_while(|size| *size < frames.len()).last().unwrap_or(FAN);
    let middle = (frames.len() / 2).next_multiple_of(size);
    let value = |frame: &u32| rows[*frame as usize][widest];
    frames.select_nth_unstable_by(middle, |a, b| value(a).total_cmp(&value(b)).then(a.cmp(b)));
    let (below, above) = frames.split_at_mut(middle);
    halve(below, rows);
    halve(above, rows);
}

/// The box around boxes: of each its least and its largest values, which are the same of a frame.
fn bounds<'a>(boxes: impl Iterator<Item = [&'a Row; 2]>) -> [Row; 2] {
    let mut bounds = [[f32::INFINITY; FEATURES], [f32::NEG_INFINITY; FEATURES]];
    for [least, most] in boxes {
        for column in 0..FEATURES {
            bounds[0][column] = bounds[0][column].min(least[column]);
            bounds[1][column] = bounds[1][column].max(most[column]);
        }
    }
    bounds
}

/// The principal axes of rows whose mean is zero. Where rows do not differ in so many directions the last are zero.
fn axes_of(rows: &[Row]) -> Box<[[f64; FEATURES]; FEATURES]> {
    let products = principal::products(rows.iter().map(|row| row.map(f64::from)), FEATURES);
    let mut axes = Box::new([[0.0; FEATURES]; FEATURES]);
    let found = principal::axes(&products, FEATURES, FEATURES, ROUNDS);
    for (axis, found) in axes.iter_mut().zip(found) {
        axis.copy_from_slice(&found);
    }
    axes
}

/// A row along the axes.
fn along(axes: &[[f64; FEATURES]; FEATURES], row: &Row) -> Row {
    let row = row.map(f64::from);
    std::array::from_fn(|axis| axes[axis].iter().zip(&row).map(|(a, b)| a * b).sum::<f64>() as f32)
}

fn length(row: &Row) -> f32 {
    row.iter().map(|value| value * value).sum::<f32>().sqrt()
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
