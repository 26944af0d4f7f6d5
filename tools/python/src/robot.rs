//! Retargets motions to robots.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use mocap::figure::{Humanoid, HumanoidMap};
use mocap::files::ReplacePolicy;
use mocap::glam::Mat4;
use mocap::job::RobotFormat;
use mocap::retarget::robot::report::{Floor, TimeScale};
use mocap::retarget::robot::{RobotMotion, RobotOptions, RobotRetargeter, SmoothRobotStream};
use mocap::retarget::{RetargetOptions, Retargeter, Target};
use mocap::{Conversion, Importer, Pose};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::edit::{json, parsed};
use crate::errors::{invalid, to_python};
use crate::scene::Scene;
use crate::weights_of;

/// A robot of URDF or MJCF.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct Robot {
    robot: Arc<mocap::retarget::robot::Robot>,
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

    /// Retargets the first motion of a scene. Returns arrays, the report as JSON, and an object that writes files.
    /// `map` has the links of bones, and `bones` the joints of the source's bones, both as JSON.
    #[expect(clippy::too_many_arguments, reason = "the options by name, as Python gives them")]
    fn retarget<'py>(
        &self,
        py: Python<'py>,
        source: &Scene,
        fps: Option<f64>,
        lock_feet: bool,
        velocity_limits: bool,
        passes: u8,
        floor: &str,
        time_scale: &str,
        map: Option<&str>,
        bones: Option<&str>,
        weights: &str,
    ) -> PyResult<(Bound<'py, PyDict>, String, RobotClip)> {
        let map: HumanoidMap = map.map_or(Ok(HumanoidMap::new()), parsed)?;
        let bones: HumanoidMap = bones.map_or(Ok(HumanoidMap::new()), parsed)?;
        let (floor, weights) = (floor_of(floor)?, weights_of(weights)?);
        let time_scale = TimeScale::from_str(time_scale)
            .map_err(|expected| invalid(format!("time_scale: {expected}, got {time_scale}")))?;
        let done = py.detach(|| {
            let mut scene = source.scene().clone();
            scene.animations.truncate(1);
            let conversion = match fps {
                Some(rate) => Conversion::new().frame_rate(rate),
                None => Conversion::new(),
            };
            let options = RetargetOptions::new()
                .conversion(conversion)
                .lock_feet(lock_feet)
                .velocity_limits(velocity_limits)
                .passes(passes)
                .floor(floor)
                .time_scale(time_scale)
                .robot_weights(weights.robot)
                .foot_lock_weights(weights.foot_lock)
                .source_bones(bones)
                .target_bones(map);
            Retargeter::new(scene, Target::Robot(Arc::clone(&self.robot)), options)
        });
        let retargeting = done.map_err(|error| to_python(py, &error))?;
        let clip = &retargeting.clips()[0];
        let motion = clip
            .robot_motion
            .as_ref()
            .expect("the source has a motion, and the target is a robot");
        let arrays = arrays(py, motion)?;
        let report = serde_json::to_string(&clip.report).map_err(|error| invalid(error.to_string()))?;
        Ok((arrays, report, RobotClip { retargeting }))
    }

    /// Scores a motion of the robot, in a scene that was read with it as the body, against its reference. Returns the
    /// report as JSON.
    fn score(&self, py: Python<'_>, reference: &Scene, motion: &Scene, bones: Option<&str>) -> PyResult<String> {
        let bones: HumanoidMap = bones.map_or(Ok(HumanoidMap::new()), parsed)?;
        let found = py.detach(|| {
            let motion = RobotMotion::of_arrays(&self.robot, motion.scene())?;
            let options = RetargetOptions::new().source_bones(bones);
            let judge = Retargeter::onto(Target::Robot(Arc::clone(&self.robot)), options)?;
            judge.judge(reference.scene().clone(), &motion)
        });
        json(&found.map_err(|error| to_python(py, &error))?)
    }

    /// Begins a stream of poses of a scene at `fps` poses per second; `map` and `bones` as for `retarget`.
    #[expect(clippy::too_many_arguments, reason = "the options by name, as Python gives them")]
    fn stream(
        &self,
        py: Python<'_>,
        source: &Scene,
        fps: f64,
        lock_feet: bool,
        passes: u8,
        floor: &str,
        map: Option<&str>,
        bones: Option<&str>,
        weights: &str,
    ) -> PyResult<RobotStream> {
        let map: HumanoidMap = map.map_or(Ok(HumanoidMap::new()), parsed)?;
        let bones: HumanoidMap = bones.map_or(Ok(HumanoidMap::new()), parsed)?;
        let (floor, weights) = (floor_of(floor)?, weights_of(weights)?);
        let begun = py.detach(|| {
            let scene = source.scene();
            let source_bones = Humanoid::of(scene).with_map(scene, bones)?;
            let options = RobotOptions::new()
                .lock_feet(lock_feet)
                .passes(passes)
                .floor(floor)
                .weights(weights.robot)
                .foot_lock(weights.foot_lock)
                .map(map)
                .source(Some(source_bones));
            RobotRetargeter::new(scene, &self.robot, &options)?.stream(scene, fps)
        });
        Ok(RobotStream {
            stream: begun.map_err(|error| to_python(py, &error))?,
            pose: Pose::rest(source.scene()),
        })
    }
}

fn floor_of(name: &str) -> PyResult<Floor> {
    serde_json::from_value(name.into())
        .map_err(|_| invalid(format!("floor must be 'auto', 'z=0' or 'keep', got '{name}'")))
}

/// A stream of poses to a robot.
#[pyclass(module = "mocap")]
pub(crate) struct RobotStream {
    stream: SmoothRobotStream,
    /// The last pose of the source.
    pose: Pose,
}

#[pymethods]
impl RobotStream {
    #[getter]
    fn delay(&self) -> f64 {
        self.stream.delay()
    }

    #[getter]
    fn nodes(&self) -> usize {
        self.pose.node_to_parent.len()
    }

    /// Takes the matrices of all nodes relative to their parents, row by row. Returns the arrays of the finished frame.
    fn push<'py>(
        &mut self,
        py: Python<'py>,
        matrices: PyReadonlyArray3<'py, f32>,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let numbers = matrices.as_slice()?;
        let given = self.pose.node_to_parent.iter_mut().zip(numbers.chunks_exact(16));
        for (node, rows) in given {
            *node = Mat4::from_cols_slice(rows).transpose();
        }
        self.pose.update_world();
        let Self { stream, pose } = self;
        let frame = py.detach(|| stream.push(pose));
        frame.map(|frame| arrays(py, &frame)).transpose()
    }

    /// The remaining frames.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let left = py.detach(|| self.stream.finish());
        arrays(py, &left)
    }

    /// The report of the last 30 s as JSON.
    fn report(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let report = py.detach(|| self.stream.report());
        report.map(|report| json(&report)).transpose()
    }
}

fn arrays<'py>(py: Python<'py>, motion: &RobotMotion) -> PyResult<Bound<'py, PyDict>> {
    let (frames, joints) = (motion.frames(), motion.dof_names.len());
    let arrays = PyDict::new(py);
    let add = |name: &str, values: Vec<f64>, columns: usize| {
        arrays.set_item(name, PyArray1::from_vec(py, values).reshape([frames, columns])?)
    };
    add("root_pos", motion.root_pos(), 3)?;
    add("root_rot", motion.root_rot(), 4)?;
    add("qpos", motion.qpos(), 7 + joints)?;
    add("dof_pos", motion.dof_pos.clone(), joints)?;
    let (feet, contacts) = motion.contacts_of_feet();
    arrays.set_item("contacts", PyArray1::from_vec(py, contacts).reshape([frames, feet])?)?;
    arrays.set_item("fps", motion.fps)?;
    Ok(arrays)
}

/// A robot's motion for writing.
#[pyclass(frozen, module = "mocap")]
pub(crate) struct RobotClip {
    retargeting: Retargeter,
}

#[pymethods]
impl RobotClip {
    /// Writes a file in the format `to`, or in the format of its extension.
    fn save(&self, py: Python<'_>, path: PathBuf, to: Option<&str>, overwrite: bool) -> PyResult<()> {
        let extension = path
            .extension()
            .map(|extension| extension.to_string_lossy().to_lowercase());
        let name = to.or(extension.as_deref()).unwrap_or_default();
        let Some(format) = RobotFormat::named(name) else {
            let names = RobotFormat::ALL.map(RobotFormat::name).join(", ");
            let message = format!("no format of robots' motions is called {name:?}; to must be one of {names}");
            return Err(invalid(message));
        };
        let fps = self.retargeting.clips()[0]
            .robot_motion
            .as_ref()
            .map(|motion| motion.fps);
        if let (Some(rate), Some(fps)) = (format.rate(), fps)
            && (rate - fps).abs() > 1e-9
        {
            let message = format!(
                "readers of {name} expect {rate} frames per second, and the motion has {fps}: retarget(..., fps={rate})"
            );
            return Err(invalid(message));
        }
        let saved = py.detach(|| {
            let policy = ReplacePolicy::new([] as [&Path; 0]).force(overwrite);
            format.write(&self.retargeting)?.save(&path, &policy)
        });
        saved.map_err(|error| to_python(py, &error))
    }
}
