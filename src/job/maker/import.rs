//! Reads the motions of a job, and chooses their clips.

use std::path::Path;

use mocap_formats::FormatInfo;
use mocap_io::import::{Clips, Importer};
use mocap_scene::error::{Code, Diagnostic, Error, Result, spelled};
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Format, Scene};

use super::Maker;
use crate::form::Form;
use crate::meshes;
use crate::notice::{Listener, Notice, clip_taken, say_warnings};

impl Maker<'_> {
    /// Reads a motion with the options of the job, and does not change it yet.
    ///
    /// # Errors
    /// As [`Importer::import`](mocap_io::Importer::import); [`Code::NoMotion`] if the job needs a motion.
    pub fn import(&self, motion: &Path, hear: Listener<'_>) -> Result<Scene> {
        self.import_as(motion, false, hear)
    }

    /// Reads a motion, or the second motion of a step.
    fn import_as(&self, motion: &Path, is_second: bool, hear: Listener<'_>) -> Result<Scene> {
        let job = &self.job;
        let is_of_all = job.read.clip == Clips::All;
        // For another body, the named clip is the only one that is retargeted.
        let has_several = !is_second && !self.holds_one_clip() && (is_of_all || job.target.is_none());
        let keeps_clips = has_several && !job.steps.is_empty();
        let importer = match keeps_clips {
            true => job.importer().clips(Clips::All),
            false => job.importer(),
        };
        let importer = match self.form {
            Form::Scene(row) if self.target.is_none() => {
                let mesh = meshes::shown(job, Some(row));
                match (job.steps.is_empty(), mesh) {
                    // The steps need the skin, even if it is not written.
                    (false, SkeletonMesh::None) => importer.with_own_meshes(),
                    (has_none, mesh) => importer
                        .skeleton_mesh(mesh)
                        .gltf_meshes(row.has_file_meshes || !has_none)
                        .morph_targets(row.takes_morph_targets(motion)),
                }
            }
            _ => importer.with_own_meshes(),
        };
        let importer = match self.threads {
            Some(threads) => importer.threads(threads),
            None => importer,
        };
        let import = |importer: &Importer| self.files.import(importer, motion);
        let mut scene = importer.at_rate(job.source.frames.fps, import)?;
        if motion.is_dir() {
            hear(Notice::Note(&spelled(
                "the files of this folder make one take; to write one file for each of them, name an output folder: \
                 {output} FOLDER {to} glb",
            )));
        }
        say_warnings(&mut scene, motion, hear);
        meshes::draw_anew(job, self.format(), &mut scene);
        if !job.steps.is_empty() || self.target.is_some() {
            require_motion(&scene, motion)?;
        }
        if keeps_clips {
            let changed = job.read.clip.index_in(&scene);
            let changed = changed.map_err(|error| error.with_path(motion))?;
            // If the output is the file of the scene with other animations, this file keeps its other clips.
            if let Some(index) = changed
                && meshes::is_passed_through(job, self.format(), &scene)
            {
                select(&mut scene, index);
            }
        } else if self.is_onto_robot() || !job.steps.is_empty() {
            if !is_second && !self.is_onto_robot() && bodily(&scene).count() > 1 {
                return Err(several_clips(&scene).with_path(motion));
            }
            self.take_main_clip(&mut scene, motion, hear);
        }
        meshes::keep_or_drop(job, self.format(), &mut scene, motion, hear)?;
        Ok(scene)
    }

    /// Drops all clips except the main clip, and says so.
    fn take_main_clip(&self, scene: &mut Scene, motion: &Path, hear: Listener<'_>) {
        let Some(note) = clip_taken(scene, None) else { return };
        let index = scene.main_clip();
        match self.is_onto_robot() {
            // In a folder, notes about single files are not printed, but warnings are.
            true => {
                let count = scene.animations.len();
                let message = format!("the output has only clip {index} of {count}");
                let warning = Diagnostic::new(Code::NotCarriedOver, message)
                    .help("{clip} selects another clip; if the output is a folder, each clip gets a file");
                hear(Notice::Warnings(motion, &[warning]));
            }
            false => hear(Notice::Note(&note)),
        }
        select(scene, index);
    }

    /// Reads the second motion of a step, prepared like the first motion.
    pub(super) fn import_second(&self, file: &Path, hear: Listener<'_>) -> Result<Scene> {
        let scene = self.import_as(file, true, hear)?;
        Ok(self.prepare(scene, file, hear)?.scene)
    }

    /// The clips of a file, with their numbers and names, if the file has several and an output holds one clip. A file
    /// that cannot be read is reported later, with its output.
    #[doc(hidden)]
    pub fn separate_clips(&self, motion: &Path) -> Vec<(usize, String)> {
        if !self.holds_one_clip() || self.job.read.clip != Clips::All {
            return Vec::new();
        }
        let importer = self.job.importer().threads(1).skeleton_mesh(SkeletonMesh::None);
        clips_of(motion, || self.files.import(&importer, motion))
    }

    /// Whether an output holds only one clip.
    fn holds_one_clip(&self) -> bool {
        match self.form {
            Form::Scene(row) => row.has_one_clip || self.is_onto_robot(),
            Form::Robot(_) | Form::Arrays(_) => true,
            Form::Character => false,
        }
    }

    /// The clip of a scene from [`import`](Self::import) that the steps change; `None` for all. The other clips stay in
    /// the scene.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if the scene does not have the clip.
    #[doc(hidden)]
    pub fn changed_clip(&self, scene: &Scene) -> Result<Option<usize>> {
        match scene.animations.len() {
            // The import dropped the other clips.
            0 | 1 => Ok(None),
            _ => self.job.read.clip.index_in(scene),
        }
    }
}

/// The clips of a file, with their numbers and names, for an output that holds one clip. Formats with one clip, and
/// files that cannot be read, give no clips.
#[doc(hidden)]
pub fn clips_of(motion: &Path, import: impl FnOnce() -> Result<Scene>) -> Vec<(usize, String)> {
    let format = FormatInfo::of_output(motion).map(|row| row.format);
    if !matches!(format, Some(Format::Gltf | Format::Fbx | Format::Usd)) {
        return Vec::new();
    }
    let clips = |scene: Scene| {
        bodily(&scene)
            .map(|index| (index, scene.animations[index].name.clone()))
            .collect()
    };
    import().map(clips).unwrap_or_default()
}

/// The clips in which not only the face moves.
fn bodily(scene: &Scene) -> impl Iterator<Item = usize> + '_ {
    (0..scene.animations.len()).filter(|index| scene.face_curves_alone(*index).is_none())
}

fn require_motion(scene: &Scene, motion: &Path) -> Result<()> {
    match scene.animations.is_empty() {
        false => Ok(()),
        true => {
            let error = Error::from(Diagnostic::new(Code::NoMotion, "the file contains no motion"));
            Err(error.with_path(motion))
        }
    }
}

/// Drops all clips but one, as if the import had read only this clip.
fn select(scene: &mut Scene, index: usize) {
    scene.keep_animation(index);
    scene.metadata.steps.push(AppliedStep::SelectClip { index });
    if let (Some(origin), Some(clip)) = (&mut scene.metadata.origin, scene.animations.first()) {
        origin.frames = clip.frame_count() as u64;
        origin.frame_time = clip.ticks_per_second.recip();
    }
}

/// Refuses several clips for an output that holds one.
fn several_clips(scene: &Scene) -> Error {
    let clips = scene.animations.iter().enumerate();
    let clips: Vec<String> = clips
        .map(|(index, clip)| format!("{index} \"{}\"", clip.name))
        .collect();
    let message = "the file has several clips, but the output holds one";
    Diagnostic::new(Code::InvalidValue, message)
        .expected_found("one clip", clips.join(", "))
        .help("name a clip by {clip}; if the output is a folder, each clip gets a file")
        .into()
}
