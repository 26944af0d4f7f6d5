//! Unnamed markers, and the pairs of markers whose distance stays constant.

use glam::DVec3;

use mocap_scene::math::median::{median, percentile};

/// The largest number of frames to analyse.
const FRAMES: usize = 300;

/// The smallest fraction of frames in which a marker must be seen to count.
const SEEN: f64 = 0.3;

/// The largest number of markers to compare: all pairs in all these frames.
const MOST: usize = 200;

/// The percentile of the body height above which the body stands, as a fraction.
const STANDS: f64 = 0.6;

/// Markers in a selection of frames.
pub(super) struct Cloud {
    /// The indices of the markers in the file.
    pub(super) markers: Vec<usize>,
    /// Indexed by frame, then marker.
    pub(super) frames: Vec<Vec<Option<DVec3>>>,
    pub(super) up: DVec3,
    /// The body height, in the unit of the file.
    pub(super) stature: f64,
    /// The frames in which the body stands.
    pub(super) upright: Vec<usize>,
    /// The height of each marker above the ground while the body stands, as a fraction of the body height.
    pub(super) heights: Vec<f64>,
    /// The variation of each pair's distance, marker by marker, and its median, as fractions of the body height.
    spread: Vec<f64>,
    distance: Vec<f64>,
}

impl Cloud {
    /// `None` if there are too few markers for a body, or too many.
    pub(super) fn of(tracks: &[Vec<Option<DVec3>>]) -> Option<Self> {
        /// The smallest number of markers of a body: three of the pelvis, of the trunk and of each foot.
        const FEWEST: usize = 12;
        let count = tracks.first().map_or(0, Vec::len);
        let is_seen = |marker: &usize| tracks[*marker].iter().flatten().count() as f64 > SEEN * count as f64;
        let markers: Vec<usize> = (0..tracks.len()).filter(is_seen).collect();
        if !(FEWEST..=MOST).contains(&markers.len()) {
            return None;
        }
        let cloud = Self::of_markers(tracks, markers)?;
        let kept: Vec<usize> = (0..cloud.count())
            .filter(|marker| cloud.is_of_body(*marker))
            .map(|marker| cloud.markers[marker])
            .collect();
        match kept.len() {
            same if same == cloud.count() => Some(cloud),
            FEWEST.. => Self::of_markers(tracks, kept),
            _ => None,
        }
    }

    fn of_markers(tracks: &[Vec<Option<DVec3>>], markers: Vec<usize>) -> Option<Self> {
        let count = tracks.first().map_or(0, Vec::len);
        let frames: Vec<Vec<Option<DVec3>>> = (0..count)
            .step_by((count / FRAMES).max(1))
            .map(|frame| markers.iter().map(|marker| tracks[*marker][frame]).collect())
            .collect();
        let mut cloud = Self {
            up: tallest_axis(&frames)?,
            heights: Vec::new(),
            stature: 0.0,
            upright: Vec::new(),
            spread: Vec::new(),
            distance: Vec::new(),
            markers,
            frames,
        };
        cloud.stand()?;
        cloud.compare();
        Some(cloud)
    }

    /// Whether two other markers keep their distances to this marker. A stationary reflection in the room has no such
    /// markers.
    fn is_of_body(&self, marker: usize) -> bool {
        /// The largest variation of such a distance, as a fraction of the body height.
        const LOOSE: f64 = 0.02;
        let others = (0..self.count()).filter(|other| *other != marker && self.spread(marker, *other) < LOOSE);
        others.take(2).count() == 2
    }

    pub(super) fn count(&self) -> usize {
        self.markers.len()
    }

    /// The variation of the distance of two markers, as a fraction of the body height.
    pub(super) fn spread(&self, a: usize, b: usize) -> f64 {
        self.spread[a * self.count() + b]
    }

    /// The median distance of two markers, as a fraction of the body height.
    pub(super) fn distance(&self, a: usize, b: usize) -> f64 {
        self.distance[a * self.count() + b]
    }

    /// Finds the body height, the ground, and the frames in which the body stands.
    fn stand(&mut self) -> Option<()> {
        let height = |point: &Option<DVec3>| point.map(|point| point.dot(self.up));
        let ends: Vec<(f64, f64)> = self
            .frames
            .iter()
            .map(|frame| {
                // The lowest and the highest marker may be reflections.
                let mut heights: Vec<f64> = frame.iter().filter_map(height).collect();
                heights.sort_unstable_by(f64::total_cmp);
                let last = heights.len().saturating_sub(2);
                let at = |point: usize| heights.get(point).copied().unwrap_or(0.0);
                (at(1.min(last)), at(last))
            })
            .collect();
        let tall: Vec<f64> = ends.iter().map(|(low, high)| high - low).collect();
        let part = |part: f64| percentile(tall.iter().copied(), part, f64::round).unwrap_or(f64::NAN);
        self.stature = part(0.95);
        let stands = part(STANDS);
        let lows = ends.iter().map(|(low, _)| *low);
        let ground = percentile(lows, 0.05, f64::round).unwrap_or(f64::NAN);
        self.upright = (0..tall.len()).filter(|frame| tall[*frame] >= stands).collect();
        if !(self.stature.is_finite() && self.stature > 0.0) {
            return None;
        }
        let of_marker = |marker: usize| {
            let seen = self
                .upright
                .iter()
                .filter_map(|frame| height(&self.frames[*frame][marker]));
            let mut seen: Vec<f64> = seen.collect();
            let middle = if seen.is_empty() {
                ground
            } else {
                median(&mut seen).unwrap_or_default()
            };
            (middle - ground) / self.stature
        };
        self.heights = (0..self.markers.len()).map(of_marker).collect();
        Some(())
    }

    /// The distances of all pairs.
    fn compare(&mut self) {
        /// The number of standard deviations between the 10th and the 90th percentile of a normal distribution: 2 times
        /// 1.28.
        const DEVIATIONS: f64 = 2.56;
        let count = self.count();
        self.spread = vec![0.0; count * count];
        self.distance = vec![0.0; count * count];
        for a in 0..count {
            for b in 0..a {
                let pairs = self
                    .frames
                    .iter()
                    .filter_map(|frame| Some(frame[a]?.distance(frame[b]?)));
                let pairs: Vec<f64> = pairs.collect();
                let (spread, middle) = match pairs.len() {
                    0 => (1.0, 1.0),
                    _ => {
                        let part = |part: f64| percentile(pairs.iter().copied(), part, f64::round).unwrap_or(f64::NAN);
                        let range = part(0.9) - part(0.1);
                        (range / DEVIATIONS / self.stature, part(0.5) / self.stature)
                    }
                };
                for cell in [a * count + b, b * count + a] {
                    (self.spread[cell], self.distance[cell]) = (spread, middle);
                }
            }
        }
    }

    /// For each marker, the variation of the loosest link on the tightest path from the marker `from`. Paths use only
    /// the markers of `allowed`. These links form the tree of rigid bodies (single linkage).
    pub(super) fn links(&self, from: usize, allowed: &[usize]) -> Vec<f64> {
        let mut best = vec![f64::MAX; self.count()];
        let mut open: Vec<usize> = allowed.iter().copied().filter(|marker| *marker != from).collect();
        best[from] = 0.0;
        let mut last = from;
        while !open.is_empty() {
            for &marker in &open {
                best[marker] = best[marker].min(best[last].max(self.spread(last, marker)));
            }
            let Some(point) = (0..open.len()).min_by(|a, b| best[open[*a]].total_cmp(&best[open[*b]])) else {
                break;
            };
            last = open.swap_remove(point);
        }
        best
    }

    /// The centroid of some markers in a frame.
    pub(super) fn middle(&self, markers: &[usize], frame: usize) -> Option<DVec3> {
        let seen = markers.iter().filter_map(|marker| self.frames[frame][*marker]);
        let (sum, count) = seen.fold((DVec3::ZERO, 0), |(sum, count), point| (sum + point, count + 1));
        (count > 0).then(|| sum / f64::from(count))
    }

    /// The median, over `frames`, of a marker's coordinate along an axis from an origin, as a fraction of the body
    /// height. Axis and origin are given for each frame.
    pub(super) fn along(&self, marker: usize, axes: &[DVec3], from: &[Option<DVec3>], frames: &[usize]) -> f64 {
        let height = |frame: &usize| {
            let own = self.frames[*frame][marker]? - from[*frame]?;
            Some(own.dot(axes[*frame]) / self.stature)
        };
        let mut heights: Vec<f64> = frames.iter().filter_map(height).collect();
        if heights.is_empty() {
            0.0
        } else {
            median(&mut heights).unwrap_or_default()
        }
    }
}

/// The axis along which the markers of a mostly standing body reach farthest.
fn tallest_axis(frames: &[Vec<Option<DVec3>>]) -> Option<DVec3> {
    let reach = |axis: &DVec3| {
        let of_frame = |frame: &Vec<Option<DVec3>>| {
            let heights = frame.iter().flatten().map(|point| point.dot(*axis));
            let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), own| (low.min(own), high.max(own)));
            high - low
        };
        percentile(frames.iter().map(of_frame), 0.5, f64::round).unwrap_or(f64::NAN)
    };
    // +Y wins unless another axis is clearly longer, because readers turn a known up axis to +Y.
    [DVec3::Y, DVec3::Z, DVec3::X].into_iter().reduce(|best, other| {
        if reach(&other) > 1.2 * reach(&best) {
            other
        } else {
            best
        }
    })
}
