//! Which windows cannot be near each other, known without aligning them: lower bounds of their distance.
//!
//! Turning about the vertical and shifting over the ground change neither the height of a point nor, after the means of
//! both clouds are brought together, how far it is from the mean. So the distance is at least that of heights h and
//! radii r alone: D^2 >= sum w ((h - h')^2 + (r - r')^2), for ||p| - |q|| <= |p - R q|. Over the frames of a window
//! each is written in the constant and the linear function that are orthonormal under the weights of the frames; by
//! Bessel's inequality the squares of these two coefficients add up to no more. A window has four numbers for each
//! point, then, whose distance is never above that of the windows. Blocks of windows have boxes around them.

use std::ops::Range;

use glam::DVec2;

use super::clouds::{CloudSpace, Clouds};
use super::distance::Window;
use crate::math::wide;

/// Windows of a block.
pub(super) const BLOCK: usize = 16;
/// Windows, or blocks, that are compared at once; of numbers so many before it is looked whether they are near still.
const LANES: usize = 8;

/// A number of eight windows or of eight blocks.
type Lanes = [f32; LANES];
/// Numbers of a point: the two coefficients of its height and of its radius.
const OF_POINT: usize = 4;
/// What is added to the threshold for the rounding of numbers of 32 bits: a part of it, and metres.
const SLACK: (f32, f32) = (1e-3, 1e-5);

/// The numbers of the windows of a clip, those first that differ most. Where a window or a block is missing at the end,
/// its numbers are infinite.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    width: usize,
    count: usize,
    /// Eight windows side by side: their first numbers, their second ones, and so on.
    windows: Vec<Lanes>,
    /// Eight blocks side by side: the least and the largest of each number.
    boxes: Vec<[Lanes; 2]>,
}

/// Some windows of a clip and of another one, or of the same.
pub(super) type Rectangle = [Range<usize>; 2];

impl Bounds {
    /// Those of all clips.
    pub(super) fn of(space: &CloudSpace, window: &Window, clips: &[Clouds]) -> Vec<Self> {
        let all: Vec<Vec<f32>> = crate::math::spread::spread(clips, |clip| numbers(space, window, clip));
        let order = order(&all, space.weights.len() * OF_POINT);
        all.into_iter().map(|numbers| Self::sorted(&numbers, &order)).collect()
    }

    /// Rows of numbers, in another order of columns, side by side.
    fn sorted(numbers: &[f32], order: &[usize]) -> Self {
        let (width, count) = (order.len().next_multiple_of(LANES), numbers.len() / order.len());
        let value = |window: usize, column: usize| match order.get(column) {
            Some(column) => numbers[window * order.len() + column],
            None => 0.0,
        };
        let side_by_side = |group: usize, column: usize| -> Lanes {
            std::array::from_fn(|lane| match group * LANES + lane {
                window if window < count => value(window, column),
                _ => f32::INFINITY,
            })
        };
        let around = |block: usize, column: usize| {
            let windows = block * BLOCK..((block + 1) * BLOCK).min(count);
            windows.fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], window| {
                let value = value(window, column);
                [least.min(value), most.max(value)]
            })
        };
        let boxes = |group: usize, column: usize| -> [Lanes; 2] {
            let mut lanes = [[f32::INFINITY; LANES]; 2];
            let blocks = group * LANES..((group + 1) * LANES).min(count.div_ceil(BLOCK));
            for (lane, block) in blocks.enumerate() {
                [lanes[0][lane], lanes[1][lane]] = around(block, column);
            }
            lanes
        };
        let columns = |groups: usize| (0..groups).flat_map(move |group| (0..width).map(move |column| (group, column)));
        let blocks = count.div_ceil(BLOCK);
        Self {
            width,
            count,
            windows: columns(count.div_ceil(LANES))
                .map(|(group, column)| side_by_side(group, column))
                .collect(),
            boxes: columns(blocks.div_ceil(LANES))
                .map(|(group, column)| boxes(group, column))
                .collect(),
        }
    }

    /// The windows of a block, and of another clip those that may be within `threshold` metres of one of these: of each
    /// block there a rectangle around all such pairs. With `apart`, both are of one clip, and the second window begins
    /// so many frames after the first at least.
    pub(super) fn near(&self, block: usize, other: &Self, threshold: f32, apart: Option<usize>) -> Vec<Rectangle> {
        let limit = (threshold * (1.0 + SLACK.0) + SLACK.1).powi(2);
        let first = block * BLOCK;
        let least = apart.map_or(0, |apart| first + apart);
        let own = &self.boxes[block / LANES * self.width..][..self.width];
        let mut found = Vec::new();
        for group in least / BLOCK / LANES..other.boxes.len() / other.width.max(1) {
            let boxes = &other.boxes[group * other.width..][..other.width];
            let distances = box_distances(own, block % LANES, boxes, limit);
            for (lane, distance) in distances.into_iter().enumerate() {
                let second = (group * LANES + lane) * BLOCK;
                if distance <= limit && second + BLOCK > least {
                    let near = near_windows((self, first), (other, second), limit, apart);
                    found.extend(near);
                }
            }
        }
        found
    }
}

/// The numbers of each window of a clip, point by point.
fn numbers(space: &CloudSpace, window: &Window, clip: &Clouds) -> Vec<f32> {
    let taper = window.taper();
    let middle: f64 = (0..).zip(taper).map(|(frame, weight)| f64::from(frame) * weight).sum();
    let spread: f64 = (0..)
        .zip(taper)
        .map(|(frame, weight)| (f64::from(frame) - middle).powi(2) * weight)
        .sum();
    // A window has two frames at least, so that the deviation is above 0.
    let linear: Vec<f64> = (0..taper.len())
        .map(|frame| (frame as f64 - middle) / spread.sqrt())
        .collect();
    let mut numbers = Vec::with_capacity(window.count(clip) * space.weights.len() * OF_POINT);
    for start in 0..window.count(clip) {
        let centres = &clip.centres[start..start + taper.len()];
        let centre = centres
            .iter()
            .zip(taper)
            .fold(DVec2::ZERO, |sum, (centre, taper)| sum + *taper * *centre);
        for (point, weight) in space.weights.iter().enumerate() {
            let from = point * clip.frames + start;
            let of = |axis: usize| &clip.values[axis][from..from + taper.len()];
            let (across, along, up) = (of(0), of(1), of(2));
            let mut sums = [0.0_f64; OF_POINT];
            for (frame, taper) in taper.iter().enumerate() {
                let height = f64::from(up[frame]);
                let radius = DVec2::new(across[frame].into(), along[frame].into()).distance(centre);
                let of_frame = [height, linear[frame] * height, radius, linear[frame] * radius];
                for (sum, value) in sums.iter_mut().zip(of_frame) {
                    *sum += taper * value;
                }
            }
            numbers.extend(sums.map(|sum| (weight.sqrt() * sum) as f32));
        }
    }
    numbers
}

/// The columns, those first whose variance over all windows is largest.
fn order(all: &[Vec<f32>], width: usize) -> Vec<usize> {
    let mut sums = vec![(0.0_f64, 0.0_f64); width];
    let mut count = 0.0;
    for row in all.iter().flat_map(|rows| rows.chunks_exact(width)) {
        count += 1.0;
        for ((sum, square), value) in sums.iter_mut().zip(row) {
            *sum += f64::from(*value);
            *square += f64::from(*value).powi(2);
        }
    }
    let variance = |column: usize| sums[column].1 - sums[column].0 * sums[column].0 / f64::max(count, 1.0);
    let mut order: Vec<usize> = (0..width).collect();
    order.sort_by(|a, b| variance(*b).total_cmp(&variance(*a)));
    order
}

wide::dispatch! {
    /// How far a block is from eight others, squared, or a part of that where it is more than `limit` for all.
    fn box_distances(own: &[[Lanes; 2]], lane: usize, others: &[[Lanes; 2]], limit: f32) -> Lanes {
        let mut sums = [0.0; LANES];
        for start in (0..own.len().min(others.len())).step_by(LANES) {
            for column in start..start + LANES {
                let (least, most) = (own[column][0][lane], own[column][1][lane]);
                let [other_least, other_most] = &others[column];
                for place in 0..LANES {
                    let (below, above) = (least - other_most[place], other_least[place] - most);
                    let apart = if below > above { below } else { above };
                    let apart = if apart > 0.0 { apart } else { 0.0 };
                    sums[place] += apart * apart;
                }
            }
            if are_all_above(&sums, limit) {
                break;
            }
        }
        sums
    }
}

wide::dispatch! {
    /// The rectangle around the pairs of windows of two blocks that are within the root of `limit`.
    fn near_windows(
        own: (&Bounds, usize),
        other: (&Bounds, usize),
        limit: f32,
        apart: Option<usize>,
    ) -> Option<Rectangle> {
        let ((own, first), (other, second)) = (own, other);
        let width = own.width;
        let mut near: Option<Rectangle> = None;
        for row in first..(first + BLOCK).min(own.count) {
            let (lane, numbers) = (row % LANES, &own.windows[row / LANES * width..]);
            for column in (second..(second + BLOCK).min(other.count)).step_by(LANES) {
                let others = &other.windows[column / LANES * width..];
                let mut sums = [0.0; LANES];
                for start in (0..width).step_by(LANES) {
                    for place in start..start + LANES {
                        let number = numbers[place][lane];
                        for (sum, other) in sums.iter_mut().zip(&others[place]) {
                            let apart = number - other;
                            *sum += apart * apart;
                        }
                    }
                    if are_all_above(&sums, limit) {
                        break;
                    }
                }
                for (place, sum) in sums.into_iter().enumerate() {
                    let column = column + place;
                    if sum <= limit && apart.is_none_or(|apart| column >= row + apart) {
                        near = Some(match near {
                            None => [row..row + 1, column..column + 1],
                            Some([rows, columns]) => [
                                rows.start..row + 1,
                                columns.start.min(column)..columns.end.max(column + 1),
                            ],
                        });
                    }
                }
            }
        }
        near
    }
}

/// Whether eight numbers are above a limit.
#[inline(always)]
fn are_all_above(numbers: &Lanes, limit: f32) -> bool {
    let mut are = true;
    for number in numbers {
        are &= *number > limit;
    }
    are
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Figure;

    /// A bound above the distance would lose transitions.
    #[test]
    fn no_distance_is_below_its_bound() {
        let mut nearest = f32::INFINITY;
        for file in ["cmu_12_01_walk.bvh", "cmu_short.bvh", "kinect_openni.bvh"] {
            let scene = crate::import(format!("fixtures/real/{file}")).unwrap();
            let space = CloudSpace::new(&scene, &Figure::new(&scene)).unwrap();
            let clip = Clouds::new(&space, &scene, &scene.animations[0], 30.0).unwrap();
            let window = Window::new(10);
            let count = window.count(&clip);
            let exact = window.distances(&space, (&clip, 0..count), (&clip, 0..count));
            let bounds = Bounds::of(&space, &window, std::slice::from_ref(&clip)).remove(0);
            let row = |window: usize| {
                let numbers = &bounds.windows[window / LANES * bounds.width..][..bounds.width];
                numbers.iter().map(move |lanes| lanes[window % LANES])
            };
            for (cell, exact) in exact.iter().enumerate() {
                let bound = row(cell / count)
                    .zip(row(cell % count))
                    .map(|(a, b)| (a - b) * (a - b))
                    .sum::<f32>()
                    .sqrt();
                assert!(
                    bound <= exact * (1.0 + SLACK.0) + SLACK.1,
                    "{file} {cell}: {bound} {exact}"
                );
                if *exact > 0.05 {
                    nearest = nearest.min(exact / bound);
                }
            }
        }
        // It is of use: somewhere it is not far below.
        assert!(nearest < 1.5, "{nearest}");
    }
}
