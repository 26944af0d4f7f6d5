//! Removes the motion of the root over the ground.

use mocap_figure::convert::{Conversion, RootMotion};
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;

use super::frames_report::{FramesReport, converted};
use super::step::step;
use super::{Step, StepInput, StepKey};

step! {
    /// Keeps the root above the point over which it starts. The height and the rotation of the root do not change.
    ///
    /// [`RootMotion::InPlace`] does the same.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{InPlace, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// InPlace::new().apply(&mut scene, &StepInput::new())?;
    /// let positions = &scene.animations[0].channels[0].position_keys.values;
    /// assert!(positions.iter().all(|at| at.x == positions[0].x && at.z == positions[0].z));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NoMotion`](mocap_scene::Code::NoMotion) if the scene lacks the animation.
    InPlace {}
}

impl Step for InPlace {
    const NAME: &'static str = "in-place";
    const HELP: &'static str = "remove the motion of the root over the ground";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    type Report = FramesReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<FramesReport> {
        converted(scene, input, Conversion::new().root(RootMotion::InPlace))
    }

    /// Does nothing, because the conversion has already recorded the step, so that `verify` can undo it.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}
