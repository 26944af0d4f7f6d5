//! An exact nearest neighbour search over frames: a tree of boxes around 8, 64, 512, ... frames. The search skips a box
//! if its nearest point is farther than the best frame so far. Among eight boxes, it searches the nearest box first.
//! Holden's demonstration has boxes around consecutive frames. This tree recursively splits the frames in halves, along
//! the feature with the widest spread. So the boxes are small, as in a k-d tree (Friedman, Bentley and Finkel, 1977).
//! Eight frames or eight boxes are stored side by side in memory, and compared at once.
//!
//! Features are normalized: minus the mean, divided by the standard deviation of their group, times a weight. The three
//! coordinates of the position of a foot are one group, for example. Boxes are aligned with the principal axes of all
//! frames (Pearson, 1901; Sproull, 1991, for k-d trees). Many features are correlated, so boxes along the features
//! themselves would be mostly empty. Distances of frames are computed from the features. The distance of a box has a
//! margin for rounding errors, so that the search misses no frame.

use std::ops::Range;

use mocap_scene::math::{principal, wide};

use super::database::Database;
use super::features::FEATURES;

/// The groups of features and their weights, from Holden's demonstration.
const GROUPS: [(Range<usize>, f32); 7] = [
    (0..3, 0.75),
    (3..6, 0.75),
    (6..9, 1.0),
    (9..12, 1.0),
    (12..15, 1.0),
    (15..21, 1.0),
    (21..27, 1.5),
];
/// The number of frames in the smallest boxes, and of boxes in the next larger box.
const FAN: usize = 8;
/// The largest number of levels: 8^11 frames are more than a 32-bit index can count.
const LEVELS: usize = 11;
/// Iterations to find each principal axis. With approximate axes the search is still exact, and the boxes are hardly
/// larger.
const ROUNDS: usize = 50;
/// Frames at the end of a clip that the search never returns: less than a third of a second would remain to play.
const ENDS: usize = 20;

type Row = [f32; FEATURES];

/// One number of eight frames or eight boxes.
type Lanes = [f32; FAN];

/// Up to eight frames. Missing frames are infinitely far away.
type Leaf = [Lanes; FEATURES];

/// Eight boxes, each with its least and its largest coordinate along each axis.
#[derive(Clone, Debug)]
struct Boxes {
    least: Leaf,
    most: Leaf,
}

/// A search tree that finds the frame of a database nearest to a query.
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
    /// The standard deviation of the group of each feature, divided by the weight.
    scale: Row,
    /// The principal axes of the frames, with the largest variance first.
    axes: Box<[[f64; FEATURES]; FEATURES]>,
    /// The distance of the farthest frame from the mean.
    farthest: f32,
    /// The frames that the search can return. The frames of each box are consecutive.
    frames: Vec<u32>,
    /// The features of these frames.
    leaves: Vec<Leaf>,
    /// The boxes around leaves, then the boxes around eight of these boxes, and so on. The last level has at most eight
    /// boxes.
    levels: Vec<Vec<Boxes>>,
}

impl FeatureTree {
    /// Makes a tree of the frames of all clips. The search never returns the last third of a second of a clip.
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

    /// Makes a tree of any frames. The search can return all of them.
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

    /// Normalizes features as the search compares them.
    pub fn normalized(&self, features: &[f32; FEATURES]) -> [f32; FEATURES] {
        std::array::from_fn(|column| (features[column] - self.mean[column]) / self.scale[column])
    }

    /// The squared distance of two normalized rows.
    pub(super) fn distance(&self, a: &[f32; FEATURES], b: &[f32; FEATURES]) -> f32 {
        squared_distance(a, b)
    }

    /// The frame nearest to a normalized query, with its squared distance. The frame is nearer than `limit`, a squared
    /// distance, and outside `except`. If several frames are equally near, any of them is returned.
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

/// The rounding error of the coordinates of two rows along the axes, relative to the lengths of the rows. The error of
/// each coordinate is half a unit in the last place, and the error of the sums of squares is as large.
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
        // For each level: the group of eight boxes that is searched, and the distances of the boxes not yet searched.
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

/// Searches the frames of a leaf.
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

/// The smallest of eight numbers, and its index.
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

/// The number of independent partial sums. With several sums, no addition waits for the previous one.
const SUMS: usize = 4;
/// The number of axes that are summed first. For almost every box, their sum already exceeds the limit.
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

/// The squared distances along the axes from a query to the nearest points of eight boxes. Stops early if the partial
/// sums of all boxes reach the limit.
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

/// The total distances of eight frames or boxes. The partial sums are added in the order of [`squared_distance`], so
/// that the rounding is the same.
#[inline(always)]
fn total([a, b, c, d]: &[Lanes; SUMS]) -> Lanes {
    let mut total = [0.0; FAN];
    for lane in 0..FAN {
        total[lane] = (a[lane] + c[lane]) + (b[lane] + d[lane]);
    }
    total
}

/// Transposes up to eight rows, so that each number of all rows is consecutive.
fn side_by_side<'a>(rows: impl Iterator<Item = &'a Row>) -> Leaf {
    let mut lanes = [[f32::INFINITY; FAN]; FEATURES];
    for (lane, row) in rows.enumerate() {
        for (numbers, value) in lanes.iter_mut().zip(row) {
            numbers[lane] = *value;
        }
    }
    lanes
}

/// Orders frames so that near frames are neighbours. Splits them near the median of the coordinate with the widest
/// spread, and then splits each half. Each split is at a multiple of the box size, so no split divides a box.
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

/// The box around boxes, each given by its least and largest values. For a frame, both are its features.
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

/// The principal axes of rows with mean zero. If the rows span fewer directions, the last axes are zero.
fn axes_of(rows: &[Row]) -> Box<[[f64; FEATURES]; FEATURES]> {
    let products = principal::products(rows.iter().map(|row| row.map(f64::from)), FEATURES);
    let mut axes = Box::new([[0.0; FEATURES]; FEATURES]);
    let found = principal::axes(&products, FEATURES, FEATURES, ROUNDS);
    for (axis, found) in axes.iter_mut().zip(found) {
        axis.copy_from_slice(&found);
    }
    axes
}

/// The coordinates of a row along the axes.
fn along(axes: &[[f64; FEATURES]; FEATURES], row: &Row) -> Row {
    let row = row.map(f64::from);
    std::array::from_fn(|axis| axes[axis].iter().zip(&row).map(|(a, b)| a * b).sum::<f64>() as f32)
}

fn length(row: &Row) -> f32 {
    row.iter().map(|value| value * value).sum::<f32>().sqrt()
}

/// The mean of each number, and the standard deviation of its group divided by the weight of the group.
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
        // A constant feature cannot distinguish frames. Avoid a division by zero.
        scale[group].fill((deviation as f32).max(1e-6) / weight);
    }
    (mean.map(|mean| mean as f32), scale)
}
