//! Jobs. A job is one piece of work: command lines, calls from Python, JavaScript and C, and job files all become jobs.
//!
//! A [`Job`] is a document. Its JSON Schema, [`Job::schema`], lists the options of its four kinds:
//!
//! - A motion job reads motions, selects frames, changes them by [steps](mocap_edit::EditStep), retargets them, and
//!   writes the result.
//! - A survey job writes a table with a row for each clip.
//! - A graph job writes the motion graph of its clips.
//! - A walk job changes, retargets and writes a walk over a motion graph. A walk is a path from clip to clip: its
//!   motion need not be walking.
//!
//! `mocap run job.json` runs a job, and `--print-job` prints the job of a command line.
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
//! assert!(matches!(job, Job::Motion(job) if job.steps.len() == 2));
//! # Ok::<(), mocap::Error>(())
//! ```

// Tests may unwrap and print, but the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

mod array_layout;
pub mod arrays;
mod file_graph;
mod files;
mod form;
mod graph;
mod graph_job;
mod input;
#[doc(hidden)]
pub mod internals;
mod maker;
mod meshes;
mod motion_job;
mod names;
mod notice;
mod output;
mod record;
pub mod report;
mod robot_format;
mod run;
mod size;
mod source;
mod survey;
mod survey_job;
mod target;
mod text;
pub mod verify;
mod walk;
mod walk_job;
mod weights;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::ZlibDecoder;
use mocap_formats::Export;
use mocap_io::import::MemoryFile;
use mocap_scene::error::{Code, Diagnostic, Result, nearest, pointer, wrong_value};
use mocap_scene::files::ReplacePolicy;
use mocap_scene::report::indented_json;
use serde::Serialize;
use serde::de::{DeserializeOwned, IgnoredAny};

#[doc(hidden)]
pub use self::file_graph::FileGraph;
use self::files::Files;
#[doc(hidden)]
pub use self::graph::{GraphJobOptions, GraphReport};
#[doc(hidden)]
pub use self::graph_job::{GraphJob, GraphSources};
#[doc(hidden)]
pub use self::input::InputOptions;
#[doc(hidden)]
pub use self::maker::{JobOutput, Maker, clips_of};
#[doc(hidden)]
pub use self::motion_job::MotionJob;
#[doc(hidden)]
pub use self::names::JointNames;
#[doc(hidden)]
pub use self::notice::Notice;
#[doc(hidden)]
pub use self::output::{
    BvhOutputOptions, FbxOutputOptions, FileOutputOptions, MeshStyle, OutBoneAxis, OutSpace, OutUp, OutputOptions,
};
#[doc(hidden)]
pub use self::record::remember_outputs;
use self::report::JobReport;
#[doc(hidden)]
pub use self::robot_format::RobotFormat;
#[doc(hidden)]
pub use self::size::SizeOptions;
#[doc(hidden)]
pub use self::source::{BoneMap, SourceFrames, SourceMap, SourceSpace, SourceUp, Sources};
#[doc(hidden)]
pub use self::survey::SurveyOptions;
#[doc(hidden)]
pub use self::survey_job::{SurveyJob, SurveySources};
#[doc(hidden)]
pub use self::target::{CharacterTarget, Feet, Hands, JobTarget, RequiredVerdict, RobotTarget, SkeletonTarget};
#[doc(hidden)]
pub use self::text::{Angle, Length, UnitChoice, UpChoice};
#[doc(hidden)]
pub use self::walk::WalkOptions;
#[doc(hidden)]
pub use self::walk_job::{WalkJob, WalkSources};
#[doc(hidden)]
pub use self::weights::JobWeights;

/// One piece of work. Each kind of job has only the options that affect it.
///
/// In JSON the keys determine the kind. An object with `walk` is a walk job, with `graph` a graph job, with `survey` a
/// survey job. Every other object is a motion job.
///
/// The [module](self) has an example.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Job {
    /// An output of motions.
    Motion(MotionJob),
    /// A table with a row for each clip.
    Survey(SurveyJob),
    /// A motion graph.
    Graph(GraphJob),
    /// A walk over a motion graph.
    Walk(WalkJob),
}

impl Job {
    /// The JSON Schema of a job, as text.
    pub fn schema() -> String {
        // The build compresses the schema to a sixth of its size.
        let packed = include_bytes!(concat!(env!("OUT_DIR"), "/job.schema.json.zlib"));
        let mut text = String::new();
        let read = ZlibDecoder::new(&packed[..]).read_to_string(&mut text);
        read.expect("the build compressed a file of UTF-8");
        text
    }

    /// The job of a JSON text.
    ///
    /// ```
    /// use mocap::job::Job;
    ///
    /// let error = Job::from_json(r#"{"write": {"outptu": "a.glb"}}"#).unwrap_err();
    /// assert!(error.to_string().contains("write.outptu: a motion job has no outptu in write"));
    /// let error = Job::from_json(r#"{"survey": {}, "steps": ["mirror"]}"#).unwrap_err();
    /// assert!(error.to_string().contains("the job: steps: a survey job has no steps"));
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidValue`], with the path of the value, if the text is not a job.
    pub fn from_json(text: &str) -> Result<Self> {
        // serde would read an empty list as an empty job.
        if !text.trim_start().starts_with('{') {
            let message = "the job: it must be a JSON object";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let keys: BTreeMap<String, IgnoredAny> = parsed(text, &Wording::of_job("a job has"))?;
        // A walk job may also have `graph`, so `walk` is looked for first.
        let kind = ["walk", "graph", "survey"]
            .into_iter()
            .find(|key| keys.contains_key(*key));
        Ok(match kind {
            Some("walk") => Self::Walk(parsed(text, &Wording::of_job("a walk job has"))?),
            Some("graph") => Self::Graph(parsed(text, &Wording::of_job("a graph job has"))?),
            Some("survey") => Self::Survey(parsed(text, &Wording::of_job("a survey job has"))?),
            _ => Self::Motion(parsed(text, &Wording::of_job("a motion job has"))?),
        })
    }

    /// The job as indented JSON, without default values.
    pub fn to_json(&self) -> String {
        indented_json(self).unwrap_or_default()
    }

    /// Reads the inputs, and writes the output. A failed job leaves no partial file.
    ///
    /// # Errors
    /// The errors of [`Importer::import`](mocap_io::Importer::import), of the steps, of
    /// [`Retargeter`](mocap_retarget::Retargeter) and of [`Exporter::export`](mocap_io::Exporter::export), with the
    /// file. [`Code::InvalidValue`] if the output is standard output or a folder: use [`Maker`] for these.
    pub fn run(&self) -> Result<JobReport> {
        self.run_with(&[])
    }

    /// As [`run`](Self::run), but files of `given` are in memory instead of on the disk. In `given`, the name `-` is
    /// standard input.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_with(&self, given: &[MemoryFile<'_>]) -> Result<JobReport> {
        let files = Files { given, has_disk: true };
        match self {
            Self::Motion(job) => job.run_with(given),
            Self::Survey(job) => job.run_of(files),
            Self::Graph(job) => job.run_of(files),
            Self::Walk(job) => job.run_of(files),
        }
    }

    /// Makes the output from files in memory. The job refers to the files by their names. Nothing is read from or
    /// written to a disk.
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
    /// As [`run`](Self::run); [`Code::MissingFile`] if the job names a file that is not in `files`;
    /// [`Code::InvalidValue`] for `verify`, because `verify` compares files on a disk.
    pub fn run_in_memory(&self, files: &[MemoryFile<'_>]) -> Result<(Export, JobReport)> {
        self.make_of(Files {
            given: files,
            has_disk: false,
        })
    }

    /// Makes the output as [`run`](Self::run) does, and writes nothing. Files of `given` are in memory instead of on
    /// the disk. In `given`, the name `-` is standard input.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn make(&self, given: &[MemoryFile<'_>]) -> Result<(Export, JobReport)> {
        self.make_of(Files { given, has_disk: true })
    }

    fn make_of(&self, files: Files<'_>) -> Result<(Export, JobReport)> {
        match self {
            Self::Motion(job) => job.make_of(files),
            Self::Survey(job) => job.make_of(files),
            Self::Graph(job) => job.make_of(files),
            Self::Walk(job) => job.make_of(files),
        }
    }

    /// The options for reading the inputs.
    pub fn read(&self) -> &InputOptions {
        match self {
            Self::Motion(job) => &job.read,
            Self::Survey(job) => &job.read,
            Self::Graph(job) => &job.read,
            Self::Walk(job) => &job.read,
        }
    }

    /// The inputs, then the second motions of steps.
    pub fn motions(&self) -> impl Iterator<Item = &PathBuf> {
        let (inputs, with): (&[PathBuf], &[PathBuf]) = match self {
            Self::Motion(job) => (&job.source.inputs, &job.source.with),
            Self::Survey(job) => (&job.source.inputs, &[]),
            Self::Graph(job) => (&job.source.inputs, &[]),
            Self::Walk(job) => (&job.source.inputs, &job.source.with),
        };
        inputs.iter().chain(with)
    }

    /// The output; empty if nothing is written.
    pub fn output(&self) -> &Path {
        match self {
            Self::Motion(job) => &job.write.output,
            Self::Survey(job) => &job.write.output,
            Self::Graph(job) => &job.write.output,
            Self::Walk(job) => &job.write.output,
        }
    }

    /// The options `to` (the format of the output) and `force` of the job, so that a caller can change them.
    #[doc(hidden)]
    pub fn to_and_force(&mut self) -> (&mut Option<String>, &mut bool) {
        match self {
            Self::Motion(MotionJob { write, .. }) | Self::Walk(WalkJob { write, .. }) => {
                (&mut write.to, &mut write.force)
            }
            Self::Survey(SurveyJob { write, .. }) | Self::Graph(GraphJob { write, .. }) => {
                (&mut write.to, &mut write.force)
            }
        }
    }

    /// The policy for replacing files: outputs never replace an input or another file that the job reads.
    pub fn policy(&self) -> ReplacePolicy {
        match self {
            Self::Motion(job) => job.policy(),
            Self::Survey(job) => job.policy(),
            Self::Graph(job) => job.policy(),
            Self::Walk(job) => job.policy(),
        }
    }
}

/// The words of errors about a JSON text: the kind of text, its owner, and the place of its documentation.
struct Wording<'a> {
    text: &'a str,
    owner: &'a str,
    help: &'a str,
}

impl<'a> Wording<'a> {
    fn of_job(owner: &'a str) -> Self {
        Self {
            text: "the job",
            owner,
            help: "docs/asking.md tells how to print the schema of jobs, which lists all options",
        }
    }
}

/// Deserializes a JSON text. Errors name the path of the wrong value, and the allowed values.
fn parsed<T: DeserializeOwned>(text: &str, wording: &Wording<'_>) -> Result<T> {
    let Wording {
        text: whole,
        owner,
        help,
    } = wording;
    serde_json::from_str(text).map_err(|error| {
        let (mut path, what) = (dotted(&pointer(text, &error)), error.to_string());
        let (message, near) = match (unknown(&what, "field"), unknown(&what, "variant")) {
            (Some((key, known)), _) => {
                let mut message = format!("{owner} no {key}");
                if !path.is_empty() {
                    message += &format!(" in {path}");
                    path.push('.');
                }
                path += key;
                (
                    format!("{message}; known keys: {known}"),
                    nearest(key, known.split(", ")).map(str::to_owned),
                )
            }
            (None, Some((word, known))) => {
                let message = format!("expected {known}; found {word}");
                (message, nearest(word, known.split(", ")).map(str::to_owned))
            }
            (None, None) if what.starts_with("trailing characters") => {
                ("text follows the JSON object".to_owned(), None)
            }
            (None, None) if error.is_data() => {
                // The path already states the place of a missing field.
                let rest = || {
                    what.rsplit_once(" at line ")
                        .map_or(&*what, |(what, _)| what)
                        .to_owned()
                };
                (wrong_value(&what).unwrap_or_else(rest), None)
            }
            (None, None) => (format!("the text is not JSON: {what}"), None),
        };
        let message = match path.as_str() {
            "" => format!("{whole}: {message}"),
            path => format!("{whole}: {path}: {message}"),
        };
        let help = near.map_or_else(|| (*help).to_owned(), |near| format!("did you mean {near}?"));
        Diagnostic::new(Code::InvalidValue, message).help(help).into()
    })
}

/// Writes a JSON Pointer as a script writes a path: `source.joints[2]`.
fn dotted(pointer: &str) -> String {
    let mut path = String::new();
    for segment in pointer.split('/').skip(1) {
        match segment.parse::<usize>() {
            Ok(index) => path += &format!("[{index}]"),
            Err(_) => {
                if !path.is_empty() {
                    path.push('.');
                }
                path += &segment.replace("~1", "/").replace("~0", "~");
            }
        }
    }
    path
}

/// The unknown word in serde's message, and the known words of this `kind`.
fn unknown<'a>(said: &'a str, kind: &str) -> Option<(&'a str, String)> {
    let (word, known) = said
        .strip_prefix("unknown ")?
        .strip_prefix(kind)?
        .strip_prefix(" `")?
        .split_once("`, expected ")?;
    let known = known.split_once(" at line ").map_or(known, |(known, _)| known);
    let known = known
        .trim_start_matches("one of ")
        .replace(" or ", ", ")
        .replace('`', "");
    Some((word, known))
}

/// Steps in the schema: each step is a string, or an object with its name and its options.
#[cfg(feature = "schema")]
struct Steps;

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Steps {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Steps".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let object = |step: &mocap_edit::StepInfo| {
            serde_json::json!({
                "type": "object",
                "description": step.to_string(),
                "properties": {"step": {"const": step.name}},
                "required": ["step"],
            })
        };
        let text = serde_json::json!({"type": "string", "description": "a step as text: NAME:key=value,..."});
        let steps = mocap_edit::EditStep::ALL.iter().map(object);
        let all: Vec<_> = std::iter::once(text).chain(steps).collect();
        schemars::json_schema!({"type": "array", "items": {"anyOf": all}})
    }
}

/// Refuses a job with a message and a remedy.
fn refuse<T>(message: &str, help: &str) -> Result<T> {
    Err(Diagnostic::new(Code::InvalidValue, message).help(help).into())
}

/// Whether a value can be left out of a job file.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
