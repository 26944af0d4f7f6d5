//! The report of steps that change the frames of a motion, and the conversion that some of these steps use.

use std::fmt;

use mocap_figure::Figure;
use mocap_figure::convert::Conversion;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::StepInput;
use super::step::names;

/// The frames of a motion before and after a step.
///
/// [`Trim`](crate::Trim) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FramesReport {
    /// The number of frames before the step.
    pub frames_before: usize,
    /// The number of frames after the step.
    pub frames: usize,
    /// Seconds from the first frame to the last frame, after the step.
    pub seconds: f64,
}

impl fmt::Display for FramesReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            frames_before,
            frames,
            seconds,
        } = self;
        write!(f, "{frames_before} frames, now {frames} frames in {seconds:.2} s")
    }
}

/// Applies `conversion` to all animations of the scene. The scene keeps its unit and its axes.
pub(super) fn converted(scene: &mut Scene, input: &StepInput<'_>, conversion: Conversion) -> Result<FramesReport> {
    let frames = |scene: &Scene| {
        let animation = scene.animations.get(input.animation);
        animation.map(|animation| (animation.frame_count(), animation.duration / animation.ticks_per_second))
    };
    let Some((frames_before, _)) = frames(scene) else {
        let (animation, count) = (input.animation, scene.animations.len());
        let message = format!("there is no animation {animation}: the scene has {count}");
        return Err(Diagnostic::new(Code::NoMotion, message).into());
    };
    let bones = input
        .humanoid
        .map(|humanoid| names(scene, humanoid))
        .unwrap_or_default();
    let known = scene.metadata.assumptions.len();
    let figure = match input.bones() {
        Some(known) => Figure::with_bones(scene, known.clone()),
        None => Figure::new(scene),
    };
    if let Err(error) = conversion.keep_units(true).bones(bones).convert(scene, &figure) {
        // Removes the assumptions that the failed conversion added, because it changed nothing.
        scene.metadata.assumptions.truncate(known);
        return Err(error);
    }
    let (frames, seconds) = frames(scene).unwrap_or_default();
    Ok(FramesReport {
        frames_before,
        frames,
        seconds,
    })
}
