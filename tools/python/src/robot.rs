//! Motions on robots.

use std::path::PathBuf;
use std::sync::Arc;

use mocap::retargeting::{Retargeting, RetargetingOptions, Target};
use mocap::{Conversion, Importer};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::to_python;
use crate::scene::Scene;

/// A robot of URDF or MJCF.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct Robot {
    robot: Arc<mocap::robot::Robot>,
}

#[pymethods]
impl Robot {
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let robot = py.detach(|| Importer::new().import_robot(&path));
        let robot = robot.map_err(|error| to_python(py, &error))?;
        Ok(Self { robot: Arc::new(robot) })
    }

    #[getter]
    fn name(&self) -> &str {
        &self.robot.name
    }

    #[getter]
    fn dof_names(&self) -> Vec<String> {
        self.robot.dof_names()
    }

    /// The first motion of a scene on the robot: arrays, and the report as JSON.
    fn retarget<'py>(
        &self,
        py: Python<'py>,
        source: &Scene,
        fps: Option<f64>,
        lock_feet: bool,
        velocity_limits: bool,
        passes: u8,
    ) -> PyResult<(Bound<'py, PyDict>, String)> {
        let done = py.detach(|| {
            let mut scene = source.scene().clone();
            scene.animations.truncate(1);
            let conversion = match fps {
                Some(rate) => Conversion::new().frame_rate(rate),
                None => Conversion::new(),
            };
            let options = RetargetingOptions::new()
                .conversion(conversion)
                .lock_feet(lock_feet)
                .velocity_limits(velocity_limits)
                .passes(passes);
            Retargeting::new(scene, Target::Robot(Arc::clone(&self.robot)), options)
        });
        let clips = done.map_err(|error| to_python(py, &error))?.into_clips();
        let mut clips = clips
            .into_iter()
            .filter_map(|clip| Some((clip.robot_motion?, clip.report)));
        let (motion, report) = clips
            .next()
            .expect("the source has a motion, and the target is a robot");
        let frames = motion.frames();
        let joints = motion.dof_names.len();
        let arrays = PyDict::new(py);
        let add = |name: &str, values: Vec<f64>, columns: usize| {
            arrays.set_item(name, PyArray1::from_vec(py, values).reshape([frames, columns])?)
        };
        add("root_pos", motion.root_pos(), 3)?;
        add("root_rot", motion.root_rot(), 4)?;
        add("qpos", motion.qpos(), 7 + joints)?;
        let contacts: Vec<bool> = motion.contacts.iter().flatten().copied().collect();
        arrays.set_item("contacts", PyArray1::from_vec(py, contacts).reshape([frames, 2])?)?;
        add("dof_pos", motion.dof_pos, joints)?;
        arrays.set_item("fps", motion.fps)?;
        let report = serde_json::to_string(&report).map_err(|error| PyValueError::new_err(error.to_string()))?;
        Ok((arrays, report))
    }
}
