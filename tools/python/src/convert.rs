//! A motion file to animated glTF, to FBX or to a VRM animation.

use std::path::PathBuf;

use mocap::files::ReplacePolicy;
use mocap::scene::UpAxis;
use mocap::{Conversion, SkeletonMesh, fbx, gltf, vrma};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::ReadOptions;
use crate::errors::to_python;

/// Reads `source`, converts it to metres with +Y up, and writes `target`; returns the bytes written.
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
    let up = up_axis(up)?;
    let mut conversion = Conversion::new();
    if let Some(metres) = metres_per_unit {
        conversion = conversion.metres_per_unit(metres);
    }
    if let Some(up) = up {
        conversion = conversion.up(up);
    }
    if let Some(fps) = fps {
        conversion = conversion.frame_rate(fps);
    }
    let extension = target.extension().and_then(|extension| extension.to_str());
    let extension = extension.unwrap_or_default().to_ascii_lowercase();
    let is_fbx = extension == "fbx";
    // A skeleton needs no mesh in FBX.
    let mesh = if is_fbx {
        SkeletonMesh::Own
    } else {
        SkeletonMesh::Skinned
    };
    let importer = read.importer()?.skeleton_mesh(mesh).gltf_meshes(is_fbx);
    let written = py.detach(|| {
        ReplacePolicy::new([&source]).check_inputs(&target)?;
        let mut scene = importer.import(&source)?;
        conversion.apply(&mut scene)?;
        Ok(match extension.as_str() {
            "vrma" => vrma::export(&scene, &target, &vrma::VrmaOptions::default())?.bytes,
            "fbx" => fbx::export(&scene, &target, &fbx::FbxOptions::default())?.bytes,
            _ => gltf::export(&scene, &target, &gltf::GltfOptions::default())?.bytes,
        })
    });
    written.map(|bytes| bytes as u64).map_err(|error| to_python(py, &error))
}

/// The axis of this name.
pub(crate) fn up_axis(name: Option<&str>) -> PyResult<Option<UpAxis>> {
    let named = |name: &str| {
        let up = UpAxis::ALL.into_iter().find(|up| up.as_str() == name);
        up.ok_or_else(|| PyValueError::new_err(format!("up must be y, z, -y or -z, got {name:?}")))
    };
    name.map(named).transpose()
}
