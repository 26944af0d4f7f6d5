//! A motion file to animated glTF.

use std::path::PathBuf;

use mocap::scene::{Topic, UpAxis};
use mocap::{SkeletonMesh, gltf, process, skeleton};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::ReadOptions;
use crate::errors::to_python;

/// Reads `source`, brings it to metres with +Y up, and writes `target`; returns the bytes written.
#[pyfunction]
pub(crate) fn convert(
    py: Python<'_>,
    source: PathBuf,
    target: PathBuf,
    metres_per_unit: Option<f64>,
    up: Option<&str>,
    fps: Option<f64>,
    read: ReadOptions,
) -> PyResult<u64> {
    let up = match up {
        None => None,
        Some("y") => Some(UpAxis::Y),
        Some("z") => Some(UpAxis::Z),
        Some(other) => return Err(PyValueError::new_err(format!("up {other:?} is none of y, z"))),
    };
    let importer = read.importer()?.skeleton_mesh(SkeletonMesh::Skinned);
    let written = py.detach(|| {
        let mut scene = importer.import(&source)?;
        let guess = skeleton::survey(&scene);
        if let Some(fps) = fps {
            process::resample(&mut scene, fps);
        }
        let stated = metres_per_unit.or(scene.metadata.metres_per_unit);
        let topics = [(Topic::Unit, stated.is_none()), (Topic::Up, up.is_none())];
        for assumption in guess.assumptions() {
            if topics
                .iter()
                .any(|(topic, guessed)| *guessed && assumption.topic == *topic)
            {
                scene.metadata.assumptions.push(assumption);
            }
        }
        let metres = stated.unwrap_or_else(|| guess.unit.value.metres());
        process::convert_units(&mut scene, metres, up.unwrap_or(guess.up.value));
        gltf::export(&scene, &target, &gltf::Options::default())
    });
    written
        .map(|written| written.bytes as u64)
        .map_err(|error| to_python(py, &error))
}
