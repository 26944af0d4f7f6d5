//! Retargeted motions.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use mocap_figure::convert::{Conversion, RootMotion};
use mocap_figure::report::Guess;
use mocap_figure::{Axis, Confidence, Figure, Humanoid};
use mocap_formats::{Export, FormatInfo};
use mocap_io::Importer;
use mocap_io::export::is_at_rest_for;
use mocap_retarget::{Retargeter, SourceMotion, Target};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::process::{self, SkeletonMesh};
use mocap_scene::scene::Scene;

use super::skeletons::up_of_others;
use super::{JobOutput, Maker, REST_LEFT_OUT, no_input};
use crate::files::Files;
use crate::form::Form;
use crate::notice::{Listener, Notice, tell_of_skeleton};
use crate::{JobTarget, MotionJob, meshes, names};

impl Maker<'_> {
    /// Makes the output of retargeted motions.
    pub(super) fn make_onto(
        &self,
        mut target: Retargeter,
        motions: &[PathBuf],
        output: &Path,
        hear: Listener<'_>,
    ) -> Result<JobOutput> {
        if motions.is_empty() {
            return Err(no_input());
        }
        let several = (motions.len() > 1).then(|| self.clone().look_at(motions));
        let maker = several.as_ref().unwrap_or(self);
        let mut left_out = Vec::new();
        for motion in motions {
            let hear: Listener<'_> = &mut |said: Notice<'_>| match said {
                // With several motions, each note names its motion.
                Notice::Note(note) if several.is_some() => hear(Notice::Note(&format!("{}: {note}", motion.display()))),
                said => hear(said),
            };
            let source = maker.import(motion, hear);
            let source = source.and_then(|scene| maker.with_up_of_others(&scene, hear).prepare(scene, motion, hear));
            let added = source.and_then(|source| maker.add(source, motion, &mut target, hear));
            if let Err(error) = added {
                let error = error.with_path(motion);
                // One bad file among many does not stop the others.
                if left_out.len() + 1 == motions.len() {
                    return Err(error);
                }
                left_out.push((motion.clone(), error.diagnostic().clone()));
            }
        }
        let made = self.made_onto(target, output)?;
        Ok(JobOutput { left_out, ..made })
    }

    /// The maker for a motion with an uncertain up axis: it uses the certain up axis of other motions of the skeleton.
    fn with_up_of_others(&self, scene: &Scene, hear: Listener<'_>) -> Cow<'_, Self> {
        let is_open = scene.metadata.up.is_none() && self.job.source.space.up().is_none();
        let told = up_of_others(&self.skeletons, scene).filter(|_| is_open);
        let Some(up) = told else { return Cow::Borrowed(self) };
        let guess = Figure::mapped(scene, &self.bones).map(|figure| figure.up);
        let is_in_doubt = |guess: Guess<Axis>| guess.confidence != Confidence::Sure && guess.value != Axis::from(up);
        if !guess.is_ok_and(is_in_doubt) {
            return Cow::Borrowed(self);
        }
        hear(Notice::Note(&format!(
            "the up axis is {}, because other motions of the same skeleton stand along this axis",
            up.as_str()
        )));
        Cow::Owned(self.clone().up(up))
    }

    pub(super) fn made_onto(&self, mut target: Retargeter, output: &Path) -> Result<JobOutput> {
        let names = self.job.target.as_ref().map(JobTarget::names_of_clips);
        if let Some(names) = names.filter(|names| !names.is_empty()) {
            target.name_clips(names)?;
        }
        let (mut written, scene) = self.write_onto(&mut target, output)?;
        let of_clips = target.clips().iter().flat_map(|clip| &clip.provenance.losses);
        for loss in of_clips {
            match written.losses.iter_mut().find(|known| known.kind == loss.kind) {
                Some(known) => known.count = known.count.max(loss.count),
                None => written.losses.push(*loss),
            }
        }
        Ok(JobOutput {
            written: self.check_losses(written)?,
            scene,
            humanoid: None,
            left_out: Vec::new(),
            clips: target.into_clips().into_iter().map(|clip| clip.report).collect(),
        })
    }

    /// Retargets the motions of a file to the target.
    pub(super) fn add(
        &self,
        mut source: SourceMotion,
        motion: &Path,
        target: &mut Retargeter,
        hear: Listener<'_>,
    ) -> Result<()> {
        let in_file = |error: Error| error.with_path(motion);
        if let Some(bones) = source.bones.take() {
            source.bones = Some(self.apply_steps(&mut source.scene, bones, hear).map_err(in_file)?);
        }
        let name = motion.file_stem().unwrap_or(motion.as_os_str()).to_string_lossy();
        if target.add(source.named(name)).map_err(in_file)?.is_rest_pose_left_out {
            hear(Notice::Note(REST_LEFT_OUT));
        }
        Ok(())
    }

    /// The files of retargeted motions under the name `output`, and their scene if the files are written from a scene.
    fn write_onto(&self, target: &mut Retargeter, output: &Path) -> Result<(Export, Option<Scene>)> {
        let write = &self.job.write;
        let row = match self.form {
            Form::Robot(format) => {
                let mut written = format.write(target)?;
                let (lost, said) = target.faces_in("a robot");
                written.losses.extend(lost);
                written.notes.extend(said);
                return Ok((written, None));
            }
            Form::Character => {
                target.drop_sources();
                let name = output.file_name().unwrap_or_default().to_string_lossy();
                let written = target.character_files(&write.gltf(), &name)?;
                return Ok((written.unwrap_or_default(), None));
            }
            Form::Scene(row) => row,
            // Arrays are only written for a motion that keeps its skeleton.
            Form::Arrays(layout) => layout.row(),
        };
        if row.has_one_clip && target.clips().len() > 1 {
            let message = format!("a file of {} holds one motion; name only one motion", row.name);
            let refusal = Diagnostic::new(Code::Unrepresentable, message).help("{clip} chooses one clip of a file");
            return Err(Error::from(refusal).with_path(output));
        }
        let mut scene = match (row.keeps_units(), &write.space) {
            (true, space) if space.is_empty() => target.take_scene(None)?,
            (keeps_units, space) => {
                let conversion = space.of(Conversion::new()).keep_units(keeps_units);
                target.take_scene(Some(&conversion.bone_axis(write.along_bone())))?
            }
        };
        let (lost_faces, said_of_faces) = match row.states_bones {
            true => {
                target.add_faces(&mut scene);
                (None, Vec::new())
            }
            false => target.faces_in(row.name),
        };
        // The exporter reports the faces that the format cannot store.
        if let Some(lost) = lost_faces {
            scene.lose(lost.kind, lost.count as usize);
        }
        let mut exporter = write.exporter();
        if let Some(bones) = target.humanoid().filter(|_| row.states_bones) {
            exporter = exporter.humanoid(bones.clone());
        }
        let bones = || target.humanoid().cloned().unwrap_or_else(|| Humanoid::of(&scene));
        let bones = self.names.is_some().then(bones);
        let naming = bones.map(|bones| names::name(&mut scene, self.names.as_ref(), &bones));
        let naming = naming.transpose()?.flatten();
        // Changes the rest pose in the scene itself. Otherwise, the exporter would copy the scene first.
        if !is_at_rest_for(&scene, row) {
            process::zero_rest_rotations(&mut scene)?;
        }
        let mut written = exporter.write_as(&scene, write.name_of(output))?;
        written.notes.extend(said_of_faces);
        naming
            .iter()
            .for_each(|naming| names::tell(naming, &scene, &mut written));
        Ok((written, Some(scene)))
    }
}

/// Reads the body to which motions are retargeted.
pub(super) fn import_onto(
    job: &MotionJob,
    named: &JobTarget,
    files: Files<'_>,
    hear: Listener<'_>,
) -> Result<(Form, Retargeter)> {
    let file = named.file();
    let frames = &job.source.frames;
    let options = named
        .options()?
        .source_bones(job.source.map.bones()?)
        .conversion(match named {
            JobTarget::Robot(_) => frames.conversion(),
            // For other targets, the root motion changes in the clips on the body, after the foot lock.
            _ => frames.conversion().root(RootMotion::Keep),
        })
        .root(frames.root)
        .robot_weights(job.weights.robot)
        .foot_lock_weights(job.weights.foot_lock);
    let row = FormatInfo::of_output(&job.write.name_of(Path::new("scene")));
    let mesh = match (named, job.write.mesh) {
        (JobTarget::Skeleton(_), None) => SkeletonMesh::None,
        _ => meshes::shown(job, row),
    };
    // Draws the skeleton of a character without meshes, or selects the meshes of a character for the output.
    let importer = Importer::new()
        .skeleton_mesh(mesh)
        .morph_targets(row.is_some_and(|row| row.takes_morph_targets(file)));
    let target = files.import_target(named, &importer)?;
    match &target {
        Target::Skeleton(scene) => tell_of_skeleton(scene, file, hear),
        Target::Robot(robot) => hear(Notice::Warnings(file, &robot.warnings)),
        Target::Character(character) => {
            let broken = character.scene().warnings.iter();
            let broken: Vec<_> = broken
                .filter(|found| found.code == Code::NonFiniteValue)
                .cloned()
                .collect();
            hear(Notice::Warnings(file, &broken));
        }
    }
    let form = Form::onto(&job.write, named, &target, files.has_disk)?;
    let target = Retargeter::onto(target, options).map_err(|error| error.with_path(file))?;
    Ok((form, target))
}
