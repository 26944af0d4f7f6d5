//! Applies edit steps. A step is a JSON object with name and options.

use mocap::Conversion;
use mocap::convert::FirstFrame;
use mocap::edit::report::EditReport;
use mocap::edit::{ContactOptions, EditStep};
use mocap::figure::{Humanoid, HumanoidMap};
use mocap::retarget::apply_steps;
use pyo3::prelude::*;

use crate::convert::up_axis;
use crate::errors::{from_json, invalid, to_python};
use crate::scene::Scene;

/// The scene in metres with +Y up, without a rest pose in its first frame.
#[pyfunction]
pub(crate) fn prepare(
    py: Python<'_>,
    scene: &Scene,
    metres_per_unit: Option<f64>,
    up: Option<&str>,
    bones: Option<&str>,
) -> PyResult<Scene> {
    let bones = bones.map(bones_of).transpose()?.unwrap_or_default();
    let mut conversion = Conversion::new().first_frame(FirstFrame::DropRestPose).bones(bones);
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

/// Applies a step given as JSON. Returns the scene, and the report as JSON. `bones` are the joints of bones, as JSON.
#[pyfunction]
pub(crate) fn edit(
    py: Python<'_>,
    scene: &Scene,
    step: &str,
    other: Option<Py<Scene>>,
    bones: Option<&str>,
) -> PyResult<(Scene, String)> {
    let (changed, reports) = apply(py, scene, vec![parsed(step)?], other.into_iter().collect(), bones)?;
    Ok((changed, json(&reports[0])?))
}

/// Applies all steps of a JSON list. Returns the scene, and the reports as a JSON list. `others` are the second motions
/// of the steps that take one, in order.
#[pyfunction]
pub(crate) fn edit_all(
    py: Python<'_>,
    scene: &Scene,
    steps: &str,
    others: Vec<Py<Scene>>,
    bones: Option<&str>,
) -> PyResult<(Scene, String)> {
    let (changed, reports) = apply(py, scene, parsed(steps)?, others, bones)?;
    Ok((changed, json(&reports)?))
}

fn apply(
    py: Python<'_>,
    scene: &Scene,
    steps: Vec<serde_json::Value>,
    others: Vec<Py<Scene>>,
    bones: Option<&str>,
) -> PyResult<(Scene, Vec<EditReport>)> {
    let mut changed = scene.scene().clone();
    let bones = bones.map(bones_of).transpose()?;
    let done = py.detach(|| {
        let known = bones
            .map(|bones| Humanoid::of(&changed).with_map(&changed, bones))
            .transpose()?;
        let steps = steps
            .iter()
            .map(EditStep::from_value)
            .collect::<mocap::Result<Vec<_>>>()?;
        let others: Vec<_> = others.iter().map(|other| other.get().scene()).collect();
        apply_steps(&mut changed, &steps, &others, known.as_ref())
    });
    let reports = done.map_err(|error| to_python(py, &error))?;
    Ok((Scene::new(changed), reports))
}

/// The contacts of feet and hands, as JSON. `options` are the library's options as JSON.
#[pyfunction]
pub(crate) fn contacts(py: Python<'_>, scene: &Scene, options: &str, bones: Option<&str>) -> PyResult<String> {
    let options: ContactOptions = parsed(options)?;
    let bones = bones.map(bones_of).transpose()?;
    let found = py.detach(|| {
        let scene = scene.scene();
        let known = bones
            .map(|bones| Humanoid::of(scene).with_map(scene, bones))
            .transpose()?;
        options.detect(scene, 0, known.as_ref())
    });
    json(&found.map_err(|error| to_python(py, &error))?)
}

pub(crate) fn parsed<T: serde::de::DeserializeOwned>(json: &str) -> PyResult<T> {
    serde_json::from_str(json).map_err(|error| invalid(error.to_string()))
}

/// Parses the joints of bones.
pub(crate) fn bones_of(json: &str) -> PyResult<HumanoidMap> {
    from_json(json, "bones: ")
}

pub(crate) fn json(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| invalid(error.to_string()))
}
