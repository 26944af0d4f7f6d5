//! A line through points on a plane.

use glam::DVec2;

/// A line through two points or more, none equal to the one before it.
pub(crate) struct Polyline {
    points: Vec<DVec2>,
    /// How far along each point is.
    lengths: Vec<f64>,
}

impl Polyline {
    pub(crate) fn new(points: Vec<DVec2>) -> Self {
        let mut lengths = vec![0.0];
        for (index, pair) in points.windows(2).enumerate() {
            lengths.push(lengths[index] + pair[0].distance(pair[1]));
        }
        Self { points, lengths }
    }

    pub(crate) fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// The point after a distance, an end at most.
    pub(crate) fn at(&self, along: f64) -> DVec2 {
        let (from, to, fraction) = self.piece(along);
        from.lerp(to, fraction)
    }

    /// Where the line leads after a distance: a vector of length 1.
    pub(crate) fn direction(&self, along: f64) -> DVec2 {
        let (from, to, _) = self.piece(along);
        (to - from).normalize()
    }

    /// How far along the point nearest to a position is, from `from` to `beyond` after it.
    pub(crate) fn nearest(&self, position: DVec2, from: f64, beyond: f64) -> f64 {
        const STEPS: usize = 50;
        let along = |step: usize| (from + beyond * step as f64 / STEPS as f64).min(self.length());
        let candidates = (0..=STEPS).map(along);
        let distance = |along: &f64| self.at(*along).distance_squared(position);
        candidates
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap_or(from)
    }

    /// The two points between which a distance ends, and the fraction of their distance that is behind it.
    fn piece(&self, along: f64) -> (DVec2, DVec2, f64) {
        let next = self.lengths.partition_point(|length| *length <= along);
        let next = next.clamp(1, self.points.len() - 1);
        let [begin, end] = [self.lengths[next - 1], self.lengths[next]];
        let fraction = ((along - begin) / (end - begin)).clamp(0.0, 1.0);
        (self.points[next - 1], self.points[next], fraction)
    }
}
