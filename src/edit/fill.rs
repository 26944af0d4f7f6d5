//! Fills gaps of a motion: frames that repeat the frame before, and frames without a marker.

use std::fmt;

use mocap_scene::error::{Code, Result};
use mocap_scene::limits::{not_negative, positive};
use mocap_scene::math::quaternion::log;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::bridge::bridge;
use super::frames::Frames;
use super::quantity::degrees;
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Fills gaps. A gap is a run of frames in which every joint exactly repeats the frame before. Capture programs
    /// write such frames while the cameras do not see the markers. The step replaces the gap by a cubic curve, which
    /// has the speeds of the motion before and after the gap. For markers and other points without a skeleton, a gap is
    /// a run of frames in which the cameras did not see the point.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Fill, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Fill::new().longest(0.2).apply(&mut scene, &StepInput::new())?;
    /// assert!(report.gaps.is_empty()); // nothing was held
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`] if the scene lacks the animation; [`Code::InvalidValue`] for a time that is not finite, or is
    /// negative.
    Fill {
        /// The longest gap to fill, in seconds. In a longer gap, the figure may be still on purpose. Default: 0.5.
        longest: f64 = 0.5, ValueKind::Seconds;
        /// The shortest gap to fill, in seconds. Default: 0, which also fills a single repeated frame.
        shortest: f64 = 0.0, ValueKind::Seconds;
    }
}

impl Step for Fill {
    const NAME: &'static str = "fill";
    const HELP: &'static str = "fill gaps: frames in which a pose is held or a point is missing";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = FillReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FillReport> {
        fill(scene, input.animation, self)
    }
}

/// The report of [`Fill`].
///
/// [`Fill`](crate::Fill) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FillReport {
    /// The gaps that were filled, each as its first and its last frame.
    pub gaps: Vec<[usize; 2]>,
    /// The gaps that are longer than the option `longest`. The step did not fill them. A gap is given by its first and
    /// its last frame.
    pub longer: Vec<[usize; 2]>,
    /// For a scene of markers, or of other points without a skeleton: the points with filled gaps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub filled_points: Vec<PointGaps>,
    /// The points with gaps that the step did not fill. Such a gap is longer than the option `longest`, or it is at the
    /// beginning or the end of the motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unfilled_points: Vec<PointGaps>,
    /// The largest change of a joint's rotation relative to its parent, in degrees.
    pub largest_rotation: f32,
}

/// The gaps of one point, each as its first and its last frame.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PointGaps {
    /// The name of the point.
    pub name: String,
    /// The gaps of the point.
    pub gaps: Vec<[usize; 2]>,
}

impl fmt::Display for PointGaps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.name)?;
        for [first, last] in &self.gaps {
            write!(f, " {first}..{last}")?;
        }
        Ok(())
    }
}

/// The largest number of points that a message names.
const NAMED: usize = 8;

/// The gaps of some points, as text.
fn list(points: &[PointGaps]) -> String {
    let named = points.iter().take(NAMED).map(ToString::to_string);
    let named = named.collect::<Vec<_>>().join(", ");
    match points.len().saturating_sub(NAMED) {
        0 => named,
        more => format!("{named}, and {more} more points"),
    }
}

impl fmt::Display for FillReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of_points = [&self.filled_points, &self.unfilled_points];
        if of_points.iter().any(|points| !points.is_empty()) {
            let [filled, unfilled] = of_points.map(|points| points.iter().map(|point| point.gaps.len()).sum::<usize>());
            write!(f, "{filled} gaps of {} points filled", self.filled_points.len())?;
            if filled > 0 {
                write!(f, " in frames {}", list(&self.filled_points))?;
            }
            if unfilled > 0 {
                write!(f, "; {unfilled} gaps unchanged: {}", list(&self.unfilled_points))?;
            }
            return Ok(());
        }
        write!(
            f,
            "{} gaps filled, {} longer gaps not filled; rotations changed by {} at most",
            self.gaps.len(),
            self.longer.len(),
            degrees(self.largest_rotation),
        )
    }
}

fn fill(scene: &mut Scene, animation: usize, options: &Fill) -> Result<FillReport> {
    positive(Code::InvalidValue, "longest", options.longest)?;
    not_negative(Code::InvalidValue, "shortest", options.shortest)?;
    let mut frames = Frames::new(scene, animation, &[])?;
    let mut report = FillReport::default();
    if frames.has_gaps() {
        fill_points(scene, &mut frames, options, &mut report);
        let nodes = frames.nodes().to_vec();
        frames.write(scene, animation, &[], &nodes);
        return Ok(report);
    }
    let is_held = |frame: usize| {
        let held = |node: &mocap_scene::scene::NodeId| frames.get(frame, *node) == frames.get(frame - 1, *node);
        frames.nodes().iter().all(held)
    };
    let mut held: Vec<bool> = (1..frames.len()).map(is_held).collect();
    held.insert(0, false);
    let mut start = 0;
    while start < held.len() {
        let end = (start + 1..held.len())
            .find(|frame| !held[*frame])
            .unwrap_or(held.len());
        // The frames after `start`, up to `end`, repeat the frame `start`. A motion may begin or end with a still pose,
        // which is no gap.
        let seconds = (end - start - 1) as f64 / frames.rate;
        if end > start + 1 && start > 0 && end < held.len() && seconds >= options.shortest {
            match seconds <= options.longest {
                true => report.gaps.push([start + 1, end - 1]),
                false => report.longer.push([start + 1, end - 1]),
            }
        }
        start = end;
    }
    let nodes = frames.nodes().to_vec();
    let (mut rotated, mut moved) = (Vec::new(), Vec::new());
    for (column, &node) in nodes.iter().enumerate() {
        let mut track = frames.track(column);
        let old = track.clone();
        for &[first, last] in &report.gaps {
            bridge(&mut track, first, last);
        }
        for (old, new) in old.iter().zip(&track) {
            let by = log(old.rotation.inverse() * new.rotation).length().to_degrees();
            report.largest_rotation = report.largest_rotation.max(by);
        }
        if old.iter().zip(&track).any(|(old, new)| old.rotation != new.rotation) {
            rotated.push(node);
        }
        if old
            .iter()
            .zip(&track)
            .any(|(old, new)| old.translation != new.translation)
        {
            moved.push(node);
        }
        frames.set_track(column, &track);
    }
    frames.write(scene, animation, &rotated, &moved);
    Ok(report)
}

/// Fills the gaps of points that have no skeleton. A gap is filled only if the point is seen before and after it.
fn fill_points(scene: &Scene, frames: &mut Frames, options: &Fill, report: &mut FillReport) {
    for (column, node) in frames.nodes().to_vec().into_iter().enumerate() {
        let name = &scene.nodes[node.index()].name;
        let is_inner = |[first, last]: &[usize; 2]| *first > 0 && *last + 1 < frames.len();
        let seconds = |[first, last]: &[usize; 2]| (last + 1 - first) as f64 / frames.rate;
        let is_filled =
            |gap: &[usize; 2]| is_inner(gap) && (options.shortest..=options.longest).contains(&seconds(gap));
        let (filled, unfilled): (Vec<_>, Vec<_>) = frames.gaps(column).into_iter().partition(is_filled);
        let mut track = frames.track(column);
        for gap in &filled {
            bridge(&mut track, gap[0], gap[1]);
            frames.set_visible(column, *gap);
        }
        frames.set_track(column, &track);
        for (gaps, points) in [
            (filled, &mut report.filled_points),
            (unfilled, &mut report.unfilled_points),
        ] {
            if !gaps.is_empty() {
                points.push(PointGaps {
                    name: name.clone(),
                    gaps,
                });
            }
        }
    }
}
