//! Which windows cannot be near each other, known without aligning them: lower bounds of their distance.
//!
//! Turning about the vertical and shifting over the ground change neither the height of a point nor, after the means of
//! both clouds are brought together, how far it is from the mean. So the distance is at least that of heights h and
//! radii r alone: D^2 >= sum w ((h - h')^2 + (r - r')^2), for ||p| - |q|| <= |p - R q|. Over the frames of a window
//! each is written in the constant and the linear function that are orthonormal under the weights of the frames; by
//! Bessel's inequality the squares of these two coefficients add up to no more. A window has four numbers for each
//! point, then, whose distance is never above that of the windows. Blocks of windows have boxes around them.

use glam::DVec2;

use super::clouds::{CloudSpace, Clouds};
use super::distance::Window;
use crate::math::wide;

/// Windows of a block.
pub(super) const BLOCK: usize = 16;
/// Numbers that are compared at once.
const LANES: usize = 8;
/// Numbers of a point: the two coefficients of its height and of its radius.
const OF_POINT: usize = 4;
/// What is added to the threshold for the rounding of numbers of 32 bits: a part of it, and metres.
const SLACK: (f32, f32) = (1e-3, 1e-5);

/// The numbers of the windows of a clip, those first that differ most.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    width: usize,
    rows: Vec<f32>,
    /// Of each block the least and then the largest numbers.
    boxes: Vec<f32>,
}

impl Bounds {
    /// Those of all clips.
    pub(super) fn of(space: &CloudSpace, window: &Window, clips: &[Clouds]) -> Vec<Self> {
        let all: Vec<Vec<f32>> = crate::math::spread::spread(clips, |clip| numbers(space, window, clip));
        let order = order(&all, space.weights.len() * OF_POINT);
        let width = order.len().next_multiple_of(LANES);
        let sorted = |numbers: Vec<f32>| {
            let mut rows = Vec::with_capacity(numbers.len() / order.len() * width);
            for row in numbers.chunks_exact(order.len()) {
                rows.extend(order.iter().map(|column| row[*column]));
                rows.resize(rows.len().next_multiple_of(width), 0.0);
            }
            let boxes = rows.chunks(BLOCK * width).flat_map(|block| box_around(block, width));
            Self {
                width,
                boxes: boxes.collect(),
                rows,
            }
        };
        all.into_iter().map(sorted).collect()
    }

    /// Whether a window of one block may be within `threshold` metres of one of a block of another clip.
    pub(super) fn may_be_near(&self, block: usize, other: &Self, other_block: usize, threshold: f32) -> bool {
        let limit = (threshold * (1.0 + SLACK.0) + SLACK.1).powi(2);
        let around = |bounds: &'_ Self, block: usize| 2 * block * bounds.width..2 * (block + 1) * bounds.width;
        let (own, others) = (
            &self.boxes[around(self, block)],
            &other.boxes[around(other, other_block)],
        );
        if !are_boxes_near(own, others, limit) {
            return false;
        }
        let rows = |bounds: &'_ Self, block: usize| {
            let start = block * BLOCK * bounds.width;
            start..(start + BLOCK * bounds.width).min(bounds.rows.len())
        };
        let (own, others) = (&self.rows[rows(self, block)], &other.rows[rows(other, other_block)]);
        is_any_near(own, others, self.width, limit)
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

/// The least and the largest numbers of some rows.
fn box_around(rows: &[f32], width: usize) -> Vec<f32> {
    let mut around = vec![f32::INFINITY; width];
    around.resize(2 * width, f32::NEG_INFINITY);
    let (least, most) = around.split_at_mut(width);
    for row in rows.chunks_exact(width) {
        for ((value, least), most) in row.iter().zip(&mut *least).zip(&mut *most) {
            *least = least.min(*value);
            *most = most.max(*value);
        }
    }
    around
}

wide::dispatch! {
    /// Whether two boxes are within the root of `limit`.
    fn are_boxes_near(a: &[f32], b: &[f32], limit: f32) -> bool {
        let width = a.len() / 2;
        let mut sum = 0.0;
        for start in (0..width).step_by(LANES) {
            let mut lanes = [0.0; LANES];
            for (lane, sum) in lanes.iter_mut().enumerate() {
                let column = start + lane;
                let (below, above) = (a[column] - b[width + column], b[column] - a[width + column]);
                let apart = if below > above { below } else { above };
                let apart = if apart > 0.0 { apart } else { 0.0 };
                *sum = apart * apart;
            }
            sum += lanes.iter().sum::<f32>();
            if sum > limit {
                return false;
            }
        }
        true
    }
}

wide::dispatch! {
    /// Whether any two rows are within the root of `limit`.
    fn is_any_near(a: &[f32], b: &[f32], width: usize, limit: f32) -> bool {
        for row in a.chunks_exact(width) {
            for other in b.chunks_exact(width) {
                let mut sum = 0.0;
                for (row, other) in row.chunks_exact(LANES).zip(other.chunks_exact(LANES)) {
                    let mut lanes = [0.0; LANES];
                    for (lane, sum) in lanes.iter_mut().enumerate() {
                        let apart = row[lane] - other[lane];
                        *sum = apart * apart;
                    }
                    sum += lanes.iter().sum::<f32>();
                    if sum > limit {
                        break;
                    }
                }
                if sum <= limit {
                    return true;
                }
            }
        }
        false
    }
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
            let rows: Vec<&[f32]> = bounds.rows.chunks_exact(bounds.width).collect();
            for (cell, exact) in exact.iter().enumerate() {
                let (row, other) = (rows[cell / count], rows[cell % count]);
                let bound = row
                    .iter()
                    .zip(other)
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
