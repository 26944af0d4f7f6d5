//! Handles points that are not seen in every frame, such as markers.

use glam::Vec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::pose::Trs;
use mocap_scene::scene::{Keys, Scene};

use super::Frames;

impl Frames<'_> {
    /// Whether points of the motion have gaps.
    pub(crate) fn has_gaps(&self) -> bool {
        self.visible.as_ref().is_some_and(|visible| visible.contains(&false))
    }

    /// The gaps of a stored point, each as its first and its last frame.
    pub(crate) fn gaps(&self, column: usize) -> Vec<[usize; 2]> {
        let mut gaps: Vec<[usize; 2]> = Vec::new();
        for frame in (0..self.len()).filter(|frame| !self.is_visible(*frame as f64, column)) {
            match gaps.last_mut() {
                Some([_, last]) if *last + 1 == frame => *last = frame,
                _ => gaps.push([frame, frame]),
            }
        }
        gaps
    }

    /// Marks a point as seen in the frames from `first` to `last`.
    pub(crate) fn set_visible(&mut self, column: usize, [first, last]: [usize; 2]) {
        for frame in first..=last {
            if let Some(visible) = &mut self.visible {
                visible[frame * self.held + column] = true;
            }
        }
    }

    /// Whether a point is seen at a fractional frame: the point must be seen in the frames before and after.
    pub(super) fn is_visible(&self, frame: f64, column: usize) -> bool {
        let last = self.len().saturating_sub(1);
        let at = |frame: f64| {
            let frame = (frame.max(0.0) as usize).min(last);
            self.visible
                .as_ref()
                .is_none_or(|visible| visible[frame * self.held + column])
        };
        at(frame.floor()) && at(frame.ceil())
    }

    /// Frames at whole ticks with the transforms of `rows`. For each row, `taken` has the motion and the frame from
    /// which the row comes. The row keeps the gaps and the morph weights of this frame.
    pub(crate) fn with_rows_of(&self, rows: Vec<Vec<Trs>>, taken: &[(&Self, f64)]) -> Self {
        self.with_rows(rows).taking(self, taken)
    }

    /// A motion with one frame per tick. Frame `i` has the transforms of frame `chosen[i]`. The gaps and the morph
    /// weights of frame `i` are sampled at the fractional frame `times[i]`.
    pub(crate) fn picked_of(&self, chosen: &[usize], times: &[f64]) -> Self {
        let taken: Vec<(&Self, f64)> = times.iter().map(|time| (self, *time)).collect();
        self.picked(chosen).taking(self, &taken)
    }

    fn taking(self, like: &Self, taken: &[(&Self, f64)]) -> Self {
        let has_gaps = taken.iter().any(|(motion, _)| motion.has_gaps());
        let visible = || {
            let rows = taken.iter().map(|(motion, frame)| {
                let row = (0..like.held).map(|column| motion.is_visible(*frame, column));
                row.collect::<Vec<bool>>()
            });
            rows.flatten().collect()
        };
        Self {
            visible: has_gaps.then(visible),
            weights: like
                .weights
                .taken(taken.iter().map(|(motion, frame)| (&motion.weights, *frame))),
            ..self
        }
    }

    /// The keys of a point, only at frames in which it is seen.
    pub(super) fn keys_of_point(&self, positions: Vec<Vec3>, column: usize) -> Keys<Vec3> {
        let frames = self.ticks.iter().zip(positions).enumerate();
        let seen = frames.filter(|(frame, _)| self.is_visible(*frame as f64, column));
        let (ticks, values) = seen.map(|(_, (tick, position))| (*tick, position)).unzip();
        Keys::of_point(values, ticks, self.len())
    }
}

/// Warns about gaps that a step fills because it makes new frames and cannot keep gaps.
pub(super) fn report_filled(scene: &mut Scene, animation: usize) {
    let gaps = scene.points_with_gaps(&scene.animations[animation]);
    let filled = gaps.iter().flatten().count();
    if filled > 0 {
        let message = format!("the gaps of {filled} points were filled by straight lines");
        let diagnostic = Diagnostic::new(Code::Gap, message);
        let help = "first fill the gaps with the step fill, which lists the gaps";
        scene.warnings.push(diagnostic.help(help));
    }
}
