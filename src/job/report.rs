//! The report of a finished job.

use std::fmt;
use std::path::{Path, PathBuf};

use mocap_corpus::survey::report::ClipRow;
use mocap_edit::report::{EditReport, WalkReport};
use mocap_formats::Export;
use mocap_formats::report::{Deviation, NodeRename};
use mocap_retarget::report::ClipReport;
use mocap_scene::error::Diagnostic;
use mocap_scene::scene::report::DataLoss;
use serde::Serialize;

use super::{GraphReport, Notice};
use crate::verify::report::Verification;

/// The report of a finished job.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::Job;
///
/// let folder = tempfile::tempdir().unwrap();
/// let output = folder.path().join("walk.glb");
/// let job = serde_json::json!({
///     "source": {"inputs": ["fixtures/real/cmu_12_01_walk.bvh"]},
///     "steps": [{"step": "smooth", "cut-off": 8}],
///     "write": {"output": output},
/// });
/// let report = Job::from_json(&job.to_string())?.run()?;
/// assert_eq!(report.steps.len(), 1);
/// assert!(report.files[0].bytes > 100_000);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct JobReport {
    /// The files of the output. The last file has the name that the job gives to its output.
    pub files: Vec<OutputFile>,
    /// Decisions, choices and dropped parts, one sentence each.
    pub notes: Vec<String>,
    /// The nodes that were renamed in the output.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub renamed: Vec<NodeRename>,
    /// Possible problems of the inputs, or of reading the output.
    pub warnings: Vec<Diagnostic>,
    /// Data of the inputs that the output lacks. Each loss is also a warning.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub losses: Vec<DataLoss>,
    /// The changes of each step.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<EditReport>,
    /// The retargeting quality of each motion.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub clips: Vec<ClipReport>,
    /// The deviation of the output from the motion, if keys or bits were dropped.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<Deviation>,
    /// The deviation of the output from its source, if the job requests a comparison.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verification: Option<Verification>,
    /// The rows of a survey.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub survey: Vec<ClipRow>,
    /// The size of the motion graph.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub graph: Option<GraphReport>,
    /// The walk over a motion graph.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub walk: Option<WalkReport>,
    /// A result that is worse than the job allows. The files are written nevertheless.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// A file of an output.
///
/// The [module](crate) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OutputFile {
    /// The name of the file, without the folder; empty for a stream.
    pub name: String,
    /// The size of the file.
    pub bytes: usize,
}

impl fmt::Display for JobReport {
    /// Prints decisions and changes, one line each, without files and warnings.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = self.notes.clone();
        lines.extend(self.steps.iter().map(ToString::to_string));
        lines.extend(self.clips.iter().map(|clip| {
            let (name, verdict, mean) = (clip.name(), clip.verdict().as_str(), clip.mean_degrees());
            format!("{name}: {verdict}: mean limb error {mean:.2} degrees")
        }));
        lines.extend(self.walk.as_ref().map(ToString::to_string));
        lines.extend(self.verification.as_ref().map(ToString::to_string));
        f.write_str(&lines.join("\n"))
    }
}

impl JobReport {
    /// Adds a notice to the report.
    pub(super) fn hear(&mut self, said: Notice<'_>) {
        match said {
            Notice::Warnings(_, warnings) => self.warnings.extend(warnings.iter().cloned()),
            Notice::Note(note) => self.notes.push(note.to_owned()),
            Notice::Step(step) => self.steps.push(step.clone()),
        }
    }

    /// Reports the motions that were skipped.
    pub(super) fn leave_out(&mut self, motions: Vec<(PathBuf, Diagnostic)>) {
        if let Some((first, why)) = motions.first() {
            let (count, file, message) = (motions.len(), first.display(), &why.message);
            self.problem = Some(format!("skipped motions: {count}; the first is {file}: {message}"));
        }
        self.warnings.extend(motions.into_iter().map(|(_, why)| why));
    }

    /// Adds the notices of an output to the report.
    pub(super) fn describe(&mut self, written: &mut Export, output: &Path) {
        let name = output.file_name().unwrap_or_default().to_string_lossy();
        let last = written.files.len().saturating_sub(1);
        let named = written.files.iter().enumerate();
        self.files = named
            .map(|(index, file)| OutputFile {
                name: if index == last {
                    name.to_string()
                } else {
                    file.name().to_owned()
                },
                bytes: file.len(),
            })
            .collect();
        self.notes.append(&mut written.notes);
        let by_format = written.renamed.iter().filter(|renamed| !renamed.is_asked_for);
        self.notes.extend(by_format.map(ToString::to_string));
        self.renamed.append(&mut written.renamed);
        self.warnings.append(&mut written.warnings);
        self.losses.append(&mut written.losses);
        self.error = written.error.take();
    }
}
