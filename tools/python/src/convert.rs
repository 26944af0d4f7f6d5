//! A motion file in another format.

use std::path::{Path, PathBuf};

use mocap::convert::RestPoseSource;
use mocap::figure::{Figure, HumanoidMap};
use mocap::files::ReplacePolicy;
use mocap::job::JointNames;
use mocap::scene::UpAxis;
use mocap::{Conversion, Exporter, FormatInfo, SkeletonMesh, WriteOption};
use pyo3::prelude::*;

use crate::ReadOptions;
use crate::edit::bones_of;
use crate::errors::{invalid, to_python};

/// How a file is written, as `mocap/_options.py` has it.
#[derive(FromPyObject)]
pub(crate) struct WriteOptions {
    max_error: Option<f64>,
    shell_distance: Option<f64>,
    compress: Option<String>,
    overwrite: bool,
    pub(crate) skeleton_only: bool,
}

impl WriteOptions {
    /// The exporter to `target`, which is made from `sources`.
    ///
    /// `changes` are further options, and whether they were given.
    pub(crate) fn exporter(
        &self,
        sources: &[&PathBuf],
        target: &Path,
        changes: &[(WriteOption, bool)],
    ) -> PyResult<Exporter> {
        let extension = target.extension().and_then(|extension| extension.to_str());
        let row = FormatInfo::of_output(target).ok_or_else(|| {
            let known = FormatInfo::written_extensions();
            invalid(format!(
                "the file must end in {known}, got {:?}",
                target.display().to_string()
            ))
        })?;
        let given = [
            (WriteOption::MaxError, self.max_error.is_some()),
            (WriteOption::ShellDistance, self.shell_distance.is_some()),
            (WriteOption::Compress, self.compress.is_some()),
            (WriteOption::SkeletonOnly, self.skeleton_only),
        ];
        let mut given = given.iter().chain(changes).copied().filter(|(_, is_given)| *is_given);
        if let Some(refusal) = given.find_map(|(option, _)| row.refusal(option, extension.unwrap_or_default())) {
            return Err(invalid(refusal.message));
        }
        let mut exporter = Exporter::new()
            .replace(ReplacePolicy::new(sources))
            .overwrite(self.overwrite);
        if let Some(metres) = self.max_error {
            exporter = exporter.max_error(metres);
        }
        if let Some(metres) = self.shell_distance {
            exporter = exporter.shell_distance(metres);
        }
        if let Some(name) = &self.compress {
            exporter = exporter.compression(name.parse().map_err(|error: mocap::Error| {
                let known = error.diagnostic().expected.clone().unwrap_or_default();
                invalid(format!("compress must be one of {known}, got {name:?}"))
            })?);
        }
        Ok(exporter)
    }
}

/// Reads `source`, converts it to metres with +Y up, but for a format that keeps its unit, and writes `target`; returns
/// the bytes written.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "Python hands them over by name")]
pub(crate) fn convert(
    py: Python<'_>,
    source: PathBuf,
    target: PathBuf,
    metres_per_unit: Option<f64>,
    up: Option<&str>,
    fps: Option<f64>,
    rest: &str,
    t_pose_first: bool,
    names: Option<&str>,
    bones: Option<&str>,
    read: ReadOptions,
    write: WriteOptions,
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
    let rest: RestPoseSource = rest
        .parse()
        .map_err(|error| invalid(format!("rest: {error}, got {rest:?}")))?;
    conversion = conversion.rest(rest).t_pose_first(t_pose_first);
    let bones = bones.map(bones_of).transpose()?.unwrap_or_default();
    let names = names.map(names_of).transpose()?;
    let given = [
        (WriteOption::Rest, rest != RestPoseSource::default()),
        (WriteOption::Names, names.is_some()),
    ];
    let exporter = write.exporter(&[&source], &target, &given)?;
    let row = FormatInfo::of_output(&target);
    let keeps_units = row.is_some_and(FormatInfo::keeps_units);
    if keeps_units && (metres_per_unit.is_some() || up.is_some()) {
        let message = "unit and up would do nothing: the file keeps the unit and the axes of its source";
        return Err(invalid(message));
    }
    let conversion = conversion.keep_units(keeps_units);
    let mesh = row.map_or(SkeletonMesh::Skinned, |row| row.mesh(write.skeleton_only));
    let importer = read
        .importer()?
        .skeleton_mesh(mesh)
        .gltf_meshes(mesh == SkeletonMesh::Own);
    let written = py.detach(|| {
        ReplacePolicy::new([&source]).check_inputs(&target)?;
        let mut scene = importer.import(&source)?;
        if write.skeleton_only {
            scene.original = None;
        }
        let found = Figure::mapped(&scene, &bones)?;
        let (figure, _) = conversion.apply_to(&mut scene, &found)?;
        if let Some(names) = &names {
            mocap::figure::name_joints(&mut scene, &figure.humanoid, names)?;
        }
        exporter.export(&scene, &target)
    });
    written
        .map(|written| written.len() as u64)
        .map_err(|error| to_python(py, &error))
}

/// The names of bones, as JSON: a word that is known, the name of a file, or the name of each bone.
fn names_of(names: &str) -> PyResult<HumanoidMap> {
    let refused = |error: String| invalid(format!("names: {error}"));
    let names: JointNames = serde_json::from_str(names).map_err(|error| refused(error.to_string()))?;
    let names = match names {
        JointNames::File(path) => JointNames::parse(&path.to_string_lossy()),
        names => Ok(names),
    };
    names
        .and_then(|names| names.names())
        .map_err(|error| refused(error.diagnostic().message.clone()))
}

/// The axis of this name.
pub(crate) fn up_axis(name: Option<&str>) -> PyResult<Option<UpAxis>> {
    let named = |name: &str| {
        let up = UpAxis::ALL.into_iter().find(|up| up.as_str() == name);
        up.ok_or_else(|| invalid(format!("up must be y, z, -y or -z, got {name:?}")))
    };
    name.map(named).transpose()
}
