//! Writes motions to files by jobs.

use std::path::{Path, PathBuf};

use mocap::Result;
use mocap::files::ReplacePolicy;
use mocap::job::{JointNames, Maker, MotionJob};
use mocap::scene::UpAxis;
use pyo3::prelude::*;

use crate::errors::{invalid, to_python};
use crate::motion_job;
use crate::scene::Scene;

/// Runs a job on a file. Returns the number of written bytes.
#[pyfunction]
pub(crate) fn convert(py: Python<'_>, source: PathBuf, target: PathBuf, job: &str) -> PyResult<usize> {
    let mut job = writing_job(job, target)?;
    job.source.inputs = vec![source];
    let done = py.detach(|| {
        make(&job, &job.policy(), |maker, job| {
            maker.make(&job.source.inputs, &job.write.output, &mut |_| {})
        })
    });
    done.map_err(|error| to_python(py, &error))
}

/// Runs a job on a scene. Returns the number of written bytes.
#[pyfunction]
pub(crate) fn write_scene(py: Python<'_>, scene: &Scene, target: PathBuf, job: &str) -> PyResult<usize> {
    let job = writing_job(job, target)?;
    let mut policy = job.policy();
    if let Some(origin) = &scene.scene().metadata.origin {
        policy = policy.source_name(&origin.name);
    }
    let done = py.detach(|| {
        make(&job, &policy, |maker, job| {
            let mut scene = scene.scene().clone();
            if job.write.skeleton_only {
                scene.leave_out_meshes();
            }
            if let Some(mesh) = job.write.mesh {
                scene.add_skeleton_mesh(mesh.into());
            }
            let name = scene.metadata.origin.as_ref().map(|origin| PathBuf::from(&origin.name));
            let name = name.unwrap_or_else(|| Path::new("the scene").to_owned());
            let source = maker.prepare(scene, &name, &mut |_| {})?;
            maker.make_of(source, &name, &job.write.output, &mut |_| {})
        })
    });
    done.map_err(|error| to_python(py, &error))
}

/// Parses the JSON of a job, and sets its output. Unknown names of joints refer to a file, which is read immediately.
fn writing_job(json: &str, output: PathBuf) -> PyResult<MotionJob> {
    let mut job = motion_job(json)?;
    job.write.output = output;
    if let Some(JointNames::File(path)) = &job.write.names {
        let names = JointNames::parse(&path.to_string_lossy());
        job.write.names = Some(names.map_err(|error| invalid(format!("names: {}", error.diagnostic().message)))?);
    }
    Ok(job)
}

/// Runs a job and writes its output. Returns the number of written bytes.
fn make(
    job: &MotionJob,
    policy: &ReplacePolicy,
    made: impl FnOnce(&Maker<'_>, &MotionJob) -> Result<mocap::job::JobOutput>,
) -> Result<usize> {
    policy.check_inputs(&job.write.output)?;
    let maker = Maker::new(job, &[], &mut |_| {})?;
    maker.check(policy, &job.write.output)?;
    let made = made(&maker, job)?;
    made.written.save(&job.write.output, policy)?;
    Ok(made.written.len())
}

/// The axis with this name.
pub(crate) fn up_axis(name: Option<&str>) -> PyResult<Option<UpAxis>> {
    let named = |name: &str| {
        let up = UpAxis::ALL.into_iter().find(|up| up.as_str() == name);
        up.ok_or_else(|| invalid(format!("up must be y, z, -y or -z, got {name:?}")))
    };
    name.map(named).transpose()
}
