//! One piece of work: what a command line, a call from Python, JavaScript or C, and a job file all mean.
//!
//! A [`Job`] reads motions ([`Reading`]), says what is known of them and which frames are taken ([`Sources`]), changes
//! them ([`EditStep`]), retargets them ([`JobTarget`]), and writes the result ([`Writing`]). It serializes:
//! `src/job/job.schema.json` is its JSON Schema, `mocap run job.json` does what a file says, and `--print-job` prints
//! what a command line means.
//!
//! ```
//! use mocap::job::Job;
//!
//! let job = Job::from_json(r#"{
//!     "source": {"inputs": ["walk.bvh"], "space": {"unit": "cm"}, "frames": {"trim": "0..2.5"}},
//!     "steps": [{"step": "smooth", "cut-off": 8}, "foot-lock"],
//!     "target": {"character": {"file": "hero.vrm"}},
//!     "write": {"output": "hero_walk.vrm"}
//! }"#)?;
//! assert_eq!(job.steps.len(), 2);
//! # Ok::<(), mocap::Error>(())
//! ```

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

pub mod arrays;
mod file_graph;
mod files;
mod form;
mod graph;
mod graph_job;
#[doc(hidden)]
pub mod internals;
mod maker;
mod meshes;
mod names;
mod reading;
mod report;
mod robot_format;
mod said;
mod smaller;
mod source;
mod survey;
mod target;
mod text;
pub mod verify;
mod walk;
mod writing;

use std::path::{Path, PathBuf};

use mocap_edit::EditStep;
use mocap_formats::gltf::Provenance;
use mocap_formats::{Written, WrittenFile};
use mocap_io::import::MemoryFile;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::ReplacePolicy;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

pub use self::file_graph::FileGraph;
use self::files::Files;
pub use self::graph::{GraphReport, Graphing};
pub use self::maker::{Made, Maker};
pub use self::names::JointNames;
pub use self::reading::Reading;
pub use self::report::{JobReport, OutputFile};
pub use self::robot_format::RobotFormat;
pub use self::said::Said;
pub use self::smaller::Smaller;
pub use self::source::{BoneMap, SourceFrames, SourceMap, SourceSpace, SourceUp, Sources};
pub use self::survey::Surveying;
pub use self::target::{CharacterTarget, Feet, JobTarget, RequiredVerdict, RobotTarget, SkeletonTarget};
pub use self::text::{Angle, Length, UnitChoice, UpChoice};
pub use self::walk::Walking;
pub use self::writing::{DrawnMesh, OutBoneAxis, OutSpace, OutUp, Writing, WritingBvh, WritingFbx};
use crate::verify::{Verification, Verifier};

/// One piece of work: inputs, changes, another body, an output.
///
/// The [module](self) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Job {
    /// How the inputs are read.
    #[serde(skip_serializing_if = "is_default")]
    pub read: Reading,
    /// The inputs, and what is known of them.
    pub source: Sources,
    /// What changes the motion, in this order. With a step, the first animation of an input is taken.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(schema_with = "steps_schema"))]
    pub steps: Vec<EditStep>,
    /// What the motions are retargeted to. Default: they keep their skeletons.
    #[serde(skip_serializing_if = "is_default")]
    pub target: Option<JobTarget>,
    /// What is to be known of the inputs, instead of an output of their motion: a row for each clip, in the report and
    /// in the table that `write` names, if it does.
    #[serde(skip_serializing_if = "is_default")]
    pub survey: Option<Surveying>,
    /// How the moments of the inputs are compared: the output is their motion graph, and with `walk` a walk over it.
    #[serde(skip_serializing_if = "is_default")]
    pub graph: Option<Graphing>,
    /// The walk over a motion graph that is the motion of the job: over that of `graph`, or over the file of one, which
    /// is then the input.
    #[serde(skip_serializing_if = "is_default")]
    pub walk: Option<Walking>,
    /// The output.
    pub write: Writing,
}

impl Job {
    /// The JSON Schema of a job, as text.
    pub const SCHEMA: &str = include_str!("job.schema.json");

    /// A job without an input and an output.
    pub fn new() -> Self {
        Self::default()
    }

    /// The job of a JSON text.
    ///
    /// ```
    /// use mocap::job::Job;
    ///
    /// let error = Job::from_json(r#"{"write": {"outptu": "a.glb"}}"#).unwrap_err();
    /// assert!(error.to_string().contains("write.outptu: unknown field `outptu`, expected one of `output`"));
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`], with the path of the value, where the text is no job.
    pub fn from_json(text: &str) -> Result<Self> {
        // An empty list would be an empty job.
        if !text.trim_start().starts_with('{') {
            let message = "the job: it must be a JSON object";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let mut deserializer = serde_json::Deserializer::from_str(text);
        let read = serde_path_to_error::deserialize(&mut deserializer);
        if read.is_ok() && deserializer.end().is_err() {
            let message = "the job: something follows the JSON object";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        read.map_err(|error: serde_path_to_error::Error<serde_json::Error>| {
            let (path, message) = (error.path().to_string(), error.inner().to_string());
            let message = match path.as_str() {
                "." | "?" => format!("the job: {message}"),
                path => format!("the job: {path}: {message}"),
            };
            Diagnostic::new(Code::InvalidValue, message)
                .help("mocap run --schema prints what a job may hold")
                .into()
        })
    }

    /// The job as indented JSON, without what has its default.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default()
    }

    /// Reads the inputs, and writes the output: whole, or not at all.
    ///
    /// # Errors
    /// Those of its parts, with the file: of [`Importer::import`](mocap_io::Importer::import), of the steps, of
    /// [`Retargeting`](mocap_retarget::retargeting::Retargeting), of [`Exporter::export`](mocap_io::Exporter::export).
    /// [`Code::InvalidValue`] for standard output and for a folder of outputs, which are for programs:
    /// [`Maker`] makes what they write.
    pub fn run(&self) -> Result<JobReport> {
        self.run_with(&[])
    }

    /// As [`run`](Self::run), where the files of `given` are not on the disk, such as standard input, whose name is
    /// `-`.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_with(&self, given: &[MemoryFile<'_>]) -> Result<JobReport> {
        if let Some(surveying) = &self.survey {
            return self.run_survey(surveying, Files { given, has_disk: true });
        }
        if let (Some(graphing), None) = (&self.graph, &self.walk) {
            return self.run_graph(graphing, Files { given, has_disk: true });
        }
        let output = &self.write.output;
        self.check_one_file()?;
        let policy = self.policy();
        policy.check_inputs(output)?;
        let mut report = JobReport::default();
        let maker = Maker::new(self, given, &mut |said| report.hear(said))?;
        maker.check(&policy, output)?;
        let made = maker.make(&self.source.inputs, output, &mut |said| report.hear(said))?;
        let Made {
            mut written,
            scene,
            clips,
            left_out,
            walk,
            ..
        } = made;
        report.walk = walk;
        let set = written.output_set(output)?;
        set.save(&policy)?;
        set.remove_unfinished();
        report.describe(&mut written, output);
        report.problem = maker.problem(&clips);
        report.leave_out(left_out);
        report.clips = clips;
        if self.write.verify {
            let verification = self.verify(scene, output)?;
            if !verification.is_within(self.write.smaller.tolerance()) {
                report.problem = Some("the output is farther from its source than allowed".to_owned());
            }
            report.verification = Some(verification);
        }
        Ok(report)
    }

    /// Compares an output with the input of the job, from which `scene` was made.
    ///
    /// # Errors
    /// As [`Verifier::files`].
    pub fn verify(&self, scene: Option<Scene>, output: &Path) -> Result<Verification> {
        let Some(input) = self.source.inputs.first() else {
            return Err(Diagnostic::new(Code::InvalidValue, "the job names no input").into());
        };
        let verifier = Verifier::new()
            .importer(self.read.importer())
            .space(self.source.space.clone())
            .allowing(self.write.smaller.tolerance())
            .second_motions(self.source.with.clone());
        // A BVH file does not say how it was made.
        let verifier = match &scene {
            Some(scene) => verifier.provenance(Provenance::of(scene)),
            None => verifier,
        };
        // The keys of a long take are better gone before the file is read back.
        drop(scene);
        verifier.files(input, output)
    }

    /// Which files the output may replace: no input, and no other file that the job reads.
    pub fn policy(&self) -> ReplacePolicy {
        let inputs = self.source.inputs.iter().chain(&self.source.with).map(AsRef::as_ref);
        let target = self.target.as_ref().map(JobTarget::file);
        let body = self.graph.iter().filter_map(|graphing| graphing.on.as_deref());
        let inputs = inputs.chain(target).chain(self.read.files()).chain(body);
        ReplacePolicy::new(inputs).force(self.write.force)
    }

    /// Refuses what is not one file on a disk.
    fn check_one_file(&self) -> Result<()> {
        let many = self.source.inputs.iter().find(|input| input.is_dir());
        let (message, help) = match many {
            _ if self.write.is_stream() => (
                "the job writes to standard output, which belongs to the program".to_owned(),
                "name a file in write.output, or do the job with mocap run",
            ),
            Some(folder) if !self.write.is_folder() => (
                format!(
                    "{} is a folder, and its motions need a folder of outputs",
                    folder.display()
                ),
                "name a folder in write.output, which ends in /, and do the job with mocap run",
            ),
            _ if self.write.is_folder() => (
                "the job makes an output of each of many motions in a folder".to_owned(),
                "do it with mocap run, or take a Maker, or name a file in write.output",
            ),
            _ => return Ok(()),
        };
        refuse(&message, help)
    }

    /// Refuses a folder among the inputs of a survey or a graph.
    fn refuse_folders(&self) -> Result<()> {
        match self.source.inputs.iter().find(|input| input.is_dir()) {
            Some(folder) => refuse(
                &format!("{} is a folder, and the job takes files", folder.display()),
                "name its files, or do the job with mocap run",
            ),
            None => Ok(()),
        }
    }

    /// Whether the job has steps, another body, more of its source than `source`, or options of written motions.
    fn changes_motion(&self, source: &Sources) -> bool {
        let writing = Writing {
            output: self.write.output.clone(),
            to: self.write.to.clone(),
            force: self.write.force,
            ..Writing::default()
        };
        !self.steps.is_empty() || self.target.is_some() || self.write != writing || self.source != *source
    }

    /// Makes the output of files that are in memory, under the names that the job has for them. Nothing is read from a
    /// disk, and nothing is written there.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::MemoryFile;
    /// use mocap::job::Job;
    ///
    /// let bytes = std::fs::read("fixtures/real/cmu_short.bvh").unwrap();
    /// let job = Job::from_json(r#"{"source": {"inputs": ["a.bvh"]}, "write": {"output": "a.glb"}}"#)?;
    /// let (written, report) = job.run_in_memory(&[MemoryFile { name: "a.bvh", bytes: &bytes }])?;
    /// assert!(written.into_bytes()?.starts_with(b"glTF"));
    /// assert_eq!(report.files[0].name, "a.glb");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`run`](Self::run); [`Code::MissingFile`] where the job names a file that is not given;
    /// [`Code::InvalidValue`] for `verify`, which compares files.
    pub fn run_in_memory(&self, files: &[MemoryFile<'_>]) -> Result<(Written, JobReport)> {
        if self.write.verify {
            let message = "the job: write.verify compares files on a disk, and these are in memory";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        self.make_of(Files {
            given: files,
            has_disk: false,
        })
    }

    /// Makes the output as [`run`](Self::run) does, and writes nothing. The files of `given` are not read from the
    /// disk, such as standard input, whose name is `-`.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn make(&self, given: &[MemoryFile<'_>]) -> Result<(Written, JobReport)> {
        self.make_of(Files { given, has_disk: true })
    }

    fn make_of(&self, files: Files<'_>) -> Result<(Written, JobReport)> {
        if let Some(surveying) = &self.survey {
            let (made, report) = self.survey(surveying, files)?;
            return Ok((written(made), report));
        }
        if let (Some(graphing), None) = (&self.graph, &self.walk) {
            let (made, report) = self.graph_of(graphing, files)?;
            return Ok((written(made), report));
        }
        let (mut report, output) = (JobReport::default(), &self.write.output);
        let maker = Maker::of(self, files, &mut |said| report.hear(said))?;
        let made = maker.make(&self.source.inputs, output, &mut |said| report.hear(said))?;
        let mut written = made.written;
        report.describe(&mut written, output);
        report.problem = maker.problem(&made.clips);
        report.leave_out(made.left_out);
        report.clips = made.clips;
        report.walk = made.walk;
        Ok((written, report))
    }
}

/// Files that are made, in memory.
fn written(made: Vec<(PathBuf, Vec<u8>)>) -> Written {
    let files = made
        .into_iter()
        .map(|(path, bytes)| WrittenFile::new(file_name(&path), bytes));
    Written::of(files.collect())
}

/// A step is a text, or an object with its name and its options.
#[cfg(feature = "schema")]
fn steps_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    let object = |step: &mocap_edit::StepInfo| {
        serde_json::json!({
            "type": "object",
            "description": step.to_string(),
            "properties": {"step": {"const": step.name}},
            "required": ["step"],
        })
    };
    let text = serde_json::json!({"type": "string", "description": "a step as text: NAME:key=value,..."});
    let all: Vec<_> = std::iter::once(text).chain(EditStep::ALL.iter().map(object)).collect();
    schemars::json_schema!({"type": "array", "items": {"anyOf": all}})
}

/// The name of a file, without its folder.
fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// An error of a job that asks for what it cannot have.
fn refuse<T>(message: &str, help: &str) -> Result<T> {
    Err(Diagnostic::new(Code::InvalidValue, message).help(help).into())
}

/// Whether a value can be left out of a job file.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
