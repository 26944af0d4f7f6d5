//! Drops the first frame.

use mocap_figure::convert::{Conversion, FirstFrame};
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use super::frames_report::{FramesReport, converted};
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Drops the first frame if it is a rest pose. Some programs write the rest pose as the first frame.
    ///
    /// [`FirstFrame::DropRestPose`] does the same.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{DropFirstFrame, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// for frames in [74, 74] {
    ///     let report = DropFirstFrame::new().apply(&mut scene, &StepInput::new())?;
    ///     assert_eq!(report.frames, frames);
    /// }
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation.
    DropFirstFrame {
        /// Whether to drop the first frame even if it is not a rest pose. Default: `false`.
        always: bool = false, ValueKind::Flag;
    }
}

impl Step for DropFirstFrame {
    const NAME: &'static str = "drop-first-frame";
    const HELP: &'static str = "drop the first frame if it is a rest pose, or always";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = FramesReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FramesReport> {
        let first = match self.always {
            true => FirstFrame::Drop,
            false => FirstFrame::DropRestPose,
        };
        converted(scene, input, Conversion::new().first_frame(first))
    }

    /// Does nothing, because the conversion has already recorded the step, so that `verify` can undo it.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}
