//! A job that makes an output of motions.

use std::path::{Path, PathBuf};

use mocap_edit::EditStep;
use mocap_formats::Written;
use mocap_formats::gltf::Provenance;
use mocap_io::import::MemoryFile;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::ReplacePolicy;
use mocap_scene::scene::Scene;
use serde::{Deserialize, Serialize};

use super::files::{Files, policy};
use super::{JobReport, JobTarget, Maker, Reading, Sources, Writing, is_default, refuse};
use crate::verify::{Verification, Verifier};

/// Reads motions, changes them, retargets them, and writes the result.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::MotionJob;
///
/// let folder = tempfile::tempdir().unwrap();
/// let mut job = MotionJob::default();
/// job.source.inputs = vec!["fixtures/real/cmu_short.bvh".into()];
/// job.steps = vec!["mirror".parse()?];
/// job.write.output = folder.path().join("mirrored.glb");
/// assert_eq!(job.run()?.steps.len(), 1);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct MotionJob {
    /// How the inputs are read.
    #[serde(skip_serializing_if = "is_default")]
    pub read: Reading,
    /// The inputs, and what is known of them.
    pub source: Sources,
    /// What changes the motion, in this order. With a step, the first animation of an input is taken.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(with = "super::Steps"))]
    pub steps: Vec<EditStep>,
    /// What the motions are retargeted to. Default: they keep their skeletons.
    #[serde(skip_serializing_if = "is_default")]
    pub target: Option<JobTarget>,
    /// The output.
    pub write: Writing,
    /// Whether the output is compared with its source.
    #[serde(skip_serializing_if = "is_default")]
    pub verify: bool,
}

impl MotionJob {
    /// Reads the inputs, and writes the output: whole, or not at all.
    ///
    /// # Errors
    /// As [`Job::run`](super::Job::run).
    pub fn run(&self) -> Result<JobReport> {
        self.run_with(&[])
    }

    /// As [`run`](Self::run), where the files of `given` are not on the disk, such as standard input, whose name is
    /// `-`.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_with(&self, given: &[MemoryFile<'_>]) -> Result<JobReport> {
        let output = &self.write.output;
        check_one_file(&self.source.inputs, &self.write)?;
        let policy = self.policy();
        policy.check_inputs(output)?;
        let mut report = JobReport::default();
        let maker = Maker::new(self, given, &mut |said| report.hear(said))?;
        maker.check(&policy, output)?;
        let made = maker.make(&self.source.inputs, output, &mut |said| report.hear(said))?;
        let scene = report.save(&maker, made, output, &policy)?;
        if self.verify {
            let verification = self.verify_output(scene, output)?;
            if !verification.is_within(self.write.smaller.tolerance()) {
                report.problem = Some("the output is farther from its source than allowed".to_owned());
            }
            report.verification = Some(verification);
        }
        Ok(report)
    }

    /// Makes the output as [`run`](Self::run) does, and writes nothing. The files of `given` are not read from the
    /// disk, such as standard input, whose name is `-`.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn make(&self, given: &[MemoryFile<'_>]) -> Result<(Written, JobReport)> {
        self.make_of(Files { given, has_disk: true })
    }

    /// As [`Job::run_in_memory`](super::Job::run_in_memory).
    ///
    /// # Errors
    /// As [`Job::run_in_memory`](super::Job::run_in_memory).
    pub fn run_in_memory(&self, files: &[MemoryFile<'_>]) -> Result<(Written, JobReport)> {
        self.make_of(Files {
            given: files,
            has_disk: false,
        })
    }

    pub(super) fn make_of(&self, files: Files<'_>) -> Result<(Written, JobReport)> {
        if self.verify && !files.has_disk {
            let message = "the job: verify compares files on a disk, and these are in memory";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let (mut report, output) = (JobReport::default(), &self.write.output);
        let maker = Maker::of(self, files, &mut |said| report.hear(said))?;
        let mut made = maker.make(&self.source.inputs, output, &mut |said| report.hear(said))?;
        report.describe(&maker, &mut made, output);
        Ok((made.written, report))
    }

    /// Compares an output with the input of the job, from which `scene` was made.
    ///
    /// # Errors
    /// As [`Verifier::files`].
    pub fn verify_output(&self, scene: Option<Scene>, output: &Path) -> Result<Verification> {
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
        let target = self.target.as_ref().map(JobTarget::file);
        let others = self.source.with.iter().map(AsRef::as_ref).chain(target);
        policy(&self.source.inputs, &self.read, others).force(self.write.force)
    }
}

/// Refuses what is not one file on a disk.
pub(super) fn check_one_file(inputs: &[PathBuf], write: &Writing) -> Result<()> {
    let many = inputs.iter().find(|input| input.is_dir());
    let (message, help) = match many {
        _ if write.is_stream() => (
            "the job writes to standard output, which belongs to the program".to_owned(),
            "name a file in write.output, or do the job with mocap run",
        ),
        Some(folder) if !write.is_folder() => (
            format!(
                "{} is a folder, and its motions need a folder of outputs",
                folder.display()
            ),
            "name a folder in write.output, which ends in /, and do the job with mocap run",
        ),
        _ if write.is_folder() => (
            "the job makes an output of each of many motions in a folder".to_owned(),
            "do it with mocap run, or take a Maker, or name a file in write.output",
        ),
        _ => return Ok(()),
    };
    refuse(&message, help)
}
