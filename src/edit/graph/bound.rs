//! A few numbers for each window, whose distance is a lower bound of Kovar's distance and nearly as large for similar
//! windows. Windows that are far apart by these numbers are skipped, without an alignment.
//!
//! Over the ground, a point is a complex number and a window a vector z of points. Each point is relative to the mean
//! and multiplied by the root of its weight. After the best rotation,
//!
//! ```text
//! D² = r² + r'² - 2 |<z, z'>| + |h - h'|²,    r = |z|
//! ```
//!
//! where h are the heights. The matrix z z* does not change when z is rotated. With A = z z* / r,
//!
//! ```text
//! |A - A'|² = r² + r'² - 2 r r' c²,    c = |<z, z'>| / (r r') <= 1
//! D² - |h - h'|² = (r - r')² + 2 r r' (1 - c) >= (r - r')² + r r' (1 - c²) = ½ (r - r')² + ½ |A - A'|²
//! ```
//!
//! Both sides are nearly equal if c is near 1. So the entries of A and r, multiplied by the root of 1/2, together with
//! the heights are suitable numbers. These numbers are too many. Each of the following reductions keeps the bound:
//!
//! - Frames are expressed in orthonormal functions of time, of which the first are kept (Bessel's inequality).
//! - z is expressed in orthonormal patterns of points. The first [`PATTERNS`] are kept, and the length of the
//!   remainder.
//! - All numbers are expressed in orthonormal axes. The axes along which windows differ most are kept, and the length
//!   of the remainder.

use std::ops::Range;

use glam::DVec2;
use mocap_scene::math::principal;
use mocap_scene::math::spread::spread;

use super::clouds::{CloudSpace, Clouds};
use super::distance::Window;

/// The count of numbers for a window.
pub const NUMBERS: usize = 64;
/// The count of functions of time: constant, linear and quadratic.
const FUNCTIONS: usize = 3;
/// The number of patterns of points. More patterns give a tighter bound, but need more time.
const PATTERNS: usize = 12;

/// The number of windows from which patterns and axes are computed. The windows come from all clips, so that the bound
/// is tight.
const SAMPLE: usize = 1024;

/// The number of rounds of the iteration that computes patterns and axes. Any patterns give a valid bound, so the
/// iteration need not converge.
const ROUNDS: usize = 30;
/// The number of windows that are computed at once. This number limits the memory for a long clip.
const PIECE: usize = 256;

/// An addition to the threshold, because 32-bit numbers are rounded: a fraction of the threshold, and a length in
/// metres.
pub const SLACK: (f32, f32) = (1e-3, 1e-5);

/// The values that summarise a window, so that their distance is a lower bound of the distance of two windows.
pub type Numbers = [f32; NUMBERS];

/// The patterns of points and the axes (both orthonormal bases) in which windows are expressed to compute the lower
/// bound.
pub struct Bound {
    /// Functions of time, orthonormal under the weights of the frames and multiplied by these weights.
    functions: Vec<Vec<f64>>,
    patterns: Vec<Vec<f64>>,
    mean: Vec<f64>,
    axes: Vec<Vec<f64>>,
}

/// The coefficients of some windows of a clip in orthonormal functions of time. Each pair of a point and a function has
/// a row with one coefficient for each window.
struct Coefficients {
    count: usize,
    /// The rows of each coordinate: the two coordinates over the ground, relative to the mean, and the height.
    rows: [Vec<Vec<f64>>; 3],
}

impl Bound {
    /// Computes patterns and axes that suit some clips.
    pub fn new(space: &CloudSpace, window: &Window, clips: &[Clouds]) -> Self {
        let mut bound = Self {
            functions: functions(window.taper()),
            patterns: Vec::new(),
            mean: Vec::new(),
            axes: Vec::new(),
        };
        let count = |clip: &Clouds| window.count(clip);
        let step = clips.iter().map(count).sum::<usize>().div_ceil(SAMPLE).max(1);
        let chosen = clips
            .iter()
            .flat_map(|clip| (0..count(clip)).map(move |start| (clip, start)));
        let chosen: Vec<_> = chosen.step_by(step).collect();
        let sample: Vec<Coefficients> = spread(&chosen, |(clip, start)| {
            Coefficients::new(space, &bound.functions, clip, *start..*start + 1)
        });
        let over_ground: Vec<Vec<f64>> = sample
            .iter()
            .flat_map(|of| [of.column(0, 0), of.column(1, 0)])
            .collect();
        let size = space.weights.len() * bound.functions.len();
        let products = principal::products(over_ground.iter().map(Vec::as_slice), size);
        bound.patterns = principal::axes(&products, size, PATTERNS, ROUNDS);
        let mut all: Vec<Vec<f64>> = spread(&sample, |of| bound.invariants(of).remove(0));
        let width = all.first().map_or(0, Vec::len);
        bound.mean = vec![0.0; width];
        for row in &all {
            bound
                .mean
                .iter_mut()
                .zip(row)
                .for_each(|(mean, value)| *mean += value / all.len() as f64);
        }
        for row in &mut all {
            row.iter_mut().zip(&bound.mean).for_each(|(value, mean)| *value -= mean);
        }
        let products = principal::products(all.iter().map(Vec::as_slice), width);
        bound.axes = principal::axes(&products, width, NUMBERS - 1, ROUNDS);
        bound
    }

    /// For each clip, the values that summarise each of its windows.
    pub fn numbers(&self, space: &CloudSpace, window: &Window, clips: &[Clouds]) -> Vec<Vec<Numbers>> {
        let pieces = |clip: usize| {
            let count = window.count(&clips[clip]);
            (0..count)
                .step_by(PIECE)
                .map(move |start| (clip, start..(start + PIECE).min(count)))
        };
        let work: Vec<(usize, Range<usize>)> = (0..clips.len()).flat_map(pieces).collect();
        let of_pieces = spread(&work, |(clip, starts)| {
            let of = Coefficients::new(space, &self.functions, &clips[*clip], starts.clone());
            let rows = self.invariants(&of);
            rows.iter().map(|row| self.written(row)).collect::<Vec<Numbers>>()
        });
        let mut numbers = vec![Vec::new(); clips.len()];
        for ((clip, _), piece) in work.iter().zip(of_pieces) {
            numbers[*clip].extend(piece);
        }
        numbers
    }

    /// For each window, a row of values that do not change when the window is rotated about the vertical.
    fn invariants(&self, of: &Coefficients) -> Vec<Vec<f64>> {
        let [x, y] = [0, 1].map(|axis| of.in_patterns(axis, &self.patterns));
        let invariants = |window: usize| {
            let z: Vec<DVec2> = x
                .iter()
                .zip(&y)
                .map(|(x, y)| DVec2::new(x[window], y[window]))
                .collect();
            let square = |rows: &[Vec<f64>]| rows.iter().map(|row| row[window].powi(2)).sum::<f64>();
            let whole = square(&of.rows[0]) + square(&of.rows[1]);
            let kept: f64 = z.iter().map(|z| z.length_squared()).sum();
            let radius = kept.sqrt();
            let half = 0.5_f64.sqrt();
            let scale = if radius > 0.0 { half / radius } else { 0.0 };
            let mut numbers = vec![half * radius, (whole - kept).max(0.0).sqrt()];
            for (index, own) in z.iter().enumerate() {
                numbers.push(scale * own.length_squared());
                for other in &z[..index] {
                    // Each of these entries occurs twice in the symmetric matrix.
                    let twice = std::f64::consts::SQRT_2 * scale;
                    numbers.extend([twice * own.dot(*other), twice * own.perp_dot(*other)]);
                }
            }
            numbers.extend(of.rows[2].iter().map(|row| row[window]));
            numbers
        };
        (0..of.count).map(invariants).collect()
    }

    /// The coordinates of a row along the axes, and the length of the part of the row that no axis covers.
    fn written(&self, row: &[f64]) -> Numbers {
        let row: Vec<f64> = row.iter().zip(&self.mean).map(|(value, mean)| value - mean).collect();
        let mut numbers = [0.0; NUMBERS];
        let mut left: f64 = row.iter().map(|value| value * value).sum();
        for (number, axis) in numbers.iter_mut().zip(&self.axes) {
            let along = mocap_scene::math::cholesky::dot(&row, axis);
            left -= along * along;
            *number = along as f32;
        }
        numbers[NUMBERS - 1] = left.max(0.0).sqrt() as f32;
        numbers
    }
}

impl Coefficients {
    /// The coefficients of the windows that begin at the frames `starts`.
    fn new(space: &CloudSpace, functions: &[Vec<f64>], clip: &Clouds, starts: Range<usize>) -> Self {
        let (count, width) = (starts.len(), functions[0].len());
        let origin = clip.centres[starts.start];
        let origin = [origin.x, origin.y, 0.0];
        let mut rows = [0, 1, 2].map(|_| Vec::with_capacity(space.weights.len() * functions.len()));
        for (axis, rows) in rows.iter_mut().enumerate() {
            for (point, weight) in space.weights.iter().enumerate() {
                let from = point * clip.frames + starts.start;
                let values = &clip.values[axis][from..from + count + width - 1];
                let values: Vec<f64> = values.iter().map(|value| f64::from(*value) - origin[axis]).collect();
                for function in functions {
                    let mut row = vec![0.0; count];
                    for (frame, part) in function.iter().enumerate() {
                        let part = weight.sqrt() * part;
                        row.iter_mut()
                            .zip(&values[frame..])
                            .for_each(|(sum, value)| *sum += part * value);
                    }
                    rows.push(row);
                }
            }
        }
        for rows in &mut rows[..2] {
            about_mean(rows, &space.weights, functions.len());
        }
        Self { count, rows }
    }

    /// The coefficients of one window.
    fn column(&self, axis: usize, window: usize) -> Vec<f64> {
        self.rows[axis].iter().map(|row| row[window]).collect()
    }

    /// The coefficient of each pattern in each window.
    fn in_patterns(&self, axis: usize, patterns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |pattern: &Vec<f64>| {
            let mut sums = vec![0.0; self.count];
            for (part, row) in pattern.iter().zip(&self.rows[axis]) {
                sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += part * value);
            }
            sums
        };
        patterns.iter().map(of).collect()
    }
}

/// Subtracts the mean of all points in all frames of a window. Only the coefficients of the constant function depend on
/// this mean.
fn about_mean(rows: &mut [Vec<f64>], weights: &[f64], functions: usize) {
    let count = rows.first().map_or(0, Vec::len);
    let mut mean = vec![0.0; count];
    for (weight, row) in weights.iter().zip(rows.iter().step_by(functions)) {
        mean.iter_mut()
            .zip(row)
            .for_each(|(mean, value)| *mean += weight.sqrt() * value);
    }
    for (weight, row) in weights.iter().zip(rows.iter_mut().step_by(functions)) {
        row.iter_mut()
            .zip(&mean)
            .for_each(|(value, mean)| *value -= weight.sqrt() * mean);
    }
}

/// Polynomials that are orthonormal under the weights of the frames and multiplied by these weights, by the
/// Gram-Schmidt method.
fn functions(taper: &[f64]) -> Vec<Vec<f64>> {
    let product = |a: &[f64], b: &[f64]| -> f64 { taper.iter().zip(a).zip(b).map(|((w, a), b)| w * a * b).sum() };
    let mut functions: Vec<Vec<f64>> = Vec::new();
    let half = 0.5 * (taper.len() - 1) as f64;
    // A window of two frames has only two independent functions.
    for degree in 0..FUNCTIONS.min(taper.len()) as i32 {
        let mut function: Vec<f64> = (0..taper.len())
            .map(|frame| (frame as f64 / half - 1.0).powi(degree))
            .collect();
        for other in functions.iter().chain(&functions) {
            let along = product(&function, other);
            function
                .iter_mut()
                .zip(other)
                .for_each(|(value, other)| *value -= along * other);
        }
        let length = product(&function, &function).sqrt();
        functions.push(function.iter().map(|value| value / length).collect());
    }
    let weighted = |function: &Vec<f64>| {
        function
            .iter()
            .zip(taper)
            .map(|(value, weight)| value * weight)
            .collect()
    };
    functions.iter().map(weighted).collect()
}
