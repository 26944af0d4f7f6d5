//! Makes the outputs of a job, for one motion or many, for every command and every language.

mod import;
mod onto;
mod own;
mod skeletons;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use mocap_edit::EditStep;
use mocap_figure::convert::{Conversion, FirstFrame};
use mocap_figure::{Figure, Humanoid, HumanoidMap};
use mocap_formats::{Export, FormatInfo, WriteOption};
use mocap_io::import::{Clips, MemoryFile};
use mocap_retarget::report::ClipReport;
use mocap_retarget::robot::Robot;
use mocap_retarget::{Retargeter, SourceMotion, apply_steps_with_bones, whole};
use mocap_scene::error::{Code, Diagnostic, Error, Result, spelled};
use mocap_scene::files::ReplacePolicy;
use mocap_scene::scene::report::AppliedStep;
use mocap_scene::scene::{Assumption, Scene, Topic, UpAxis};

#[doc(hidden)]
pub use self::import::clips_of;
use self::onto::import_onto;
use self::own::robot_of_inputs;
use self::skeletons::{Shared, Skeleton};
use super::files::Files;
use super::form::Form;
use super::notice::{Listener, Notice, say_all, say_warnings};
use super::{JobTarget, JointNames, MotionJob, SourceFrames};

/// The note if the first frame is dropped.
const REST_LEFT_OUT: &str = "the first frame, a rest pose, is dropped: tick 0 of the output is tick 1 of the file";

/// A job that is ready to run: its options are checked, and its target and second motions are read. It makes outputs
/// from motions.
///
/// [`MotionJob::run`] uses a maker, and writes its output. A program with many motions, or one that inspects the
/// output, uses a maker directly. A maker writes no files.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::{JobTarget, Maker, MotionJob, RobotTarget};
///
/// let mut job = MotionJob::default();
/// job.target = Some(JobTarget::Robot(RobotTarget::new("fixtures/robots/h1.urdf")));
/// job.write.to = Some("csv".to_owned());
/// let maker = Maker::new(&job, &[], &mut |_| {})?; // reads the robot once
/// for motion in ["fixtures/real/cmu_short.bvh", "fixtures/real/cmu_12_01_walk.bvh"] {
///     let made = maker.make(&[motion.into()], "out/motion.csv".as_ref(), &mut |_| {})?;
///     assert!(made.clips[0].mean_degrees() < 30.0);
/// }
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Maker<'a> {
    job: MotionJob,
    files: Files<'a>,
    form: Form,
    /// The bones of the inputs that the caller states.
    bones: HumanoidMap,
    /// The new names of the outputs' joints, if they are renamed.
    names: Option<HumanoidMap>,
    /// The robot of the inputs, if the output has its joints.
    robot: Option<Arc<Robot>>,
    /// The second motions of steps.
    others: Arc<[Scene]>,
    /// The target without a motion, if the job has a target.
    target: Option<Retargeter>,
    threads: Option<usize>,
    /// The skeletons of the motions that [`look_at`](Self::look_at) has read, and the skeleton of each motion.
    skeletons: Arc<[Skeleton]>,
    of_motions: Arc<BTreeMap<PathBuf, usize>>,
}

/// The outputs of a job before they are written.
///
/// The [module](crate) has an example.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct JobOutput {
    /// The files, with their names and bytes.
    pub written: Export,
    /// The written motion; absent for the file of a character and for the joints of a robot.
    pub scene: Option<Scene>,
    /// The bones of [`scene`](Self::scene), as found when the input was read.
    pub humanoid: Option<Humanoid>,
    /// The retargeting quality of each motion.
    pub clips: Vec<ClipReport>,
    /// The motions that could not be retargeted, if one output has several motions, and the reasons.
    pub left_out: Vec<(PathBuf, Diagnostic)>,
}

impl<'a> Maker<'a> {
    /// Prepares `job`. The inputs and the output are arguments of other methods. Files of `given` are in memory instead
    /// of on the disk. In `given`, the name `-` is standard input.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if options contradict each other, [`Code::UnknownFormat`] if the output's format is
    /// unknown or cannot be written; and the errors of reading the target and the second motions.
    pub fn new(job: &MotionJob, given: &'a [MemoryFile<'a>], hear: Listener<'_>) -> Result<Self> {
        Self::of(job, Files { given, has_disk: true }, hear)
    }

    pub(super) fn of(job: &MotionJob, files: Files<'a>, hear: Listener<'_>) -> Result<Self> {
        job.weights.check()?;
        let names = job.source.with.iter().map(|file| file.display().to_string());
        EditStep::second_motions(&job.steps, &Vec::from_iter(names))?;
        let mut job = job.clone();
        job.weights.give_to(&mut job.steps);
        let (form, target, robot) = match &job.target {
            None => {
                let robot = robot_of_inputs(&job, files)?;
                (Form::of_motion(&job.write, robot.is_some())?, None, robot)
            }
            Some(target) => {
                let (form, target) = import_onto(&job, target, files, hear)?;
                (form, Some(target), None)
            }
        };
        if target.is_none() {
            form.check_frames(&job.source.frames)?;
        }
        if let Some(refusal) = form.no_verification(&job).filter(|_| job.verify && target.is_none()) {
            return Err(refusal.into());
        }
        if let (Form::Robot(format), Some(_)) = (form, &robot) {
            let frames = &mut job.source.frames;
            frames.fps = frames.fps.or(format.rate());
        }
        let mut maker = Self {
            bones: job.source.map.bones()?,
            names: job.write.names.as_ref().map(JointNames::names).transpose()?,
            robot: robot.map(Arc::new),
            job,
            files,
            form,
            others: Arc::default(),
            target,
            threads: None,
            skeletons: Arc::default(),
            of_motions: Arc::default(),
        };
        let with = maker.job.source.with.iter();
        let others = with.map(|file| maker.import_second(file, hear));
        maker.others = others.collect::<Result<_>>()?;
        Ok(maker)
    }

    /// The location of the job's files.
    pub(super) fn files(&self) -> Files<'a> {
        self.files
    }

    /// The number of threads that read a file. Default: the number of cores.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = Some(threads);
        self
    }

    /// If the outputs have a T-pose, reads all motions before making an output. Motions of one skeleton then share one
    /// unit, one bone map and one T-pose, inferred from all of them. A file that cannot be read is reported later, with
    /// its output.
    #[must_use]
    pub fn look_at(mut self, motions: &[PathBuf]) -> Self {
        if self.target.is_none() && !self.form.has_t_pose() {
            return self;
        }
        let read = |motion: &PathBuf| (motion.clone(), self.import(motion, &mut |_| {}));
        let (found, of_motions) = skeletons::skeletons(&self, motions.iter().map(read));
        self.skeletons = found.into();
        self.of_motions = of_motions.into();
        self
    }

    /// The unit, the up axis, the bone map and the T-pose that a motion shares with others, as text. An output with a
    /// different text is out of date. `None` for a motion that shares no skeleton with another motion in
    /// [`look_at`](Self::look_at).
    pub fn shared_figure(&self, motion: &Path) -> Option<String> {
        self.skeletons.get(*self.of_motions.get(motion)?)?.says()
    }

    /// The data that a motion shares with other motions of its skeleton.
    fn shared(&self, scene: &Scene) -> Option<Shared<'_>> {
        self.skeletons.iter().find_map(|skeleton| skeleton.shared(scene))
    }

    /// Whether lengths in the output are in the unit of the motion.
    #[doc(hidden)]
    pub fn keeps_units(&self) -> bool {
        self.form.keeps_units() && self.target.is_none() && self.job.write.space.metres_per_unit().is_none()
    }

    /// Selects a clip of the inputs, by its number from 0.
    #[doc(hidden)]
    #[must_use]
    pub fn clip(mut self, clip: usize) -> Self {
        self.job.read.clip = Clips::Index(clip);
        self
    }

    /// Sets the up axis of the inputs, for a caller who knows it from other motions.
    #[must_use]
    pub fn up(mut self, up: UpAxis) -> Self {
        self.job.source.space.up.up = super::UpChoice::Axis(up);
        self
    }

    /// The row of the format, if the output is a scene in a format of the table.
    pub fn format(&self) -> Option<&'static FormatInfo> {
        match self.form {
            Form::Scene(row) => Some(row),
            Form::Character | Form::Robot(_) | Form::Arrays(_) => None,
        }
    }

    /// The extension of the outputs, if it differs from the name of the format.
    #[doc(hidden)]
    pub fn extension(&self) -> Option<&'static str> {
        self.form.extension()
    }

    /// The reason why an option of writing has no effect on the output; `None` if it has an effect.
    pub fn refusal(&self, option: WriteOption) -> Option<Diagnostic> {
        self.form.refusal(option, &self.job.write.extension())
    }

    /// Refuses an output that would replace an input, or a file of the user.
    ///
    /// # Errors
    /// As [`ReplacePolicy::check`].
    pub fn check(&self, policy: &ReplacePolicy, output: &Path) -> Result<()> {
        match self.form {
            _ if output == Path::new("-") => Ok(()),
            Form::Scene(row) if row.states_origin => policy.check(output),
            _ => policy.check_ahead(output),
        }
    }

    /// Describes the retargeted motions that are worse than the job allows.
    pub fn problem(&self, clips: &[ClipReport]) -> Option<String> {
        self.job.target.as_ref()?.problem(clips)
    }

    /// Makes the output of motions under the name `output`, and writes nothing.
    ///
    /// # Errors
    /// The errors of reading, of the steps, of [`Retargeter`] and of
    /// [`Exporter::write_as`](mocap_io::Exporter::write_as), with the file.
    pub fn make(&self, motions: &[PathBuf], output: &Path, hear: Listener<'_>) -> Result<JobOutput> {
        match &self.target {
            Some(target) => self.make_onto(target.clone(), motions, output, hear),
            None => {
                let motion = one(motions)?;
                let source = self.prepare(self.import(motion, hear)?, motion, hear)?;
                self.make_of(source, motion, output, hear)
            }
        }
    }

    /// Makes the output of one motion from the result of [`prepare`](Self::prepare).
    ///
    /// # Errors
    /// The errors of the steps, of [`Retargeter`] and of [`Exporter::write_as`](mocap_io::Exporter::write_as), with the
    /// file.
    pub fn make_of(&self, source: SourceMotion, motion: &Path, output: &Path, hear: Listener<'_>) -> Result<JobOutput> {
        if let Some(target) = &self.target {
            let mut target = target.clone();
            self.add(source, motion, &mut target, hear)?;
            return self.made_onto(target, output);
        }
        let SourceMotion {
            mut scene,
            bones,
            whole,
            ..
        } = source;
        let bones = bones.unwrap_or_else(|| Humanoid::of(&scene));
        let humanoid = self.change(&mut scene, bones, motion, hear)?;
        let written = self.write(&mut scene, &humanoid, whole, motion, output);
        let written = written.and_then(|written| self.check_losses(written));
        Ok(JobOutput {
            written: written.map_err(|error| error.with_path(motion))?,
            scene: Some(scene),
            humanoid: Some(humanoid),
            clips: Vec::new(),
            left_out: Vec::new(),
        })
    }

    /// Refuses an output that lacks data of its inputs, if the job is strict.
    fn check_losses(&self, written: Export) -> Result<Export> {
        if !self.job.read.strict || written.losses.is_empty() {
            return Ok(written);
        }
        let lost: Vec<String> = written.losses.iter().map(ToString::to_string).collect();
        let message = format!("the output would lack some data of the input: {}", lost.join(", "));
        Err(Diagnostic::new(Code::NotCarriedOver, message)
            .help("write another format, or leave out {strict}")
            .into())
    }

    /// Converts a motion from [`import`](Self::import) to the unit, the axes and the frames that the steps need, and
    /// finds its bones.
    ///
    /// # Errors
    /// As [`Conversion::apply`], and if a stated bone is not among the joints, with the file.
    pub fn prepare(&self, mut scene: Scene, motion: &Path, hear: Listener<'_>) -> Result<SourceMotion> {
        let prepared = match &self.target {
            Some(target) => {
                self.job.source.space.state(&mut scene);
                say_warnings(&mut scene, motion, hear);
                let prepared = match self.shared(&scene) {
                    Some(Shared { figure, shown }) => target.prepare_shown(scene, &figure, Some(shown)),
                    None => target.prepare(scene),
                };
                prepared.inspect(|source| say_all(&source.assumptions, hear))
            }
            None => self.convert(scene, motion, hear),
        };
        prepared.map_err(|error| error.with_path(motion))
    }

    fn convert(&self, mut scene: Scene, motion: &Path, hear: Listener<'_>) -> Result<SourceMotion> {
        let frames = &self.job.source.frames;
        say_all(&scene.metadata.assumptions, hear);
        self.job.source.space.state(&mut scene);
        let mut conversion = self.conversion();
        conversion.check()?;
        let known = scene.metadata.steps.len();
        let changed = self.changed_clip(&scene)?;
        // The other clips keep their frames.
        let of_clip = match changed {
            Some(clip) => self.convert_frames(&mut scene, clip)?,
            None => Vec::new(),
        };
        if changed.is_some() {
            conversion = conversion.all_frames();
        }
        let (figure, shown) = match self.shared(&scene) {
            Some(Shared { figure, shown }) => (figure, Some(shown)),
            None => (Figure::mapped(&scene, &self.bones)?, None),
        };
        let whole = match self.form.has_t_pose() {
            true => whole(&mut scene, &figure, shown, &conversion)?,
            false => None,
        };
        let (mut decided, inserted) = conversion.convert(&mut scene, &figure)?;
        if changed.is_some() {
            decided.retain(|decision| decision.topic != Topic::FirstFrame);
            decided.extend(of_clip);
        }
        say_warnings(&mut scene, motion, hear);
        say_all(&decided, hear);
        let is_rest = |decision: &Assumption| decision.topic == Topic::FirstFrame;
        let is_of_clips = say_of_clips(&scene, known, hear);
        if decided.iter().any(is_rest) && !is_of_clips {
            match frames.drop_first_frame {
                FirstFrame::Keep => hear(Notice::Note(&spelled(
                    "the first frame is kept; {drop-first-frame} auto drops it",
                ))),
                FirstFrame::DropRestPose => hear(Notice::Note(REST_LEFT_OUT)),
                _ => {}
            }
        }
        let assumptions = scene.metadata.assumptions.clone();
        let mut source = SourceMotion::converted(scene);
        (source.bones, source.assumptions) = (Some(figure.humanoid.after(inserted)), assumptions);
        if self.keeps_units() {
            // No length is converted. The unit of the file is recorded nevertheless, because the units of several files
            // may differ.
            source.assumptions.retain(|known| known.topic != Topic::Unit);
            source.assumptions.push(figure.survey.unit_of_file());
        }
        source.whole = whole;
        Ok(source)
    }

    /// Converts the frames of one clip.
    fn convert_frames(&self, scene: &mut Scene, clip: usize) -> Result<Vec<Assumption>> {
        let SourceFrames {
            trim,
            fps,
            drop_first_frame,
            ..
        } = self.job.source.frames;
        let frames = SourceFrames {
            trim,
            fps,
            drop_first_frame,
            ..SourceFrames::default()
        };
        let converted = scene.change_clip(clip, |scene| {
            let figure = Figure::mapped(scene, &self.bones)?;
            frames.conversion().keep_units(true).convert(scene, &figure)
        });
        let decided = converted.map_err(|error| scene.in_clip(clip, error))?.0;
        let is_of_frames = |decision: &Assumption| matches!(decision.topic, Topic::FirstFrame | Topic::FrameRate);
        Ok(decided.into_iter().filter(is_of_frames).collect())
    }

    /// The conversion from the space and the frames of an input to the space and the frames of the output.
    fn conversion(&self) -> Conversion {
        let MotionJob { source, write, .. } = &self.job;
        let mut conversion = source.frames.conversion().bones(self.bones.clone());
        if let Some(metres) = source.space.metres_per_unit() {
            conversion = conversion.metres_per_unit(metres);
        }
        if let Some(up) = source.space.up() {
            conversion = conversion.up(up);
        }
        write.space.of(conversion).keep_units(self.form.keeps_units())
    }

    /// Applies the steps to a scene with the bones `found`. Returns the bones of the changed scene.
    fn apply_steps(&self, scene: &mut Scene, found: Humanoid, hear: Listener<'_>) -> Result<Humanoid> {
        // The bones that the caller states are recorded.
        let stated = (!self.bones.is_empty()).then(|| found.clone());
        let others: Vec<&Scene> = self.others.iter().collect();
        let known = scene.warnings.len();
        let steps = (self.job.steps.as_slice(), self.changed_clip(scene)?);
        let (reports, found) = apply_steps_with_bones(scene, steps, &others, stated, found)?;
        if self.job.read.strict && scene.warnings.len() > known {
            let mut of_steps = scene.warnings.split_off(known);
            return Err(Error::from(of_steps.remove(0)).with_warnings(of_steps));
        }
        reports.iter().for_each(|report| hear(Notice::Step(report)));
        Ok(found)
    }

    fn is_onto_robot(&self) -> bool {
        matches!(self.job.target, Some(JobTarget::Robot(_)))
    }
}

/// In a scene of several clips, reports each clip whose first frame, a rest pose, was dropped. The steps of the scene
/// from the index `known` on state these clips. Returns whether there are such clips.
fn say_of_clips(scene: &Scene, known: usize, hear: Listener<'_>) -> bool {
    let mut is_of_clips = false;
    for step in &scene.metadata.steps[known..] {
        if let AppliedStep::OfClip { index, steps } = step
            && matches!(steps[..], [AppliedStep::Trim { first: 1.0, .. }, ..])
        {
            is_of_clips = true;
            let name = &scene.animations[*index].name;
            hear(Notice::Note(&format!("clip {index} \"{name}\": {REST_LEFT_OUT}")));
        }
    }
    is_of_clips
}

fn one(motions: &[PathBuf]) -> Result<&Path> {
    match motions {
        [motion] => Ok(motion),
        [] => Err(no_input()),
        motions => {
            let message = format!("the job has {} inputs, but one output", motions.len());
            let help = "name one motion in source.inputs, and the second motion that a step needs in source.with";
            Err(Diagnostic::new(Code::InvalidValue, message).help(help).into())
        }
    }
}

fn no_input() -> Error {
    Diagnostic::new(Code::InvalidValue, "the job names no input")
        .help("name the motion files in source.inputs")
        .into()
}
