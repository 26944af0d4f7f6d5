//! Motion graphs: transitions between motions, and walks over them.

use std::path::{Path, PathBuf};

use mocap::files::{ReplacePolicy, write_file};
use mocap::job::{FileGraph, GraphJobOptions, SourceSpace, WalkOptions};
use numpy::PyArray1;
use pyo3::prelude::*;
use serde_json::json;

use crate::ReadOptions;
use crate::errors::{from_json, invalid, to_python};
use crate::scene::Scene;

/// A motion graph with its clips.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct Graph {
    found: FileGraph,
}

#[pymethods]
impl Graph {
    /// The options, the body and the clips.
    fn about_json(&self) -> String {
        let graph = self.found.graph();
        json!({"options": graph.options, "body": graph.body, "clips": graph.clips}).to_string()
    }

    /// The transitions, four numbers each: source clip and frame, target clip and frame.
    fn transitions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let transitions = self.found.graph().transitions.iter();
        let numbers = transitions.flat_map(|transition| [transition.from, transition.to].into_iter().flatten());
        PyArray1::from_vec(py, numbers.map(|number| number as i64).collect())
    }

    /// The distance of each transition.
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        let transitions = self.found.graph().transitions.iter();
        PyArray1::from_vec(py, transitions.map(|transition| transition.distance).collect())
    }

    /// The numbers of rows and columns and the values of the distance matrix of two clips.
    fn matrix<'py>(
        &self,
        py: Python<'py>,
        first: usize,
        second: usize,
    ) -> PyResult<(usize, usize, Bound<'py, PyArray1<f32>>)> {
        let matrix = py.detach(|| self.found.builder().matrix(first, second));
        let matrix = matrix.map_err(|error| to_python(py, &error))?;
        Ok((matrix.rows, matrix.columns, PyArray1::from_vec(py, matrix.values)))
    }

    /// The motion of a walk, and the report as JSON.
    fn walk(&self, py: Python<'_>, walking: &str) -> PyResult<(Scene, String)> {
        let walking: WalkOptions = from_json(walking, "")?;
        let made = py.detach(|| self.found.walk(&walking));
        let (scene, report) = made.map_err(|error| to_python(py, &error))?;
        let report = serde_json::to_string(&report).map_err(|error| invalid(error.to_string()))?;
        Ok((Scene::new(scene), report))
    }

    /// Writes the file.
    fn write(&self, py: Python<'_>, path: PathBuf, overwrite: bool) -> PyResult<()> {
        let written = py.detach(|| {
            let graph = self.found.graph();
            let files = graph.clips.iter().map(|clip| clip.file.as_str());
            let files = files.chain(graph.body.iter().map(|(file, _)| file.as_str()));
            let bytes = graph.to_json().into_bytes();
            let policy = ReplacePolicy::new(files.map(Path::new)).force(overwrite);
            policy.check_ahead(&path)?;
            policy.check_bytes(&path, &bytes)?;
            write_file(&path, &bytes)
        });
        written.map_err(|error| to_python(py, &error))
    }
}

/// Compares the motions of files.
#[pyfunction]
pub(crate) fn graph(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    graphing: &str,
    space: &str,
    read: ReadOptions,
) -> PyResult<Graph> {
    let (graphing, space): (GraphJobOptions, SourceSpace) = (from_json(graphing, "")?, from_json(space, "")?);
    let read = read.reading()?;
    let found = py.detach(|| FileGraph::compare(&graphing, &read, &space, &paths));
    let found = found.map_err(|error| to_python(py, &error))?;
    Ok(Graph { found })
}

/// Reads the file of a graph and its clips.
#[pyfunction]
pub(crate) fn read_graph(py: Python<'_>, path: PathBuf, space: &str, read: ReadOptions) -> PyResult<Graph> {
    let (space, read): (SourceSpace, _) = (from_json(space, "")?, read.reading()?);
    let found = py.detach(|| FileGraph::open(&path, &read, &space));
    let found = found.map_err(|error| to_python(py, &error))?;
    Ok(Graph { found })
}
