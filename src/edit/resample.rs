//! Changes the frame rate.

use mocap_figure::convert::Conversion;
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use super::frames_report::{FramesReport, converted};
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Gives a motion another frame rate. The speed of the motion does not change.
    ///
    /// [`Conversion::frame_rate`] does the same.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Resample, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?; // 75 frames at 120 a second
    /// let report = Resample::new().rate(30.0).apply(&mut scene, &StepInput::new())?;
    /// assert_eq!(report.frames, 19);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation; the errors of
    /// [`Conversion::apply`] for an impossible rate.
    Resample {
        /// Frames per second. Default: 30.
        rate: f64 = 30.0, ValueKind::Hertz;
    }
}

impl Step for Resample {
    const NAME: &'static str = "resample";
    const HELP: &'static str = "change the frame rate";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = FramesReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FramesReport> {
        converted(scene, input, Conversion::new().frame_rate(self.rate))
    }

    /// Does nothing, because the conversion has already recorded the step, so that `verify` can undo it.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}
