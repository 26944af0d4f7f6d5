//! Tables over time and reports for laboratories.

use mocap::Scene;
use mocap::biomechanics::{BodyGait, JointAngles, TimeSeries};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::request::{Answer, json};

/// Columns over time.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Columns {
    Angles,
    Forces,
    Analog,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Report {
    Gait,
    Recorded,
    Solved,
}

/// Returns the names of columns as JSON, and the values row by row as doubles.
pub(crate) fn table(scene: &Scene, columns: Columns) -> Result<Answer, Failure> {
    #[derive(Serialize)]
    #[serde(rename_all = "camelCase")]
    struct Named {
        frame_rate: f64,
        columns: Vec<String>,
        units: Vec<String>,
        notes: Vec<String>,
    }
    let series = match columns {
        Columns::Angles => JointAngles::of(scene)?.into(),
        Columns::Forces => TimeSeries::ground_forces(scene)?,
        Columns::Analog => TimeSeries::analog(scene)?,
    };
    let bytes = series.values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let named = Named {
        frame_rate: series.frame_rate,
        columns: series.columns,
        units: series.units,
        notes: series.notes,
    };
    Ok((json(&named)?, bytes))
}

/// A report as the program prints it with `--json`; `null` if the scene was not solved from markers, or if its file has
/// no such data.
pub(crate) fn report(scene: &Scene, report: Report) -> Result<Answer, Failure> {
    let text = match report {
        Report::Gait => json(&BodyGait::of(scene)?),
        Report::Recorded => json(&scene.metadata.recorded.as_deref()),
        Report::Solved => json(&scene.metadata.solved.as_deref()),
    }?;
    Ok((text, Vec::new()))
}
