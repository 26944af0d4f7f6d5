//! Puts a motion on the floor.

use std::fmt;

use mocap_scene::error::Result;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::body::figure_of;
use super::floor::put_on_floor;
use super::quantity::{centimetres, degrees};
use super::step::step;
use super::{Step, StepInput, StepKey};

step! {
    /// Puts a motion on the floor at height 0. The step removes the slope of the floor and the drift of the body, as
    /// `clean` does. Then it moves the figure so that the floor is exactly at height 0. The slope of a hill or of
    /// stairs, and the drift on a treadmill, do not change: `docs/cleaning-algorithm.md` describes how mocap detects
    /// them.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::edit::{Ground, Step, StepInput};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// let report = Ground::new().apply(&mut scene, &StepInput::new())?;
    /// assert_eq!(report.slope, None); // the floor of a laboratory is level
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::NotHumanoid`](mocap_scene::Code::NotHumanoid); [`Code::NoMotion`](mocap_scene::Code::NoMotion) without
    /// this animation.
    Ground {}
}

impl Step for Ground {
    const NAME: &'static str = "ground";
    const HELP: &'static str =
        "put the body on the floor: remove the floor's height and slope, and the drift of the body";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = GroundReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<GroundReport> {
        let figure = figure_of(scene, input.bones())?;
        let [height, slope, drift] = put_on_floor(scene, &figure, input.animation)?;
        Ok(GroundReport { height, slope, drift })
    }
}

/// The report of [`Ground`].
///
/// [`Ground`](crate::Ground) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GroundReport {
    /// The height of the floor that the step removed, in metres. `None` if no foot is ever slow, so that the floor is
    /// unknown.
    pub height: Option<f64>,
    /// The slope of the floor that the step removed, in degrees. `None` if it removed none.
    pub slope: Option<f64>,
    /// The drift of the body over the ground that the step removed, in metres. `None` if it removed none.
    pub drift: Option<f64>,
}

impl fmt::Display for GroundReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(height) = self.height else {
            return f.write_str("nothing: no foot ever rests, so the height of the floor is unknown");
        };
        let of = |value: Option<String>| value.unwrap_or_else(|| "none".to_owned());
        write!(
            f,
            "the floor was at {}; removed slope: {}; removed drift: {}",
            centimetres(height),
            of(self.slope.map(degrees)),
            of(self.drift.map(centimetres))
        )
    }
}
