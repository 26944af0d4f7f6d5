//! Databases of motions for search.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use mocap::convert::{Moment, TimeRange};
use mocap::files::{ReplacePolicy, write_file};
use mocap::matching::{FindOptions, IndexedClip, Query};
use mocap::survey::Condition;
use mocap::{Code, Diagnostic, Error};
use numpy::PyArray1;
use pyo3::prelude::*;
use serde_json::json;

use crate::ReadOptions;
use crate::errors::to_python;
use crate::scene::Scene;

/// Clips with the features of their frames.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct Database {
    database: mocap::matching::Database,
}

#[pymethods]
impl Database {
    fn __len__(&self) -> usize {
        self.database.clips().len()
    }

    /// The rows of the clips with their ranges of frames.
    fn clips_json(&self) -> String {
        let mut first = 0;
        let rows = self.database.clips().iter().map(|clip| {
            let frames = clip.features().len();
            first += frames;
            json!({
                "row": clip.row, "mirrored": clip.mirrored, "packed": clip.is_packed(),
                "begin": clip.begin, "first": first - frames, "frames": frames,
            })
        });
        serde_json::Value::from_iter(rows).to_string()
    }

    /// The features of all frames, frame by frame.
    fn features<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        PyArray1::from_vec(py, self.database.features().flatten().copied().collect())
    }

    /// The contacts of all frames.
    fn contacts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        let clips = self.database.clips().iter();
        PyArray1::from_vec(py, clips.flat_map(IndexedClip::contacts).copied().collect())
    }

    /// Finds the parts most similar to a part of an animation, or to the pose at its begin, as JSON.
    #[expect(clippy::too_many_arguments, reason = "Python hands them over by name")]
    #[pyo3(signature = (scene, animation, part, is_pose, count, per_clip, mirror, condition))]
    fn find(
        &self,
        py: Python<'_>,
        scene: &Scene,
        animation: usize,
        part: (Option<f64>, Option<f64>),
        is_pose: bool,
        count: usize,
        per_clip: Option<usize>,
        mirror: bool,
        condition: Option<&str>,
    ) -> PyResult<String> {
        let condition: Option<Condition> = condition
            .map(str::parse)
            .transpose()
            .map_err(|error: Error| to_python(py, &error))?;
        let options = FindOptions::new().count(count).per_clip(per_clip);
        let options = options.mirror(mirror).condition(condition);
        let found = py.detach(|| -> mocap::Result<_> {
            let mut range = TimeRange::default();
            (range.first, range.last) = (part.0.map(Moment::Seconds), part.1.map(Moment::Seconds));
            let query = match range.first.filter(|_| is_pose) {
                Some(at) => Query::pose(scene.scene(), animation, at)?,
                None => Query::part(scene.scene(), animation, range)?,
            };
            Ok(self.database.find(&query, &options))
        });
        let found = found.map_err(|error| to_python(py, &error))?;
        Ok(json!(found).to_string())
    }

    /// Writes the file.
    fn write(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let written = py.detach(|| {
            let clips = self.database.clips().iter().map(|clip| Path::new(&clip.row.file));
            ReplacePolicy::new(clips).force(overwrite).check(&path)?;
            write_file(&path, &self.database.to_bytes())
        });
        written.map_err(|error| to_python(py, &error))
    }
}

/// Reads the file of a database.
#[pyfunction]
pub(crate) fn read_database(py: Python<'_>, path: PathBuf) -> PyResult<Database> {
    let read = py.detach(|| {
        let file = File::open(&path).map_err(|error| Error::from(Diagnostic::new(Code::Io, error.to_string())));
        let database = file.and_then(|file| mocap::matching::Database::read(BufReader::new(file)));
        database.map_err(|error| error.with_path(&path))
    });
    let database = read.map_err(|error| to_python(py, &error))?;
    Ok(Database { database })
}

/// Indexes files. A file without a motion of a humanoid with two feet is an error.
#[pyfunction]
pub(crate) fn index(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    mirror: bool,
    pack: bool,
    read: ReadOptions,
) -> PyResult<Database> {
    let importer = read.importer()?;
    let clips = py.detach(|| -> mocap::Result<Vec<IndexedClip>> {
        let mut clips = Vec::new();
        for path in &paths {
            let (scene, name) = (importer.import(path)?, path.to_string_lossy());
            let found = match pack {
                true => IndexedClip::packed_read(scene, &name, mirror).map_err(|error| error.with_path(path))?,
                false => IndexedClip::of_read(scene, &name, mirror),
            };
            if found.is_empty() {
                let diagnostic =
                    Diagnostic::new(Code::NotHumanoid, "the file has no motion of a humanoid with two feet");
                return Err(Error::from(diagnostic).with_path(path));
            }
            clips.extend(found);
        }
        Ok(clips)
    });
    let clips = clips.map_err(|error| to_python(py, &error))?;
    Ok(Database {
        database: mocap::matching::Database::new(clips),
    })
}
