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
mod graph;
mod ik;
mod packed;
mod picture;
mod retarget;
mod robot;
mod run;
mod scene;
mod search;
mod survey;

use std::path::PathBuf;

use mocap::figure::Unit;
use mocap::job::Reading;
use mocap::solve::Lengths;
use mocap::{Clips, Format, Importer, RootOffset, SkeletonMesh};
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
    use super::convert::convert;
    #[pymodule_export]
    use super::edit::{contacts, edit, edit_all, prepare, write};
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
    use super::survey::{Survey, examine, extensions, survey};
    #[pymodule_export]
    use super::{metres_in, read, read_bytes};

    #[pymodule_init]
    fn init(_: &Bound<'_, PyModule>) -> PyResult<()> {
        mocap::spell_options(super::spelling);
        Ok(())
    }
}

/// What an option of a job is called in Python: `max-error` is `max_error`.
fn spelling(key: &str) -> String {
    match key {
        "map" => "bones".to_owned(),
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

/// Metres in one unit of this name.
#[pyfunction]
fn metres_in(unit: &str) -> PyResult<f64> {
    Unit::named(unit).map(Unit::metres).ok_or_else(|| {
        let names = Unit::ALL.map(Unit::as_str).join(", ");
        invalid(format!(
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
    lengths: Option<String>,
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
        let importer = self.reading()?.importer();
        Ok(importer.hash(self.hash).skeleton_mesh(SkeletonMesh::None))
    }

    /// The options as a job has them.
    pub(crate) fn reading(&self) -> PyResult<Reading> {
        let mut reading = Reading::default();
        reading.root_offset = match self.root_offset.as_str() {
            "auto" => RootOffset::Auto,
            "replace" => RootOffset::Replace,
            "add" => RootOffset::Add,
            other => {
                let message = format!("root_offset must be auto, replace or add, got {other:?}");
                return Err(invalid(message));
            }
        };
        if let Some(format) = &self.format {
            let format: mocap::Result<Format> = format.parse();
            reading.from = Some(format.map_err(|error| Python::attach(|py| to_python(py, &error)))?);
        }
        reading.clip = match &self.clip {
            Some(Clip::Number(number)) => Clips::Index(*number),
            Some(Clip::Name(name)) => Clips::Name(name.clone()),
            None => Clips::All,
        };
        let text = |path: &Option<PathBuf>| path.as_ref().map(|path| path.to_string_lossy().into_owned());
        reading.joints = text(&self.joints);
        reading.lengths = match self.lengths.as_deref() {
            None => None,
            Some("median") => Some(Lengths::Median),
            Some("moving") => Some(Lengths::Moving),
            Some(other) => {
                let message = format!("lengths must be median or moving, got {other:?}");
                return Err(invalid(message));
            }
        };
        reading.markers = text(&self.markers);
        reading.skeleton.clone_from(&self.skeleton);
        reading.static_trial.clone_from(&self.static_trial);
        reading.body.clone_from(&self.body);
        reading.all_rows = self.all_rows;
        reading.strict = self.strict;
        reading.retime = self.retime;
        Ok(reading)
    }
}

/// The library's options from the JSON that `mocap.Options` writes.
pub(crate) fn options_from(json: &str) -> PyResult<mocap::arrays::ArrayOptions> {
    from_json(json, "options: ")
}
