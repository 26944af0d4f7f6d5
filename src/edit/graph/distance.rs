//! Computes the distance of two windows, as Kovar, Gleicher and Pighin define it in "Motion Graphs" (2002), section
//! 3.1.
//!
//! A window is a short run of frames, with the point cloud of all joints in each frame. One of the two windows is
//! rotated about the vertical and shifted over the ground. A formula gives the rotation and the shift with the smallest
//! weighted sum of squared distances between points. The sum of the weights is 1, so the square root of the sum is the
//! root mean square distance of the points, in metres. Frames near the edges of a window have smaller weights.
//!
//! For all pairs of windows of two clips, the sums over the points are computed once for each pair of frames. A window
//! then adds the sums along a diagonal. Numbers have 64 bits and are relative to the position of the figure, so that
//! small differences of large sums stay precise.

use std::ops::Range;

use glam::DVec2;
use mocap_scene::math::wide;

use super::clouds::{CloudSpace, Clouds};

/// The rigid motion over the ground that aligns one window with another: an angle, and an offset in metres along the
/// two axes of the ground. Also the distance that remains.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alignment {
    /// The angle about the vertical, in radians, counterclockwise as seen from above.
    pub(crate) turn: f64,
    pub(crate) offset: DVec2,
    /// The remaining distance, in metres.
    pub(crate) distance: f64,
}

impl Alignment {
    pub(crate) const NONE: Self = Self {
        turn: 0.0,
        offset: DVec2::ZERO,
        distance: 0.0,
    };

    pub(crate) fn apply(&self, point: DVec2) -> DVec2 {
        DVec2::from_angle(self.turn).rotate(point) + self.offset
    }

    /// The alignment that applies `other` first, and then this one.
    pub(crate) fn after(&self, other: &Self) -> Self {
        Self {
            turn: self.turn + other.turn,
            offset: self.apply(other.offset),
            distance: other.distance,
        }
    }
}

/// The weight of each frame of a window. The sum of the weights is 1.
#[derive(Clone, Debug)]
pub struct Window {
    taper: Vec<f64>,
}

/// Sums for each window of a tile.
struct Moments {
    /// The weighted mean of the points over the ground.
    centre: Vec<DVec2>,
    /// The weighted mean of the squared distances of the points from the centre of their window at height 0.
    square: Vec<f64>,
}

impl Window {
    /// The weights for a window of `frames` frames. They decrease linearly from the middle to the edges.
    pub fn new(frames: usize) -> Self {
        let rise = |frame: usize| (frame + 1).min(frames - frame) as f64;
        let whole: f64 = (0..frames).map(rise).sum();
        Self {
            taper: (0..frames).map(|frame| rise(frame) / whole).collect(),
        }
    }

    pub(crate) fn frames(&self) -> usize {
        self.taper.len()
    }

    /// The weight of each frame.
    pub(crate) fn taper(&self) -> &[f64] {
        &self.taper
    }

    /// The number of windows of a clip. A window begins at each frame that has enough frames after it.
    pub fn count(&self, clouds: &Clouds) -> usize {
        (clouds.frames + 1).saturating_sub(self.frames())
    }

    /// The alignment of a window of `b` with a window of `a`. The window of `a` begins at the frame `first`, the window
    /// of `b` at the frame `second`.
    pub(crate) fn align(
        &self,
        space: &CloudSpace,
        (a, first): (&Clouds, usize),
        (b, second): (&Clouds, usize),
    ) -> Alignment {
        let [mut mean_a, mut mean_b] = [DVec2::ZERO; 2];
        let each = |sum: &mut dyn FnMut(f64, DVec2, DVec2, f64)| {
            for (frame, taper) in self.taper.iter().enumerate() {
                for (point, weight) in space.weights.iter().enumerate() {
                    let at = |clouds: &Clouds, start: usize| {
                        let index = point * clouds.frames + start + frame;
                        [0, 1, 2].map(|axis| f64::from(clouds.values[axis][index]))
                    };
                    let ([u, v, h], [x, y, z]) = (at(a, first), at(b, second));
                    sum(taper * weight, DVec2::new(u, v), DVec2::new(x, y), h - z);
                }
            }
        };
        each(&mut |weight, p, q, _| {
            mean_a += weight * p;
            mean_b += weight * q;
        });
        let (mut dot, mut cross, mut rest) = (0.0, 0.0, 0.0);
        each(&mut |weight, p, q, height| {
            let (p, q) = (p - mean_a, q - mean_b);
            dot += weight * p.dot(q);
            cross += weight * q.perp_dot(p);
            rest += weight * (p.length_squared() + q.length_squared() + height * height);
        });
        let turn = cross.atan2(dot);
        Alignment {
            turn,
            offset: mean_a - DVec2::from_angle(turn).rotate(mean_b),
            distance: (rest - 2.0 * dot.hypot(cross)).max(0.0).sqrt(),
        }
    }

    /// The distances between the windows of `a` that begin at `rows` and the windows of `b` that begin at `columns`,
    /// row by row.
    pub fn distances(
        &self,
        space: &CloudSpace,
        (a, rows): (&Clouds, Range<usize>),
        (b, columns): (&Clouds, Range<usize>),
    ) -> Vec<f32> {
        let (height, width) = (rows.len(), columns.len());
        let first = Tile::new(a, rows.start, height + self.frames() - 1);
        let second = Tile::new(b, columns.start, width + self.frames() - 1);
        let mut sums = [0; 3].map(|_| vec![0.0; first.frames * second.frames]);
        products(
            &first.weighted(&space.weights),
            &second.side_by_side(),
            second.frames,
            &mut sums,
        );
        let (own, other) = (self.moments(space, &first), self.moments(space, &second));
        let mut distances = Vec::with_capacity(height * width);
        let mut of_row = [0; 3].map(|_| vec![0.0; width]);
        for row in 0..height {
            for (sums, of_row) in sums.iter().zip(&mut of_row) {
                of_row.fill(0.0);
                for (frame, taper) in self.taper.iter().enumerate() {
                    let start = (row + frame) * second.frames + frame;
                    add(of_row, *taper, &sums[start..start + width]);
                }
            }
            let (centre, square) = (own.centre[row], own.square[row]);
            distances.extend((0..width).map(|column| {
                let towards = other.centre[column];
                let dot = of_row[0][column] - centre.dot(towards);
                let cross = of_row[1][column] - towards.perp_dot(centre);
                let rest = square + other.square[column] - 2.0 * of_row[2][column];
                (rest - 2.0 * dot.hypot(cross)).max(0.0).sqrt() as f32
            }));
        }
        distances
    }

    fn moments(&self, space: &CloudSpace, tile: &Tile) -> Moments {
        let of_frame = |points: &[[f64; 3]]| {
            let weighted = space.weights.iter().zip(points);
            weighted.fold((DVec2::ZERO, 0.0), |(centre, square), (weight, [u, v, h])| {
                let of_point = u.powi(2) + v.powi(2) + h.powi(2);
                (centre + *weight * DVec2::new(*u, *v), square + weight * of_point)
            })
        };
        let of_frames: Vec<(DVec2, f64)> = tile.values.chunks_exact(space.weights.len()).map(of_frame).collect();
        let windows = of_frames.windows(self.frames());
        let sums = windows.map(|window| {
            let each = window.iter().zip(&self.taper);
            each.fold((DVec2::ZERO, 0.0), |(centre, square), (of_frame, taper)| {
                (centre + *taper * of_frame.0, square + taper * of_frame.1)
            })
        });
        let (centre, square): (Vec<DVec2>, Vec<f64>) = sums.unzip();
        let square = std::iter::zip(&centre, square).map(|(centre, square)| square - centre.length_squared());
        Moments {
            square: square.collect(),
            centre,
        }
    }
}

/// The number of frames of the second tile that are multiplied at once.
const LANES: usize = 8;

/// A point of the second tile in [`LANES`] frames: its two coordinates over the ground and its height.
type Lanes = [[f64; LANES]; 3];

/// The points of some frames, relative to the centre of the first of these frames.
struct Tile {
    frames: usize,
    /// For each frame, the two coordinates over the ground and the height of each point.
    values: Vec<[f64; 3]>,
}

impl Tile {
    fn new(clouds: &Clouds, start: usize, frames: usize) -> Self {
        let centre = clouds.centres[start];
        let points = clouds.values[0].len() / clouds.frames;
        let mut values = vec![[0.0; 3]; frames * points];
        for (axis, origin) in [centre.x, centre.y, 0.0].into_iter().enumerate() {
            for (point, all) in clouds.values[axis].chunks_exact(clouds.frames).enumerate() {
                for (frame, value) in all[start..start + frames].iter().enumerate() {
                    values[frame * points + point][axis] = f64::from(*value) - origin;
                }
            }
        }
        Self { frames, values }
    }

    /// Each point multiplied by its weight, frame by frame.
    fn weighted(&self, weights: &[f64]) -> Vec<Vec<[f64; 3]>> {
        let of_frame = |points: &[[f64; 3]]| {
            let weighted = points.iter().zip(weights);
            weighted
                .map(|(point, weight)| point.map(|value| weight * value))
                .collect()
        };
        self.values.chunks_exact(weights.len()).map(of_frame).collect()
    }

    /// The points in groups of [`LANES`] frames. Missing frames at the end are 0.
    fn side_by_side(&self) -> Vec<Vec<Lanes>> {
        let points = self.values.len() / self.frames;
        let of_frames = |frames: &[[f64; 3]]| {
            let mut lanes = vec![[[0.0; LANES]; 3]; points];
            for (lane, frame) in frames.chunks_exact(points).enumerate() {
                for (lanes, point) in lanes.iter_mut().zip(frame) {
                    (0..3).for_each(|axis| lanes[axis][lane] = point[axis]);
                }
            }
            lanes
        };
        self.values.chunks(LANES * points).map(of_frames).collect()
    }
}

wide::dispatch! {
    /// Three sums over the points for each pair of frames. They add up dot products over the ground, cross products
    /// over the ground (second point with first point), and products of the heights.
    fn products(first: &[Vec<[f64; 3]>], second: &[Vec<Lanes>], width: usize, sums: &mut [Vec<f64>; 3]) {
        for (frame, points) in first.iter().enumerate() {
            for (group, others) in second.iter().enumerate() {
                let mut own = [[0.0; LANES]; 3];
                for ([u, v, h], [x, y, z]) in points.iter().zip(others) {
                    for lane in 0..LANES {
                        own[0][lane] += u * x[lane] + v * y[lane];
                        own[1][lane] += v * x[lane] - u * y[lane];
                        own[2][lane] += h * z[lane];
                    }
                }
                let count = LANES.min(width - group * LANES);
                let start = frame * width + group * LANES;
                for (sums, own) in sums.iter_mut().zip(&own) {
                    sums[start..start + count].copy_from_slice(&own[..count]);
                }
            }
        }
    }
}

wide::dispatch! {
    /// Adds `values` multiplied by `times` to `sums`.
    fn add(sums: &mut [f64], times: f64, values: &[f64]) {
        for (sum, value) in sums.iter_mut().zip(values) {
            *sum += times * value;
        }
    }
}
