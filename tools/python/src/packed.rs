//! Packed clips: decodes poses.

use mocap::Trs;
use mocap::compress::PackedClip as Clip;
use mocap::glam::Mat4;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyBytes;

use crate::errors::{invalid, to_python};
use crate::scene::{Scene, rows};

#[pyclass(frozen, module = "mocap")]
pub(crate) struct PackedClip {
    clip: Clip<'static>,
}

/// Packs the first motion of a scene. Lengths are in the unit of the scene.
#[pyfunction]
pub(crate) fn pack(py: Python<'_>, scene: &Scene, max_error: f64) -> PyResult<PackedClip> {
    if !(max_error.is_finite() && max_error > 0.0) {
        return Err(invalid(format!(
            "max_error must be finite and above 0, got {max_error}"
        )));
    }
    let packed = py.detach(|| Clip::encode(scene.scene(), 0, max_error));
    let clip = packed.map_err(|error| to_python(py, &error))?;
    Ok(PackedClip { clip })
}

#[pymethods]
impl PackedClip {
    #[new]
    fn new(py: Python<'_>, data: PyBackedBytes) -> PyResult<Self> {
        let clip = Clip::new(data.to_vec()).map_err(|error| to_python(py, &error))?;
        Ok(Self { clip })
    }

    fn data<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.clip.bytes())
    }

    #[getter]
    fn names(&self) -> Vec<&str> {
        (0..self.clip.node_count()).map(|node| self.clip.name(node)).collect()
    }

    #[getter]
    fn parents(&self) -> Vec<i64> {
        let parent = |node| self.clip.parent(node).map_or(-1, |parent| parent as i64);
        (0..self.clip.node_count()).map(parent).collect()
    }

    #[getter]
    fn frames(&self) -> usize {
        self.clip.frame_count()
    }

    #[getter]
    fn duration(&self) -> f64 {
        self.clip.duration()
    }

    #[getter]
    fn ticks_per_second(&self) -> f64 {
        self.clip.ticks_per_second()
    }

    #[getter]
    fn max_error(&self) -> f64 {
        self.clip.max_error()
    }

    fn pose_matrices<'py>(&self, py: Python<'py>, tick: f64, world: bool) -> PyResult<Bound<'py, PyAny>> {
        let mut pose = vec![Trs::IDENTITY; self.clip.node_count()];
        self.clip.sample(tick, &mut pose);
        let mut matrices: Vec<Mat4> = pose.iter().map(Trs::matrix).collect();
        if world {
            for node in 0..matrices.len() {
                // Parents precede their children.
                if let Some(parent) = self.clip.parent(node) {
                    matrices[node] = matrices[parent] * matrices[node];
                }
            }
        }
        let values: Vec<f32> = matrices.iter().flat_map(rows).collect();
        Ok(PyArray1::from_vec(py, values)
            .reshape([matrices.len(), 4, 4])?
            .into_any())
    }
}
