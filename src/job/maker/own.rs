//! A motion that keeps its own skeleton.

use std::path::Path;

use mocap_figure::Humanoid;
use mocap_formats::gltf::report::Provenance;
use mocap_formats::{Export, FormatInfo};
use mocap_io::export::{is_at_rest_for, nothing_moves};
use mocap_retarget::robot::{Robot, RobotMotion};
use mocap_scene::error::{Code, Error, Result, spelled};
use mocap_scene::process;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::Scene;

use super::Maker;
use crate::files::Files;
use crate::form::Form;
use crate::notice::{Listener, clip_taken, say_warnings};
use crate::{MotionJob, RobotFormat, meshes, names};

impl Maker<'_> {
    /// Applies the steps to a motion that keeps its skeleton, then the changes that the format needs. Returns the bones
    /// of the changed motion.
    pub(super) fn change(
        &self,
        scene: &mut Scene,
        found: Humanoid,
        motion: &Path,
        hear: Listener<'_>,
    ) -> Result<Humanoid> {
        let in_file = |error: Error| error.with_path(motion);
        let humanoid = self.apply_steps(scene, found, hear).map_err(in_file)?;
        if !self.job.steps.is_empty() && meshes::shown(&self.job, self.format()) == SkeletonMesh::None {
            scene.leave_out_meshes();
        }
        if let Some(axis) = self.job.write.along_bone() {
            axis.turn_frames(scene, humanoid.clone(), &self.bones)
                .map_err(in_file)?;
        }
        // Changes the rest pose before writing, so that the scene records the change for `verify`.
        if self.format().is_some_and(|row| !is_at_rest_for(scene, row)) {
            process::zero_rest_rotations(scene).map_err(in_file)?;
        }
        say_warnings(scene, motion, hear);
        Ok(humanoid)
    }

    /// The files of a motion under the name `output`.
    pub(super) fn write(
        &self,
        scene: &mut Scene,
        humanoid: &Humanoid,
        whole: Option<Box<Scene>>,
        motion: &Path,
        output: &Path,
    ) -> Result<Export> {
        let row = self.format();
        let states_bones = row.is_some_and(|row| row.states_bones);
        let naming = match self.names.is_some() || states_bones {
            true => names::name(scene, self.names.as_ref(), humanoid)?,
            false => None,
        };
        let one_clip = match (self.form, &self.robot) {
            (Form::Arrays(_), _) => Some("an array"),
            (Form::Robot(_), Some(_)) => Some("the file of a robot"),
            _ => row.filter(|row| row.has_one_clip).map(|row| row.name),
        };
        let taken = one_clip.and_then(|what| clip_taken(scene, Some(what)));
        if one_clip.is_some() {
            scene.put_main_clip_first();
        }
        let mut written = match (self.form, &self.robot) {
            (Form::Arrays(layout), _) => {
                let mut written = layout.write(scene, humanoid, whole.as_deref(), motion)?;
                add_losses(&mut written, scene, layout.row());
                if scene.face_curves_alone(0).is_some() {
                    return Err(nothing_moves(layout.row(), &written.losses).into());
                }
                written
            }
            (Form::Robot(format), Some(robot)) => {
                let moved = RobotMotion::of_scene(robot, scene)?;
                let mut written = format.write_motion(&moved, robot, &Provenance::of(scene))?;
                written.nodes = robot.links.len();
                written
            }
            _ => {
                let mut exporter = self.job.write.exporter().t_pose_shown_by(whole);
                if self.names.is_some() || states_bones {
                    exporter = exporter.humanoid(humanoid.clone());
                }
                exporter.write_as(scene, self.job.write.name_of(output))?
            }
        };
        naming
            .iter()
            .for_each(|naming| names::tell(naming, scene, &mut written));
        written.notes.extend(taken);
        // If the file does not state the up axis, its next reader guesses the axis again, and may guess a different
        // axis.
        let states_no_up = row.is_some_and(|row| row.has_sidecar);
        if states_no_up && self.job.source.space.up().is_some() && self.job.write.space.up().is_none() {
            let note = "the written file states no up axis: when you read it, give the same {up} as now; or write it with {out-up} y";
            written.notes.push(spelled(note).into_owned());
        }
        Ok(written)
    }
}

/// Reports the data of a scene that arrays cannot hold. `row` lists what the files hold.
fn add_losses(written: &mut Export, scene: &Scene, row: &FormatInfo) {
    let losses = row.losses(scene, Default::default());
    written.warnings.extend(row.loss_warnings(&losses));
    written.losses = losses;
}

/// The robot of the inputs, if the output's format stores robot joints.
pub(super) fn robot_of_inputs(job: &MotionJob, files: Files<'_>) -> Result<Option<Robot>> {
    let has_joints = RobotFormat::named(&job.write.extension()).is_some();
    match job.read.body.as_ref().filter(|_| has_joints) {
        None => Ok(None),
        Some(body) => match files.import_robot(body) {
            // The file of the body is not a robot.
            Err(error) if error.code() == Code::UnknownFormat => Ok(None),
            robot => robot.map(Some),
        },
    }
}
