//! The native half of the Python package `mocap`: reading, kinematics and Arrow tables, without the GIL. The other
//! half, in `python/mocap`, has the signatures and the documentation.

#![allow(
    clippy::needless_pass_by_value,
    reason = "Python hands over what it made of the arguments"
)]

mod arrow;
mod convert;
mod edit;
mod errors;
mod retarget;
mod robot;
mod run;
mod scene;

use std::path::PathBuf;

use mocap::figure::Unit;
use mocap::{Clips, Format, Importer, RootOffset, SkeletonMesh};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

use crate::errors::to_python;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

#[pymodule]
mod _mocap {
    #[pymodule_export]
    use super::arrow::{ArrowTable, table};
    #[pymodule_export]
    use super::convert::convert;
    #[pymodule_export]
    use super::edit::{contacts, edit, prepare, write};
    #[pymodule_export]
    use super::retarget::{add_motions, retarget};
    #[pymodule_export]
    use super::robot::{Robot, RobotClip};
    #[pymodule_export]
    use super::run::run;
    #[pymodule_export]
    use super::scene::{Node, Scene};
    #[pymodule_export]
    use super::{metres_in, read, read_bytes};
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

/// Metres in one unit of this name.
#[pyfunction]
fn metres_in(unit: &str) -> PyResult<f64> {
    Unit::named(unit).map(Unit::metres).ok_or_else(|| {
        let names = Unit::ALL.map(Unit::as_str).join(", ");
        PyValueError::new_err(format!(
            "unit must be one of {names}, or metres as a number, got {unit:?}"
        ))
    })
}

/// The options of the reader, as in `mocap.ReadOptions`.
#[derive(FromPyObject)]
pub(crate) struct ReadOptions {
    format: Option<String>,
    root_offset: String,
    all_rows: bool,
    retime: Option<f64>,
    strict: bool,
    hash: bool,
    clip: Option<Clip>,
    skeleton: Option<PathBuf>,
    joints: Option<PathBuf>,
    markers: Option<PathBuf>,
    #[pyo3(attribute("static"))]
    static_trial: Option<PathBuf>,
    body: Option<PathBuf>,
}

/// An animation by its number from 0, or by its name.
#[derive(FromPyObject)]
enum Clip {
    Number(usize),
    Name(String),
}

impl ReadOptions {
    pub(crate) fn importer(&self) -> PyResult<Importer> {
        let root_offset = match self.root_offset.as_str() {
            "auto" => RootOffset::Auto,
            "replace" => RootOffset::Replace,
            "add" => RootOffset::Add,
            other => {
                let message = format!("root_offset must be auto, replace or add, got {other:?}");
                return Err(PyValueError::new_err(message));
            }
        };
        let mut importer = Importer::new()
            .root_offset(root_offset)
            .all_rows(self.all_rows)
            .strict(self.strict)
            .hash(self.hash)
            .skeleton_mesh(SkeletonMesh::None);
        if let Some(format) = &self.format {
            let format: Format = format
                .parse()
                .map_err(|error| Python::attach(|py| to_python(py, &error)))?;
            importer = importer.format(format);
        }
        if let Some(rate) = self.retime {
            importer = importer.retime(rate);
        }
        importer = match &self.clip {
            Some(Clip::Number(number)) => importer.clips(Clips::Index(*number)),
            Some(Clip::Name(name)) => importer.clips(Clips::Name(name.clone())),
            None => importer,
        };
        if let Some(skeleton) = &self.skeleton {
            importer = importer.skeleton(skeleton);
        }
        if let Some(joints) = &self.joints {
            importer = importer.joints(joints.to_string_lossy());
        }
        if let Some(markers) = &self.markers {
            importer = importer.markers(markers.to_string_lossy());
        }
        if let Some(trial) = &self.static_trial {
            importer = importer.static_trial(trial);
        }
        if let Some(body) = &self.body {
            importer = importer.body(body);
        }
        Ok(importer)
    }
}

/// The library's options from the JSON that `mocap.Options` writes.
pub(crate) fn options_from(json: &str) -> PyResult<mocap::arrays::ArrayOptions> {
    serde_json::from_str(json).map_err(|error| {
        // The position in the JSON is of no use to a Python user.
        let message = error.to_string();
        let message = message
            .rsplit_once(" at line ")
            .map_or(message.as_str(), |(what, _)| what);
        PyValueError::new_err(format!("options: {message}"))
    })
}
