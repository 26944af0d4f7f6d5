//! Solves weighted least squares with few unknowns, by normal equations and a Cholesky factorization.

/// The sums of the normal equations.
pub(super) struct LeastSquares {
    unknowns: usize,
    /// The lower triangle of the matrix. It is stored row by row, with unused entries for the upper triangle.
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl LeastSquares {
    pub(super) fn new(unknowns: usize) -> Self {
        Self {
            unknowns,
            matrix: vec![0.0; unknowns * unknowns],
            right: vec![0.0; unknowns],
        }
    }

    /// Adds an equation: the sum of the unknowns in `terms` times their factors is `value`. `terms` are in the order of
    /// the unknowns.
    pub(super) fn add(&mut self, terms: &[(usize, f64)], value: f64, weight: f64) {
        for (index, &(row, factor)) in terms.iter().enumerate() {
            let weighted = weight * factor;
            self.right[row] += weighted * value;
            for &(column, other) in &terms[..=index] {
                self.matrix[row * self.unknowns + column] += weighted * other;
            }
        }
    }

    /// The unknowns; `None` if the equations do not determine them.
    pub(super) fn solve(self) -> Option<Solution> {
        let n = self.unknowns;
        let mut factor = self.matrix;
        for row in 0..n {
            for column in 0..=row {
                let dot: f64 = (0..column).map(|k| factor[row * n + k] * factor[column * n + k]).sum();
                let left = factor[row * n + column] - dot;
                factor[row * n + column] = match row == column {
                    true if left <= 1e-12 => return None,
                    true => left.sqrt(),
                    false => left / factor[column * n + column],
                };
            }
        }
        let mut solution = Solution {
            values: Vec::new(),
            factor,
        };
        let mut values = solution.forward(self.right);
        for row in (0..n).rev() {
            let dot: f64 = (row + 1..n).map(|k| solution.factor[k * n + row] * values[k]).sum();
            values[row] = (values[row] - dot) / solution.factor[row * n + row];
        }
        solution.values = values;
        Some(solution)
    }
}

/// The solution of normal equations.
pub(super) struct Solution {
    pub(super) values: Vec<f64>,
    /// The Cholesky factor of the matrix.
    factor: Vec<f64>,
}

impl Solution {
    fn forward(&self, mut x: Vec<f64>) -> Vec<f64> {
        let n = x.len();
        for row in 0..n {
            let dot: f64 = (0..row).map(|k| self.factor[row * n + k] * x[k]).sum();
            x[row] = (x[row] - dot) / self.factor[row * n + row];
        }
        x
    }

    /// An element of the inverse of the matrix. This element times the variance of an equation of weight 1 is the
    /// covariance of two unknowns.
    pub(super) fn covariance(&self, one: usize, other: usize) -> f64 {
        let unit = |at: usize| {
            let mut unit = vec![0.0; self.values.len()];
            unit[at] = 1.0;
            self.forward(unit)
        };
        unit(one).iter().zip(unit(other)).map(|(a, b)| a * b).sum()
    }
}

/// The weight of a residual that is `ratio` times the scale: Tukey's biweight. It is 0 for a ratio of 1 or more.
pub(super) fn biweight(ratio: f64) -> f64 {
    match ratio.abs() < 1.0 {
        true => (1.0 - ratio * ratio).powi(2),
        false => 0.0,
    }
}

/// A piecewise linear curve through evenly spaced knots. The values at the knots are unknowns of a fit.
pub(super) struct Knots {
    pub(super) count: usize,
    frames: usize,
}

impl Knots {
    /// Creates knots that are at most `apart` frames apart. If this needs more than `most` intervals, creates `most`
    /// intervals.
    pub(super) fn new(frames: usize, apart: f64, most: usize) -> Self {
        let spans = ((frames as f64 / apart.max(1.0)).ceil() as usize).clamp(1, most);
        Self {
            count: spans + 1,
            frames: frames.max(2),
        }
    }

    pub(super) fn terms(&self, frame: usize, first: usize) -> [(usize, f64); 2] {
        let at = frame as f64 / (self.frames - 1) as f64 * (self.count - 1) as f64;
        let knot = (at as usize).min(self.count - 2);
        let part = at - knot as f64;
        [(first + knot, 1.0 - part), (first + knot + 1, part)]
    }

    /// The value of the curve in each frame. `knots` has the values at the knots.
    pub(super) fn curve(&self, knots: &[f64]) -> Vec<f64> {
        let value = |frame: usize| {
            self.terms(frame, 0)
                .iter()
                .map(|(knot, part)| knots[*knot] * part)
                .sum()
        };
        (0..self.frames).map(value).collect()
    }

    /// Adds equations that keep the curve straight (weight `bend`) and near 0 (weight `near`).
    pub(super) fn add_priors(&self, equations: &mut LeastSquares, first: usize, bend: f64, near: f64) {
        for knot in first..first + self.count {
            equations.add(&[(knot, 1.0)], 0.0, near);
            if knot + 2 < first + self.count {
                equations.add(&[(knot, 1.0), (knot + 1, -2.0), (knot + 2, 1.0)], 0.0, bend);
            }
        }
    }
}
