//! The native module of the Python package `mocap`: reading, kinematics and Arrow tables, without the GIL. The Python
//! modules in `python/mocap` have the signatures and the documentation.

#![allow(
    clippy::needless_pass_by_value,
    reason = "Python hands over what it made of the arguments"
)]

mod arrow;
mod command;
mod convert;
mod dataset;
mod edit;
mod errors;
mod graph;
mod ik;
mod packed;
mod picture;
mod retarget;
mod robot;
mod run;
mod scene;
mod search;
mod skin;
mod survey;

use std::path::PathBuf;

use mocap::figure::Unit;
use mocap::job::{InputOptions, Job, JobWeights, MotionJob};
use mocap::{Importer, SkeletonMesh};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::errors::{from_json, invalid, to_python};

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

#[pymodule]
mod _mocap {
    #[pymodule_export]
    use super::arrow::{ArrowTable, table};
    #[pymodule_export]
    use super::command::main;
    #[pymodule_export]
    use super::convert::{convert, write_scene};
    #[pymodule_export]
    use super::dataset::write_dataset;
    #[pymodule_export]
    use super::edit::{contacts, edit, edit_all, prepare};
    #[pymodule_export]
    use super::graph::{Graph, graph, read_graph};
    #[pymodule_export]
    use super::ik::{bend, chain, two_bone};
    #[pymodule_export]
    use super::packed::{PackedClip, pack};
    #[pymodule_export]
    use super::picture::{Picture, page, plot, sheet};
    #[pymodule_export]
    use super::retarget::{add_motions, retarget};
    #[pymodule_export]
    use super::robot::{Robot, RobotClip, RobotStream};
    #[pymodule_export]
    use super::run::run;
    #[pymodule_export]
    use super::scene::{Node, Scene, scene_of};
    #[pymodule_export]
    use super::search::{Database, index, read_database};
    #[pymodule_export]
    use super::skin::{Skin, skin};
    #[pymodule_export]
    use super::survey::{Survey, examine, extensions, survey};
    #[pymodule_export]
    use super::{metres_in, read, read_bytes};

    /// Sets Python's names of options for messages, and loads the record of earlier outputs, as the program does.
    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        mocap::spell_options(super::spelling);
        mocap::job::remember_outputs(|_| {});
        Ok(())
    }
}

/// The name of a job's option in Python: `max-error` is `max_error`.
fn spelling(key: &str) -> String {
    match key {
        "map" => "bones".to_owned(),
        "target" => "fbx_target".to_owned(),
        "force" => "overwrite".to_owned(),
        "from" => "format".to_owned(),
        key => key.replace('-', "_"),
    }
}

/// Reads a file.
#[pyfunction]
fn read(py: Python<'_>, path: PathBuf, options: ReadOptions) -> PyResult<scene::Scene> {
    let importer = options.importer()?;
    let scene = py.detach(|| importer.import(&path));
    scene.map(scene::Scene::new).map_err(|error| to_python(py, &error))
}

/// Reads the bytes of a file.
#[pyfunction]
fn read_bytes(py: Python<'_>, data: PyBackedBytes, name: &str, options: ReadOptions) -> PyResult<scene::Scene> {
    let importer = options.importer()?;
    let scene = py.detach(|| importer.read(&data, name));
    scene.map(scene::Scene::new).map_err(|error| to_python(py, &error))
}

/// The length of a unit in metres.
#[pyfunction]
fn metres_in(unit: &str) -> PyResult<f64> {
    Unit::named(unit).map(Unit::metres).ok_or_else(|| {
        let names = Unit::ALL.map(Unit::as_str).join(", ");
        invalid(format!(
            "unit must be one of {names}, or metres as a number, got {unit:?}"
        ))
    })
}

/// The options of the reader; see `mocap.ReadOptions`.
#[derive(FromPyObject)]
pub(crate) struct ReadOptions {
    /// The part `read` of a job.
    json: String,
    hash: bool,
}

impl ReadOptions {
    pub(crate) fn importer(&self) -> PyResult<Importer> {
        let importer = self.reading()?.importer();
        Ok(importer.hash(self.hash).skeleton_mesh(SkeletonMesh::None))
    }

    /// The options in the form of a job.
    pub(crate) fn reading(&self) -> PyResult<InputOptions> {
        motion_job(&format!(r#"{{"read":{}}}"#, self.json)).map(|job| job.read)
    }
}

/// Parses the JSON of a job from Python.
pub(crate) fn motion_job(json: &str) -> PyResult<MotionJob> {
    match Job::from_json(json) {
        Ok(Job::Motion(job)) => Ok(job),
        Ok(_) => Err(invalid("the job does not make a motion")),
        Err(error) => Err(invalid(in_job(&error.diagnostic().message))),
    }
}

/// The weights of solvers in the form of a job.
pub(crate) fn weights_of(json: &str) -> PyResult<JobWeights> {
    let weights = motion_job(&format!(r#"{{"weights": {json}}}"#))?.weights;
    weights
        .check()
        .map_err(|error| invalid(error.diagnostic().message.clone()))?;
    Ok(weights)
}

/// Rewrites an error about a value of a job. The message names only the option, because a Python user does not see the
/// job.
fn in_job(message: &str) -> String {
    let message = message.strip_prefix("the job: ").unwrap_or(message);
    let (path, what) = message.split_once(": ").unwrap_or(("", message));
    let what = what.rsplit_once(" at line ").map_or(what, |(what, _)| what);
    let what = what.replacen("a motion job has no", "there is no", 1);
    let name = path.rsplit('.').next().unwrap_or_default().replace('-', "_");
    format!("{name}: {what}")
}

/// Parses the library's options from the JSON of `mocap.Options`.
pub(crate) fn options_from(json: &str) -> PyResult<mocap::arrays::ArrayOptions> {
    from_json(json, "options: ")
}
