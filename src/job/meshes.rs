//! Decides whether the meshes of an input are kept, and how a skeleton without meshes is drawn.

use std::path::Path;

use mocap_formats::FormatInfo;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::report::{AppliedStep, DataKind, DataLoss};
use mocap_scene::scene::{Format, Scene};

use super::MotionJob;
use super::notice::{Listener, Notice};

/// How the skeleton of a file without meshes is drawn; not at all if the output has the meshes of the file.
pub(super) fn shown(job: &MotionJob, row: Option<&FormatInfo>) -> SkeletonMesh {
    let of_format = || row.map_or(SkeletonMesh::Skinned, |row| row.mesh(job.write.skeleton_only));
    job.write.mesh.map_or_else(of_format, SkeletonMesh::from)
}

/// Redraws the skeleton of a glTF input if this crate drew it, because the steps may change the rest pose.
pub(super) fn draw_anew(job: &MotionJob, row: Option<&FormatInfo>, scene: &mut Scene) {
    let kind = shown(job, row);
    let is_drawn = scene.metadata.format == Some(Format::Gltf) && scene.own_meshes().next().is_none();
    if is_drawn && scene.original.is_none() && !scene.meshes.is_empty() && kind != SkeletonMesh::Own {
        scene.leave_out_meshes();
        scene.materials.clear();
        scene.add_skeleton_mesh(kind);
    }
}

/// Whether the output is the file of the scene with other animations, so that the file keeps its other clips.
pub(super) fn is_passed_through(job: &MotionJob, row: Option<&FormatInfo>, scene: &Scene) -> bool {
    let is_gltf = row.is_some_and(|row| row.format == Format::Gltf);
    is_gltf && job.target.is_none() && !job.write.skeleton_only && scene.original.is_some()
}

/// Keeps or drops the meshes and other contents of a scene's file, and reports dropped data. `row` is the row of the
/// output's format.
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
    // Another body has other morph targets, and a skeleton without a mesh has none.
    if job.target.is_some() || job.write.skeleton_only {
        let lost = scene.weight_curves();
        scene.lose(DataKind::FaceCurves, lost);
        if lost > 0 && job.target.is_some() {
            let lost = DataLoss::new(DataKind::FaceCurves, lost as u64);
            let message = format!("dropped: {lost}, because morph targets differ between faces");
            hear(Notice::Warnings(
                motion,
                &[Diagnostic::new(Code::NotCarriedOver, message)],
            ));
        }
    }
    if job.write.skeleton_only && scene.original.take().is_some() && is_gltf {
        hear(Notice::Note(
            "skeleton-only: only the skeleton and its motion are kept; meshes, materials and all other contents are \
             dropped",
        ));
    }
    let is_passed_through = is_passed_through(job, row, scene);
    let Some(original) = scene.original.as_mut().filter(|_| is_passed_through) else {
        return Ok(());
    };
    if job.write.mesh.is_some() {
        let message = "{mesh} would do nothing: the meshes of the file are kept";
        let error = Diagnostic::new(Code::InvalidValue, message).help("leave it out, or add {skeleton-only}");
        return Err(Error::from(error).with_path(motion));
    }
    // If the steps change one clip, the other clips of the file do not change.
    let chosen = scene.metadata.steps.iter().find_map(|step| match step {
        AppliedStep::SelectClip { index } => Some(*index),
        _ => None,
    });
    original.replaced = chosen.filter(|_| !job.steps.is_empty());
    Ok(())
}
