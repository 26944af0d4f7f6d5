//! Changes of a motion: a step as text, as the command line takes it.

use std::path::PathBuf;

use mocap::Conversion;
use mocap::convert::FirstFrame;
use mocap::edit::{ContactOptions, EditStep};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::convert::{WriteOptions, up_axis};
use crate::errors::to_python;
use crate::scene::Scene;

/// The scene in metres with +Y up, without a rest pose in its first frame.
#[pyfunction]
pub(crate) fn prepare(
    py: Python<'_>,
    scene: &Scene,
    metres_per_unit: Option<f64>,
    up: Option<&str>,
) -> PyResult<Scene> {
    let mut conversion = Conversion::new().first_frame(FirstFrame::DropRestPose);
    if let Some(metres) = metres_per_unit {
        conversion = conversion.metres_per_unit(metres);
    }
    if let Some(up) = up_axis(up)? {
        conversion = conversion.up(up);
    }
    let mut changed = scene.scene().clone();
    py.detach(|| conversion.apply(&mut changed))
        .map_err(|error| to_python(py, &error))?;
    Ok(Scene::new(changed))
}

/// The scene after a step, and the report as JSON.
#[pyfunction]
pub(crate) fn edit(py: Python<'_>, scene: &Scene, step: &str, other: Option<&Scene>) -> PyResult<(Scene, String)> {
    let mut changed = scene.scene().clone();
    let done = py.detach(|| {
        let step: EditStep = step.parse()?;
        step.apply(&mut changed, 0, other.map(Scene::scene))
    });
    let report = done.map_err(|error| to_python(py, &error))?;
    Ok((Scene::new(changed), json(&report)?))
}

/// When feet and hands are at rest, as JSON. `options` are those of the library, as JSON.
#[pyfunction]
pub(crate) fn contacts(py: Python<'_>, scene: &Scene, options: &str) -> PyResult<String> {
    let options: ContactOptions =
        serde_json::from_str(options).map_err(|error| PyValueError::new_err(error.to_string()))?;
    let found = py.detach(|| mocap::edit::contacts(scene.scene(), 0, None, &options));
    json(&found.map_err(|error| to_python(py, &error))?)
}

/// Writes a scene in the format of the extension.
#[pyfunction]
pub(crate) fn write(py: Python<'_>, scene: &Scene, target: PathBuf, options: WriteOptions) -> PyResult<()> {
    let exporter = options.exporter(&[], &target)?;
    let written = py.detach(|| exporter.export(scene.scene(), &target));
    written.map(drop).map_err(|error| to_python(py, &error))
}

fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| PyValueError::new_err(error.to_string()))
}
