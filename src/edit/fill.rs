//! Fills gaps in which a motion was held.

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
    /// Fills gaps: frames in which every joint holds exactly the values of the frame before, as programs write them
    /// when markers were not seen. The motion goes on through a gap on the cubic curve that has the speeds before and
    /// after it.
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
    /// [`Code::NoMotion`] without this animation; [`Code::InvalidValue`] for a time that is not finite, or is negative.
    Fill {
        /// The longest gap to fill, in seconds: what is held longer may be meant. Default: 0.5.
        longest: f64 = 0.5, ValueKind::Seconds;
        /// The shortest, in seconds. Default: 0, two equal frames.
        shortest: f64 = 0.0, ValueKind::Seconds;
    }
}

impl Step for Fill {
    const NAME: &'static str = "fill";
    const HELP: &'static str = "fill gaps in which the motion was held";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = FillReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FillReport> {
        fill(scene, input.animation, self)
    }
}

/// What [`Fill`] changed.
///
/// [`Fill`](crate::Fill) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FillReport {
    /// The gaps that were filled, each as its first and its last frame.
    pub gaps: Vec<[usize; 2]>,
    /// Gaps that are longer than the options allow, likewise. They stay.
    pub longer: Vec<[usize; 2]>,
    /// The largest change of a rotation to its parent, in degrees.
    pub largest_rotation: f32,
}

impl fmt::Display for FillReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} gaps filled, {} longer ones left; rotations changed by {} at most",
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
        // `start` has the value that the frames after it hold; a motion may begin and end with a still pose.
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
