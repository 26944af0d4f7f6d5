//! Changes the rest pose.

use std::fmt;

use mocap_figure::convert::{Conversion, RestPoseSource};
use mocap_scene::error::Result;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::frames_report::converted;
use super::step::step;
use super::{Step, StepInput, StepKey, ValueKind};

/// A pose of a figure that stands: [`Rest`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum StandingPose {
    /// The arms are horizontal, to the sides.
    #[default]
    TPose,
    /// The arms are to the sides, 45 degrees below horizontal.
    APose,
}

impl From<StandingPose> for RestPoseSource {
    fn from(pose: StandingPose) -> Self {
        match pose {
            StandingPose::TPose => Self::TPose,
            StandingPose::APose => Self::APose,
        }
    }
}

step! {
    /// Makes the T-pose or the A-pose the rest pose. The motion does not change.
    ///
    /// [`Conversion::rest`] does the same.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Rest, Step, StepInput};
    /// use mocap::figure::Figure;
    /// use mocap::figure::report::RestPose;
    ///
    /// let mut scene = mocap::import("fixtures/real/rokoko_dance.bvh")?;
    /// let report = Rest::new().apply(&mut scene, &StepInput::new())?;
    /// assert_eq!(report.to_string(), "the rest pose is the T-pose");
    /// assert_eq!(Figure::new(&scene).rest_pose.value, RestPose::TPose);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid); [`Code::NoMotion`](mocap_scene::Code::NoMotion) without
    /// this animation.
    Rest {
        /// The pose. Default: the T-pose.
        pose: StandingPose = StandingPose::default(), ValueKind::OneOf(&["t-pose", "a-pose"]);
    }
}

impl Step for Rest {
    const NAME: &'static str = "rest";
    const HELP: &'static str = "make the T-pose the rest pose";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    const IS_OF_SKELETON: bool = true;
    type Report = RestReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<RestReport> {
        converted(scene, input, Conversion::new().rest(self.pose.into()))?;
        Ok(RestReport { pose: self.pose })
    }

    /// Does nothing, because the motion does not change.
    fn record(&self, _: &mut Scene, _: &StepInput<'_>) {}
}

/// The report of a step: [`Rest`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RestReport {
    /// The new rest pose.
    pub pose: StandingPose,
}

impl fmt::Display for RestReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.pose {
            StandingPose::TPose => "the rest pose is the T-pose",
            StandingPose::APose => "the rest pose is the A-pose",
        })
    }
}
