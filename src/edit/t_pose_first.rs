//! Inserts the T-pose before the first frame of a motion.

use mocap_figure::convert::Conversion;
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use super::frames_report::{FramesReport, converted};
use super::step::step;
use super::{Step, StepInput, StepKey};

step! {
    /// Inserts a frame before the first frame. In the new frame, the figure stands in the T-pose on the floor, at the
    /// point over which the motion starts.
    ///
    /// [`Conversion::t_pose_first`] does the same.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Step, StepInput, TPoseFirst};
    ///
    /// let mut scene = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// let report = TPoseFirst::new().apply(&mut scene, &StepInput::new())?;
    /// assert_eq!(report.frames, report.frames_before + 1);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid); [`Code::NoMotion`](mocap_scene::Code::NoMotion) without
    /// this animation.
    TPoseFirst {}
}

impl Step for TPoseFirst {
    const NAME: &'static str = "t-pose-first";
    const HELP: &'static str = "put the T-pose before the first frame";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = FramesReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FramesReport> {
        converted(scene, input, Conversion::new().t_pose_first(true))
    }

    /// Does nothing, because the conversion has already recorded the step with the bones.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}
