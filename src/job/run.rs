//! Does what a job says.

use std::path::{Path, PathBuf};

use super::robot_format::RobotFormat;
use super::{Feet, Job, JobReport, Onto};
use crate::convert::Conversion;
use crate::edit::EditStep;
use crate::error::{Code, Diagnostic, Error, Result};
use crate::figure::humanoid;
use crate::files::ReplacePolicy;
use crate::format::gltf::Provenance;
use crate::format::{FormatInfo, Written};
use crate::import::{Importer, MemoryFile};
use crate::process::SkeletonMesh;
use crate::retargeting::{Retargeting, RetargetingOptions, Target};
use crate::scene::{AppliedStep, Scene};

/// Where the files of a job are.
pub(super) enum Files<'a> {
    /// On a disk.
    Disk,
    /// In memory, under the names that the job has for them.
    Memory(&'a [MemoryFile<'a>]),
}

/// What a job makes, before it is written.
pub(super) struct Made {
    pub(super) written: Written,
    pub(super) report: JobReport,
    /// What was done to the motion, for a comparison with its source.
    pub(super) provenance: Option<Provenance>,
}

impl Files<'_> {
    fn import(&self, importer: &Importer, path: &Path) -> Result<Scene> {
        match self {
            Self::Disk => importer.import(path),
            Self::Memory(files) => {
                let (file, others) = split(files, path)?;
                importer.read_among(file, &others)
            }
        }
    }

    fn import_target(&self, job: &Job, onto: &Onto) -> Result<Target> {
        let file = onto.file();
        // A skeleton needs no mesh in FBX.
        let mesh = match job.write.extension().as_str() {
            "fbx" => SkeletonMesh::Own,
            _ => SkeletonMesh::Skinned,
        };
        let importer = Importer::new().skeleton_mesh(mesh);
        let plain = Importer::new().skeleton_mesh(SkeletonMesh::None);
        match (self, onto) {
            (_, Onto::Skeleton(_)) => Ok(self.import(&plain, file)?.into()),
            (Self::Disk, Onto::Character(_)) => Target::import(file, &importer),
            (Self::Disk, Onto::Robot(_)) => Ok(Importer::new().import_robot(file)?.into()),
            (Self::Memory(files), Onto::Robot(_)) => {
                let (robot, _) = split(files, file)?;
                Ok(Importer::new().read_robot(robot.bytes, file)?.into())
            }
            (Self::Memory(files), Onto::Character(_)) => {
                let (character, others) = split(files, file)?;
                let with_skin = Importer::new().gltf_meshes(true);
                match with_skin.read_character(character, &others) {
                    Err(error) if error.code() == Code::UnknownFormat => Ok(self.import(&importer, file)?.into()),
                    read => Ok(read?.into()),
                }
            }
        }
    }
}

/// The file of a name, and the others.
fn split<'a>(files: &[MemoryFile<'a>], path: &Path) -> Result<(MemoryFile<'a>, Vec<MemoryFile<'a>>)> {
    let is_named = |file: &&MemoryFile<'_>| Path::new(file.name) == path;
    let Some(file) = files.iter().find(is_named) else {
        let message = format!(
            "the job names the file {:?}, which was not given",
            path.display().to_string()
        );
        return Err(Diagnostic::new(Code::MissingFile, message).into());
    };
    let others = files.iter().filter(|file| !is_named(file)).copied();
    Ok((*file, others.collect()))
}

impl Job {
    /// Makes the output, in memory.
    pub(super) fn make(&self, files: &Files<'_>) -> Result<Made> {
        match &self.onto {
            None => self.make_motion(files),
            Some(onto) => self.make_onto(files, onto),
        }
    }

    /// Which files the output may replace.
    pub(super) fn policy(&self) -> ReplacePolicy {
        let target = self.onto.as_ref().map(Onto::file);
        let inputs = self.source.inputs.iter().chain(&self.source.with).chain(target);
        ReplacePolicy::new(inputs).force(self.write.force)
    }

    /// A motion on its own skeleton.
    fn make_motion(&self, files: &Files<'_>) -> Result<Made> {
        let input = self.one_input()?;
        let (row, path) = self.write.row()?;
        let mut report = JobReport::default();
        let mut scene = self.import(files, input, row, &mut report)?;
        let with = self.source.with.iter();
        let others = with.map(|file| self.import(files, file, row, &mut report));
        let others = others.collect::<Result<Vec<Scene>>>()?;
        self.apply_steps(&mut scene, &others, &mut report)
            .map_err(|error| error.with_path(input))?;
        let mut exporter = self.write.exporter();
        if row.states_bones {
            exporter = exporter.humanoid(humanoid(&scene).with_map(&scene, self.source.map.bones()?)?);
        }
        if let (true, [first, _, ..]) = (row.has_one_clip, scene.animations.as_slice()) {
            report.notes.push(format!(
                "clip: 0 \"{}\" of {}, because {} has one; --clip takes another",
                first.name,
                scene.animations.len(),
                row.name
            ));
        }
        let written = exporter
            .write_as(&scene, &path)
            .map_err(|error| error.with_path(input))?;
        let provenance = Some(Provenance::of(&scene));
        Ok(Made {
            written,
            report,
            provenance,
        })
    }

    /// A motion, in the unit and the axes in which steps and the format have it.
    fn import(&self, files: &Files<'_>, input: &Path, row: &FormatInfo, report: &mut JobReport) -> Result<Scene> {
        let mesh = match self.write.mesh {
            Some(mesh) => mesh.into(),
            None if row.has_file_meshes => SkeletonMesh::Own,
            None => SkeletonMesh::Skinned,
        };
        let importer = || {
            let importer = self.read.importer().skeleton_mesh(mesh);
            importer.gltf_meshes(row.has_file_meshes)
        };
        let import = |importer: Importer| files.import(&importer, input);
        let mut scene = import_to_resample(importer, import, self.source.frames.fps)?;
        report.warnings.append(&mut scene.warnings);
        if !self.steps.is_empty() {
            self.require_motion(&scene, input)?;
            if scene.animations.len() > 1 {
                let count = scene.animations.len();
                report.notes.push(format!(
                    "{}: the first of {count} animations was taken; --clip names another",
                    input.display()
                ));
                scene.animations.truncate(1);
                scene.metadata.steps.push(AppliedStep::SelectClip { index: 0 });
            }
        }
        report
            .notes
            .extend(scene.metadata.assumptions.iter().map(ToString::to_string));
        let decided = self.conversion(row)?.apply(&mut scene);
        let decided = decided.map_err(|error| error.with_path(input))?;
        report.notes.extend(decided.iter().map(ToString::to_string));
        Ok(scene)
    }

    /// From the space and the frames of an input to those of the output.
    fn conversion(&self, row: &FormatInfo) -> Result<Conversion> {
        let space = &self.source.space;
        let mut conversion = self.source.frames.conversion().bones(self.source.map.bones()?);
        if let Some(metres) = space.metres_per_unit() {
            conversion = conversion.metres_per_unit(metres);
        }
        if let Some(up) = space.up() {
            conversion = conversion.up(up);
        }
        if let Some(metres) = self.write.space.metres_per_unit() {
            conversion = conversion.out_metres_per_unit(metres);
        }
        if let Some(up) = self.write.space.up() {
            conversion = conversion.out_up(up);
        }
        Ok(conversion.root(self.source.frames.root).keep_units(row.keeps_units()))
    }

    fn apply_steps(&self, scene: &mut Scene, others: &[Scene], report: &mut JobReport) -> Result<()> {
        let map = self.source.map.bones()?;
        let bones = match map.is_empty() {
            true => None,
            false => Some(humanoid(scene).with_map(scene, map)?),
        };
        let others: Vec<&Scene> = others.iter().collect();
        report
            .steps
            .append(&mut EditStep::apply_all(scene, &self.steps, &others, bones.as_ref())?);
        Ok(())
    }

    /// Motions on another body.
    fn make_onto(&self, files: &Files<'_>, onto: &Onto) -> Result<Made> {
        let mut report = JobReport::default();
        let target = files.import_target(self, onto)?;
        let options = RetargetingOptions::new()
            .scale(onto.scale().0)
            .lock_feet(onto.feet() == Feet::Lock)
            .source_bones(self.source.map.bones()?)
            .target_bones(onto.bones()?)
            .conversion(self.source.frames.conversion().root(self.source.frames.root));
        let options = match onto {
            Onto::Character(body) | Onto::Skeleton(body) => options.replace_animations(body.replace_animations),
            Onto::Robot(robot) => options.velocity_limits(robot.velocity_limits),
        };
        let mut retargeting = Retargeting::onto(target, options).map_err(|error| error.with_path(onto.file()))?;
        for input in self.inputs()? {
            self.add(files, input, &mut retargeting, &mut report)
                .map_err(|error| error.with_path(input))?;
        }
        let written = match onto {
            Onto::Robot(_) => RobotFormat::of(&self.write)?.write(&retargeting)?,
            Onto::Character(_) | Onto::Skeleton(_) => self.write_onto(&retargeting)?,
        };
        report.clips = retargeting.into_clips().into_iter().map(|clip| clip.report).collect();
        report.problem = self.problem(onto, &report);
        Ok(Made {
            written,
            report,
            provenance: None,
        })
    }

    /// Puts the motions of a file on the target.
    fn add(
        &self,
        files: &Files<'_>,
        input: &Path,
        retargeting: &mut Retargeting,
        report: &mut JobReport,
    ) -> Result<()> {
        let importer = || self.read.importer().skeleton_mesh(SkeletonMesh::None);
        let import = |importer: Importer| files.import(&importer, input);
        let mut scene = import_to_resample(importer, import, self.source.frames.fps)?;
        report.warnings.append(&mut scene.warnings);
        self.require_motion(&scene, input)?;
        if let (Target::Robot(_), count @ 2..) = (retargeting.target(), scene.animations.len()) {
            report.notes.push(format!(
                "{}: the first of {count} animations was taken; --clip names another",
                input.display()
            ));
            scene.animations.truncate(1);
        }
        self.source.space.state(&mut scene);
        let mut source = retargeting.prepare(scene)?;
        report.notes.extend(source.assumptions.iter().map(ToString::to_string));
        self.apply_steps(&mut source.scene, &[], report)?;
        let name = input.file_stem().unwrap_or(input.as_os_str()).to_string_lossy();
        if retargeting.add(source.named(name))?.is_rest_pose_left_out {
            let file = input.display();
            report
                .notes
                .push(format!("{file}: the first frame, a rest pose, is left out"));
        }
        Ok(())
    }

    /// The output of motions on a character or a skeleton.
    fn write_onto(&self, retargeting: &Retargeting) -> Result<Written> {
        let extension = self.write.extension();
        let is_character = matches!(retargeting.target(), Target::Character(_));
        if is_character && ["glb", "gltf", "vrm"].contains(&extension.as_str()) {
            let written = retargeting.character_file_with(&self.write.smaller.gltf())?;
            let (bytes, gltf) = written.unwrap_or_default();
            let mut written = Written::from(bytes);
            written.warnings = gltf.warnings;
            written.error = gltf.achieved;
            return Ok(written);
        }
        let (row, path) = self.write.row()?;
        if row.has_one_clip && retargeting.clips().len() > 1 {
            let message = format!("{} has one motion; name one", row.name);
            return Err(Diagnostic::new(Code::Unrepresentable, message).into());
        }
        let scene = match row.keeps_units() {
            true => retargeting.scene(),
            false => retargeting.scene_in_metres()?,
        };
        let mut exporter = self.write.exporter();
        if let Some(bones) = retargeting.humanoid().filter(|_| row.states_bones) {
            exporter = exporter.humanoid(bones.clone());
        }
        exporter.write_as(&scene, &path)
    }

    /// What of the motions is worse than the job allows.
    fn problem(&self, onto: &Onto, report: &JobReport) -> Option<String> {
        match onto {
            Onto::Robot(robot) => {
                let required = robot.require?;
                let clip = report.clips.iter().find(|clip| !required.allows(clip.verdict()))?;
                let (name, verdict) = (clip.name(), clip.verdict().as_str());
                Some(format!("{name}: the motion is {verdict}, which the job refuses"))
            }
            Onto::Character(body) | Onto::Skeleton(body) => {
                let allowed = body.max_angle?.0;
                let clips = report.clips.iter().filter_map(|clip| clip.body());
                let worst = clips.max_by(|a, b| a.worst_degrees().total_cmp(&b.worst_degrees()))?;
                worst.problem(allowed)
            }
        }
    }

    fn require_motion(&self, scene: &Scene, input: &Path) -> Result<()> {
        match scene.animations.is_empty() {
            false => Ok(()),
            true => {
                let error = Error::from(Diagnostic::new(Code::NoMotion, "there is no motion in it"));
                Err(error.with_path(input))
            }
        }
    }

    fn inputs(&self) -> Result<&[PathBuf]> {
        match self.source.inputs.as_slice() {
            [] => Err(Diagnostic::new(Code::InvalidValue, "the job names no input")
                .help("name the motion files in source.inputs")
                .into()),
            inputs => Ok(inputs),
        }
    }

    fn one_input(&self) -> Result<&Path> {
        match self.inputs()? {
            [input] => Ok(input),
            inputs => {
                let message = format!("the job has {} inputs, and one output", inputs.len());
                let help = "name one motion in source.inputs, and second motions of steps in source.with";
                Err(Diagnostic::new(Code::InvalidValue, message).help(help).into())
            }
        }
    }
}

/// Imports a file at its own frame rate, to be resampled to `rate`. Where the file states none, `rate` is its rate too.
fn import_to_resample(
    importer: impl Fn() -> Importer,
    import: impl Fn(Importer) -> Result<Scene>,
    rate: Option<f64>,
) -> Result<Scene> {
    use crate::scene::Topic;

    let assumes_rate = |scene: &Scene| {
        let mut assumptions = scene.metadata.assumptions.iter();
        assumptions.any(|assumption| assumption.topic == Topic::FrameRate)
    };
    match (import(importer()), rate) {
        (Err(error), Some(rate)) if error.code() == Code::FrameTime => import(importer().frame_rate(rate)),
        (Ok(scene), Some(rate)) if assumes_rate(&scene) => import(importer().frame_rate(rate)),
        (result, _) => result,
    }
}
