//! Moves the motion over the ground to a new joint.

use mocap_figure::convert::{Conversion, RootMotion};
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use super::frames_report::{FramesReport, converted};
use super::step::step;
use super::{Step, StepInput, StepKey};

step! {
    /// Takes the horizontal motion away from the root and gives it to a new joint, which becomes the parent of the
    /// root.
    ///
    /// [`RootMotion::Extract`] does the same.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{ExtractRoot, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// ExtractRoot::new().apply(&mut scene, &StepInput::new())?;
    /// assert_eq!((&*scene.nodes[0].name, &*scene.nodes[1].name), ("Root", "Hips"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation.
    ExtractRoot {}
}

impl Step for ExtractRoot {
    const NAME: &'static str = "root-motion";
    const HELP: &'static str = "give the horizontal motion of the root to a new parent joint";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const IS_OF_SKELETON: bool = true;
    type Report = FramesReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FramesReport> {
        converted(scene, input, Conversion::new().root(RootMotion::Extract))
    }

    /// Does nothing, because the conversion has already recorded the step, so that `verify` can undo it.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}
