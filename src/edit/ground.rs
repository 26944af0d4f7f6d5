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
    /// Puts a motion on the floor at height 0. It removes the slope of the floor and the drift of the body as `clean`
    /// does, and then the height, however small. Hills, stairs and treadmills do not change:
    /// `docs/cleaning-algorithm.md` describes their detection.
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
    const HELP: &'static str = "put on the floor: remove its height and slope, and the drift of the body";
    const KEYS: &'static [StepKey] = Self::OPTIONS;
    const TAKES_BONES: bool = true;
    type Report = GroundReport;

    fn change(&self, scene: &mut Scene, input: &StepInput<'_>) -> Result<GroundReport> {
        let figure = figure_of(scene, input.bones())?;
        let [height, slope, drift] = put_on_floor(scene, &figure, input.animation)?;
        Ok(GroundReport { height, slope, drift })
    }
}

/// What [`Ground`] took out.
///
/// [`Ground`](crate::Ground) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GroundReport {
    /// The height of the floor in metres; `None` where no foot is ever slow.
    pub height: Option<f64>,
    /// The slope of the floor in degrees.
    pub slope: Option<f64>,
    /// How far the body drifted, in metres.
    pub drift: Option<f64>,
}

impl fmt::Display for GroundReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(height) = self.height else {
            return f.write_str("nothing: no foot is slow enough to show the floor");
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
