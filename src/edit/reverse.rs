//! Plays a motion backwards.

use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use super::frames::Frames;
use super::frames_report::FramesReport;
use super::step::step;
use super::{Step, StepInput, StepKey};

step! {
    /// Plays a motion backwards: the last frame becomes the first frame. A second `reverse` restores the motion.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Reverse, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// Reverse::new().apply(&mut scene, &StepInput::new())?;
    /// // The lecture's first position of Shoulder.
    /// assert!((scene.animations[0].channels[0].position_keys.values[9].x - 0.1).abs() < 1e-6);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation.
    Reverse {}
}

impl Step for Reverse {
    const NAME: &'static str = "reverse";
    const HELP: &'static str = "play backwards";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = FramesReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FramesReport> {
        let frames = Frames::new(scene, input.animation, &[])?;
        let rows = (0..frames.len()).rev().map(|frame| frames.row(frame));
        let taken: Vec<_> = (0..frames.len()).rev().map(|frame| (&frames, frame as f64)).collect();
        frames
            .with_rows_of(rows.collect(), &taken)
            .write_all(scene, input.animation);
        Ok(FramesReport {
            frames_before: frames.len(),
            frames: frames.len(),
            seconds: frames.len().saturating_sub(1) as f64 / frames.rate,
        })
    }
}
