//! Keeps one time range of a motion, and drops the frames before and after it.

use mocap_figure::convert::{Conversion, TimeRange};
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use super::frames_report::{FramesReport, converted};
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

step! {
    /// Keeps one time range of a motion, and drops the frames before and after it.
    ///
    /// [`Conversion::trim`] does the same.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::convert::TimeRange;
    /// use mocap::edit::{Step, StepInput, Trim};
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let range: TimeRange = "0.2..0.5".parse().unwrap();
    /// let report = Trim::new().range(range).apply(&mut scene, &StepInput::new())?;
    /// assert_eq!(report.to_string(), "10 frames, now 4 frames in 0.30 s");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation; the errors of
    /// [`Conversion::apply`] for a range outside the motion.
    Trim {
        /// The first and the last time to keep. Default: the whole motion.
        range: TimeRange = TimeRange::default(), ValueKind::TimeRange;
    }
}

impl Step for Trim {
    const NAME: &'static str = "trim";
    const HELP: &'static str = "keep a part";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = FramesReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FramesReport> {
        converted(scene, input, Conversion::new().trim(self.range.first, self.range.last))
    }

    /// Does nothing, because the conversion has already recorded the step, so that `verify` can undo it.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}
