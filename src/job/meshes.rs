//! What happens to the meshes of an input, and what shows a skeleton without meshes.

use std::path::Path;

use mocap_formats::FormatInfo;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::report::{AppliedStep, DataKind, DataLoss};
use mocap_scene::scene::{Format, Scene};

use super::MotionJob;
use super::notice::{Listener, Notice};

/// What shows the skeleton of a file without meshes; nothing if the format has the meshes of the file.
pub(super) fn shown(job: &MotionJob, row: Option<&FormatInfo>) -> SkeletonMesh {
    let of_format = || row.map_or(SkeletonMesh::Skinned, |row| row.mesh(job.write.skeleton_only));
    job.write.mesh.map_or_else(of_format, SkeletonMesh::from)
}

/// Draws the skeleton of a glTF file anew, in which this crate has drawn it: the steps may give it another rest pose.
pub(super) fn draw_anew(job: &MotionJob, row: Option<&FormatInfo>, scene: &mut Scene) {
    let kind = shown(job, row);
    let is_drawn = scene.metadata.format == Some(Format::Gltf) && scene.own_meshes().next().is_none();
    if is_drawn && scene.original.is_none() && !scene.meshes.is_empty() && kind != SkeletonMesh::Own {
        scene.leave_out_meshes();
        scene.materials.clear();
        scene.add_skeleton_mesh(kind);
    }
}

/// Decides what happens to the file of a scene with meshes, and reports what is dropped. `row` is that of the output.
pub(super) fn keep_or_drop(
    job: &MotionJob,
    row: Option<&FormatInfo>,
    scene: &mut Scene,
    motion: &Path,
    hear: Listener<'_>,
) -> Result<()> {
    let is_gltf = row.is_some_and(|row| row.format == Format::Gltf);
    if job.write.skeleton_only {
        scene.metadata.lost.clear();
    }
    // One face has not the targets of another, and a skeleton has none.
    if job.target.is_some() || job.write.skeleton_only {
        let lost = scene.weight_curves();
        scene.lose(DataKind::FaceCurves, lost);
        if lost > 0 && job.target.is_some() {
            let lost = DataLoss::new(DataKind::FaceCurves, lost as u64);
            let message = format!("left out: {lost}, because the targets of one face are not those of another");
            hear(Notice::Warnings(
                motion,
                &[Diagnostic::new(Code::NotCarriedOver, message)],
            ));
        }
    }
    if job.write.skeleton_only && scene.original.take().is_some() && is_gltf {
        hear(Notice::Note(
            "skeleton-only: the meshes, the materials and all else beside the skeleton and its motion are left out",
        ));
    }
    let Some(original) = scene.original.as_mut().filter(|_| is_gltf && job.target.is_none()) else {
        return Ok(());
    };
    if job.write.mesh.is_some() {
        let message = "{mesh} would do nothing: the file has meshes of its own, which are kept";
        let error = Diagnostic::new(Code::InvalidValue, message).help("leave it out, or add {skeleton-only}");
        return Err(Error::from(error).with_path(motion));
    }
    // A step changes one motion; the others of the file stay.
    let chosen = scene.metadata.steps.iter().find_map(|step| match step {
        AppliedStep::SelectClip { index } => Some(*index),
        _ => None,
    });
    original.replaced = chosen.filter(|_| !job.steps.is_empty());
    Ok(())
}
