//! A scene and its nodes.

use std::sync::Arc;

use mocap::arrays::{Arrays, BodyArrays, Rotation};
use mocap::biomechanics::{BodyGait, JointAngles, TimeSeries};
use mocap::figure::Figure;
use mocap::glam::Mat4;
use mocap::scene::report::MarkerSolution;
use mocap::scene::{NodeKind, Recording, RotationOrder};
use mocap::{Binding, ChainMatrix, Clips, Pose};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict, PyList};

use crate::arrow::ArrowTable;
use crate::edit::{bones_of, json};
use crate::errors::{invalid, to_python};
use crate::options_from;

#[pyclass(frozen, module = "mocap")]
pub(crate) struct Scene {
    scene: Arc<mocap::Scene>,
}

/// An animation by its number from 0, or by its name.
#[derive(FromPyObject)]
enum Clip {
    Number(usize),
    Name(String),
}

/// The data that is sent between processes in addition to the scene.
#[derive(Default, serde::Serialize, serde::Deserialize)]
struct Beside {
    recorded: Option<Recording>,
    /// The values of the recorded channels, which their JSON lacks.
    values: Vec<Vec<f32>>,
    solved: Option<MarkerSolution>,
}

/// The result of :meth:`Scene.chain`.
#[derive(serde::Serialize)]
struct Chain {
    chain: Vec<ChainMatrix>,
    #[serde(skip_serializing_if = "Option::is_none")]
    point_in_world: Option<[f32; 3]>,
}

/// A node of a scene; :attr:`Scene.nodes` lists them.
#[pyclass(frozen, get_all, module = "mocap")]
pub(crate) struct Node {
    /// The name as in the file; names may repeat.
    name: String,
    /// ``"joint"``, ``"end_site"`` or ``"group"``.
    kind: &'static str,
    /// The index of the parent among the nodes; ``None`` for the root.
    parent: Option<usize>,
    /// The rest offset from the parent: x, y, z in the unit of the file.
    offset: [f32; 3],
    /// The order of the Euler angles in the file, such as ``"ZXY"``, or ``None``.
    rotation_order: Option<String>,
    /// The humanoid bone of the node, if the file states it, or ``None``.
    humanoid_bone: Option<&'static str>,
    /// The expression of a VRM animation whose weight is x of the position, such as ``"blink"``; ``"lookAt"`` for the
    /// gaze.
    face: Option<String>,
}

#[pymethods]
impl Node {
    fn __repr__(&self) -> String {
        format!(
            "Node(name={:?}, kind={:?}, parent={:?})",
            self.name, self.kind, self.parent
        )
    }
}

impl Scene {
    pub(crate) fn new(scene: mocap::Scene) -> Self {
        Self { scene: Arc::new(scene) }
    }

    pub(crate) fn scene(&self) -> &mocap::Scene {
        &self.scene
    }

    fn motion(&self, py: Python<'_>, options: &str) -> PyResult<Arrays> {
        let options = options_from(options)?;
        py.detach(|| Arrays::of(&self.scene, &options))
            .map_err(|error| to_python(py, &error))
    }
}

#[pymethods]
impl Scene {
    #[getter]
    fn nodes(&self) -> Vec<Node> {
        let node = |node: &mocap::scene::Node| Node {
            name: node.name.clone(),
            kind: match node.kind {
                NodeKind::Joint => "joint",
                NodeKind::EndSite => "end_site",
                _ => "group",
            },
            parent: node.parent.map(mocap::scene::NodeId::index),
            offset: node.transform.w_axis.truncate().to_array(),
            rotation_order: node.rotation_order.map(letters),
            humanoid_bone: node.humanoid_bone.map(mocap::figure::HumanoidBone::as_str),
            face: node.face.as_ref().map(|face| face.name().to_owned()),
        };
        self.scene.nodes.iter().map(node).collect()
    }

    #[getter]
    fn frames(&self) -> usize {
        self.scene
            .animations
            .first()
            .map_or(0, mocap::scene::Animation::frame_count)
    }

    /// The names of the animations.
    #[getter]
    fn clips(&self) -> Vec<&str> {
        self.scene.animations.iter().map(|animation| &*animation.name).collect()
    }

    /// The scene with one of its animations.
    fn clip(&self, py: Python<'_>, clip: Clip) -> PyResult<Self> {
        let clips = match clip {
            Clip::Number(index) => Clips::Index(index),
            Clip::Name(name) => Clips::Name(name),
        };
        let mut scene = (*self.scene).clone();
        let selected = clips.select(&mut scene);
        selected
            .map(|()| Self::new(scene))
            .map_err(|error| to_python(py, &error))
    }

    #[getter]
    fn frame_rate(&self) -> f64 {
        self.scene
            .animations
            .first()
            .map_or(0.0, |animation| animation.ticks_per_second)
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        let warning = |warning: &mocap::Diagnostic| format!("{}: {warning}", warning.code);
        self.scene.warnings.iter().map(warning).collect()
    }

    #[getter]
    fn metadata_json(&self) -> PyResult<String> {
        json(&self.scene.metadata)
    }

    fn pose_matrices<'py>(&self, py: Python<'py>, tick: f64, world: bool) -> PyResult<Bound<'py, PyAny>> {
        matrices(py, &posed(&self.scene, tick), world)
    }

    /// The matrices from the root to a joint and a point attached to it, as JSON.
    fn chain(&self, py: Python<'_>, joint: &str, tick: f64, point: Option<[f32; 3]>) -> PyResult<String> {
        let pose = posed(&self.scene, tick);
        let chain = pose.chain(&self.scene, joint).map_err(|error| to_python(py, &error))?;
        let in_world = |point: [f32; 3]| Some(pose.point_to_world(chain.last()?.node, point.into()).to_array());
        let point_in_world = point.and_then(in_world);
        json(&Chain { chain, point_in_world })
    }

    /// Serializes the scene for another process.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let made = py.detach(|| {
            let metadata = &self.scene.metadata;
            let recorded = metadata.recorded.as_deref().cloned();
            let channels = recorded.iter().flat_map(|recorded| &recorded.channels);
            let beside = Beside {
                values: channels.map(|channel| channel.values.clone()).collect(),
                recorded,
                solved: metadata.solved.as_deref().cloned(),
            };
            let mut bytes = Vec::new();
            ciborium::into_writer(&(&*self.scene, beside), &mut bytes).map(|()| bytes)
        });
        made.map(|bytes| PyBytes::new(py, &bytes))
            .map_err(|error| invalid(format!("the scene cannot be pickled: {error}")))
    }

    /// Unit, axes, rest pose, and the joints of bones, as JSON. `bones` are the joints of known bones, as JSON.
    fn figure(&self, py: Python<'_>, bones: Option<&str>) -> PyResult<String> {
        let bones = bones.map(bones_of).transpose()?.unwrap_or_default();
        let found = py.detach(|| Figure::mapped(&self.scene, &bones));
        json(&found.map_err(|error| to_python(py, &error))?)
    }

    fn arrays<'py>(&self, py: Python<'py>, options: &str) -> PyResult<Bound<'py, PyDict>> {
        let motion = self.motion(py, options)?;
        let (frames, joints) = (motion.frames, motion.joints().len());
        let width = motion.header.rotation.width();
        let result = PyDict::new(py);
        result.set_item("header_json", motion.header.to_json())?;
        result.set_item("frame_rate", motion.frame_rate())?;
        let listed = motion.joints();
        result.set_item("names", PyList::new(py, listed.iter().map(|joint| &joint.name))?)?;
        let parents = listed
            .iter()
            .map(|joint| joint.parent.map_or(-1, |parent| parent as i32));
        result.set_item("parents", PyArray1::from_iter(py, parents))?;
        let offsets: Vec<f32> = listed.iter().flat_map(|joint| joint.offset.to_array()).collect();
        result.set_item("offsets", PyArray1::from_vec(py, offsets).reshape([joints, 3])?)?;
        result.set_item(
            "positions",
            PyArray1::from_vec(py, motion.positions).reshape([frames, joints, 3])?,
        )?;
        let rotations = PyArray1::from_vec(py, motion.rotations);
        if motion.header.rotation == Rotation::Matrix {
            result.set_item("rotations", rotations.reshape([frames, joints, 3, 3])?)?;
        } else {
            result.set_item("rotations", rotations.reshape([frames, joints, width])?)?;
        }
        let velocities = motion
            .velocities
            .map(|values| PyArray1::from_vec(py, values).reshape([frames, joints, 3]));
        result.set_item("velocities", velocities.transpose()?)?;
        let contacts = motion
            .contacts
            .map(|values| PyArray1::from_vec(py, values).reshape([frames, joints]));
        result.set_item("contacts", contacts.transpose()?)?;
        Ok(result)
    }

    /// The bytes of a file in a body layout, `.npz` or `.npy`.
    fn smpl<'py>(&self, py: Python<'py>, layout: &str) -> PyResult<Bound<'py, PyBytes>> {
        let made = py.detach(|| BodyArrays::new(&self.scene)?.write(layout.parse()?));
        made.map(|bytes| PyBytes::new(py, &bytes))
            .map_err(|error| to_python(py, &error))
    }

    /// Frames per second, the names of the columns of joint angles, and their values, row by row.
    fn joint_angles<'py>(&self, py: Python<'py>) -> PyResult<(f64, Vec<String>, Bound<'py, PyArray1<f64>>)> {
        let angles = py.detach(|| JointAngles::of(&self.scene));
        let angles = angles.map_err(|error| to_python(py, &error))?;
        Ok((angles.frame_rate, angles.columns, PyArray1::from_vec(py, angles.values)))
    }

    /// The samples per second, the names of the columns of the analog channels or ground reaction forces, and their
    /// values, row by row.
    fn time_series<'py>(
        &self,
        py: Python<'py>,
        of_ground: bool,
    ) -> PyResult<(f64, Vec<String>, Bound<'py, PyArray1<f64>>)> {
        let series = py.detach(|| match of_ground {
            true => TimeSeries::ground_forces(&self.scene),
            false => TimeSeries::analog(&self.scene),
        });
        let series = series.map_err(|error| to_python(py, &error))?;
        Ok((series.frame_rate, series.columns, PyArray1::from_vec(py, series.values)))
    }

    /// Events, analog channels without their values, and force plates as JSON; `null` if there are none.
    fn recorded(&self) -> PyResult<String> {
        json(&self.scene.metadata.recorded.as_deref())
    }

    /// The residuals of a skeleton solved from markers, as JSON; `null` for other scenes.
    fn solved(&self) -> PyResult<String> {
        json(&self.scene.metadata.solved.as_deref())
    }

    /// The gait parameters as JSON.
    fn gait(&self, py: Python<'_>) -> PyResult<String> {
        let gait = py.detach(|| BodyGait::of(&self.scene));
        let gait = gait.map_err(|error| to_python(py, &error))?;
        json(&gait)
    }

    fn arrow(&self, py: Python<'_>, options: &str, clip: &str) -> PyResult<ArrowTable> {
        let motion = self.motion(py, options)?;
        let rows = py.detach(|| motion.to_table_with_header(clip));
        Ok(ArrowTable::new(rows))
    }
}

/// Restores a scene from the bytes of `Scene::state`.
#[pyfunction]
pub(crate) fn scene_of(py: Python<'_>, state: PyBackedBytes) -> PyResult<Scene> {
    let read = py.detach(|| ciborium::from_reader::<(mocap::Scene, Beside), _>(&state[..]));
    let broken = |error: String| invalid(format!("the bytes are not a pickled scene of this version: {error}"));
    let (mut scene, mut beside) = read.map_err(|error| broken(error.to_string()))?;
    if let Some(broken_rule) = scene.validate().first() {
        return Err(broken(broken_rule.to_string()));
    }
    if let Some(recorded) = &mut beside.recorded {
        for (channel, values) in recorded.channels.iter_mut().zip(beside.values) {
            channel.values = values;
        }
    }
    scene.metadata.recorded = beside.recorded.map(Arc::new);
    scene.metadata.solved = beside.solved.map(Arc::new);
    Ok(Scene::new(scene))
}

/// The pose of a scene at a tick, or its rest pose if it has no motion.
pub(crate) fn posed(scene: &mocap::Scene, tick: f64) -> Pose {
    let mut pose = Pose::rest(scene);
    if let Some(animation) = scene.animations.first() {
        pose.sample(&Binding::new(scene, animation), animation, tick);
    }
    pose
}

/// The matrices of a pose as a NumPy array.
pub(crate) fn matrices<'py>(py: Python<'py>, pose: &Pose, world: bool) -> PyResult<Bound<'py, PyAny>> {
    let matrices = if world {
        &pose.node_to_world
    } else {
        &pose.node_to_parent
    };
    let values: Vec<f32> = matrices.iter().flat_map(rows).collect();
    Ok(PyArray1::from_vec(py, values)
        .reshape([matrices.len(), 4, 4])?
        .into_any())
}

/// NumPy reads row by row, the library stores column by column.
pub(crate) fn rows(matrix: &Mat4) -> [f32; 16] {
    matrix.transpose().to_cols_array()
}

fn letters(order: RotationOrder) -> String {
    order.axes().into_iter().map(|axis| ["X", "Y", "Z"][axis]).collect()
}
