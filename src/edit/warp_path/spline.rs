//! A natural cubic spline through points in the plane.

use glam::DVec2;

/// A curve with continuous speed and acceleration, which continues straight beyond its ends. The curve depends linearly
/// on its points.
pub struct Spline {
    times: Vec<f64>,
    points: Vec<DVec2>,
    /// The second derivatives at the points.
    bends: Vec<DVec2>,
}

impl Spline {
    /// The spline through `points` at `times`, which increase. There must be at least one point.
    pub fn new(times: &[f64], points: &[DVec2]) -> Self {
        let count = points.len();
        let mut bends = vec![DVec2::ZERO; count];
        // Solves the tridiagonal system of the second derivatives by elimination and back substitution. The second
        // derivatives are 0 at both ends.
        let mut over = vec![0.0; count];
        for index in 1..count.saturating_sub(1) {
            let (before, after) = (times[index] - times[index - 1], times[index + 1] - times[index]);
            let jump = (points[index + 1] - points[index]) / after - (points[index] - points[index - 1]) / before;
            let pivot = 2.0 * (before + after) - before * over[index - 1];
            over[index] = after / pivot;
            bends[index] = (6.0 * jump - before * bends[index - 1]) / pivot;
        }
        for index in (1..count.saturating_sub(1)).rev() {
            let next = bends[index + 1];
            bends[index] -= over[index] * next;
        }
        Self {
            times: times.to_vec(),
            points: points.to_vec(),
            bends,
        }
    }

    /// The index of the piece of the curve at a time, the duration of this piece, and the weights of its two ends.
    fn piece(&self, time: f64) -> (usize, f64, f64, f64) {
        let last = self.times.len() - 2;
        let index = self
            .times
            .partition_point(|key| *key <= time)
            .saturating_sub(1)
            .min(last);
        let length = self.times[index + 1] - self.times[index];
        let weight = (time - self.times[index]) / length;
        (index, length, 1.0 - weight, weight)
    }

    fn ends(&self) -> (f64, f64) {
        (self.times[0], self.times[self.times.len() - 1])
    }

    /// The point at a time.
    pub fn at(&self, time: f64) -> DVec2 {
        if self.times.len() == 1 {
            return self.points[0];
        }
        let (first, last) = self.ends();
        let inside = time.clamp(first, last);
        let (index, length, a, b) = self.piece(inside);
        let cubic =
            ((a * a * a - a) * self.bends[index] + (b * b * b - b) * self.bends[index + 1]) * length * length / 6.0;
        let point = a * self.points[index] + b * self.points[index + 1] + cubic;
        point + self.speed(inside) * (time - inside)
    }

    /// The velocity at a time.
    pub fn speed(&self, time: f64) -> DVec2 {
        if self.times.len() == 1 {
            return DVec2::ZERO;
        }
        let (first, last) = self.ends();
        let (index, length, a, b) = self.piece(time.clamp(first, last));
        let slope = (self.points[index + 1] - self.points[index]) / length;
        let (before, after) = (self.bends[index], self.bends[index + 1]);
        slope + ((3.0 * b * b - 1.0) * after - (3.0 * a * a - 1.0) * before) * length / 6.0
    }
}
