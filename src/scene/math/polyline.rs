//! A polyline in a plane.

use glam::DVec2;

/// A polyline with at least two points, each different from the one before it.
pub struct Polyline {
    points: Vec<DVec2>,
    /// The distance of each point along the line.
    lengths: Vec<f64>,
}

impl Polyline {
    pub fn new(points: Vec<DVec2>) -> Self {
        let mut lengths = vec![0.0];
        for (index, pair) in points.windows(2).enumerate() {
            lengths.push(lengths[index] + pair[0].distance(pair[1]));
        }
        Self { points, lengths }
    }

    pub fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// The point at a distance along the line; beyond an end, the end.
    pub fn at(&self, along: f64) -> DVec2 {
        let (from, to, fraction) = self.piece(along);
        from.lerp(to, fraction)
    }

    /// The direction of the line at a distance: a unit vector.
    pub fn direction(&self, along: f64) -> DVec2 {
        let (from, to, _) = self.piece(along);
        (to - from).normalize()
    }

    /// The distance along the line at which the line is nearest to a position. Searches from `from` to `from + beyond`.
    pub fn nearest(&self, position: DVec2, from: f64, beyond: f64) -> f64 {
        let end = (from + beyond).min(self.length());
        let mut best = (f64::INFINITY, from);
        for piece in self.piece_at(from)..self.points.len() {
            let (first, second) = (self.points[piece - 1], self.points[piece]);
            let [begin, length] = [self.lengths[piece - 1], self.lengths[piece] - self.lengths[piece - 1]];
            let part = (position - first).dot(second - first) / (second - first).length_squared();
            let along = (begin + part * length).clamp(begin.max(from), (begin + length).min(end).max(from));
            let apart = first.lerp(second, (along - begin) / length).distance_squared(position);
            if apart < best.0 {
                best = (apart, along);
            }
            if begin + length >= end {
                break;
            }
        }
        best.1
    }

    /// The index of the second point of the piece in which a distance ends.
    fn piece_at(&self, along: f64) -> usize {
        let next = self.lengths.partition_point(|length| *length <= along);
        next.clamp(1, self.points.len() - 1)
    }

    /// The two points of the piece in which a distance ends, and the fraction of the way from the first to the second.
    fn piece(&self, along: f64) -> (DVec2, DVec2, f64) {
        let next = self.piece_at(along);
        let [begin, end] = [self.lengths[next - 1], self.lengths[next]];
        let fraction = ((along - begin) / (end - begin)).clamp(0.0, 1.0);
        (self.points[next - 1], self.points[next], fraction)
    }
}
