//! Runs a motion job.

use std::path::{Path, PathBuf};

use mocap_formats::Export;
use mocap_io::import::{Importer, MemoryFile};
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::ReplacePolicy;
use mocap_scene::scene::Scene;

use super::files::Files;
use super::{JobOutput, JobReport, Maker, MotionJob, OutputOptions, refuse};

impl MotionJob {
    /// Reads the inputs, and writes the output: whole, or not at all.
    ///
    /// # Errors
    /// As [`Job::run`](super::Job::run).
    pub fn run(&self) -> Result<JobReport> {
        self.run_with(&[])
    }

    /// As [`run`](Self::run), but files of `given` are in memory instead of on the disk. In `given`, the name `-` is
    /// standard input.
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
        let scene = save(&mut report, &maker, made, output, &policy)?;
        if self.verify {
            let verification = self.verify_output(scene, output)?;
            if !verification.is_within(self.write.smaller.tolerance()) {
                report.problem = Some("the output deviates from its source by more than allowed".to_owned());
            }
            report.verification = Some(verification);
        }
        Ok(report)
    }

    /// Makes the output as [`run`](Self::run) does, and writes nothing. Files of `given` are in memory instead of on
    /// the disk. In `given`, the name `-` is standard input.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn make(&self, given: &[MemoryFile<'_>]) -> Result<(Export, JobReport)> {
        self.make_of(Files { given, has_disk: true })
    }

    /// As [`Job::run_in_memory`](super::Job::run_in_memory).
    ///
    /// # Errors
    /// As [`Job::run_in_memory`](super::Job::run_in_memory).
    pub fn run_in_memory(&self, files: &[MemoryFile<'_>]) -> Result<(Export, JobReport)> {
        self.make_of(Files {
            given: files,
            has_disk: false,
        })
    }

    pub(super) fn make_of(&self, files: Files<'_>) -> Result<(Export, JobReport)> {
        if self.verify && !files.has_disk {
            let message = "the job: verify compares files on a disk, but these are in memory";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let (mut report, output) = (JobReport::default(), &self.write.output);
        let maker = Maker::of(self, files, &mut |said| report.hear(said))?;
        let mut made = maker.make(&self.source.inputs, output, &mut |said| report.hear(said))?;
        describe(&mut report, &maker, &mut made, output);
        Ok((made.written, report))
    }
}

/// Writes the outputs, and adds their notices to the report. Returns the written motion.
pub(super) fn save(
    report: &mut JobReport,
    maker: &Maker<'_>,
    mut made: JobOutput,
    output: &Path,
    policy: &ReplacePolicy,
) -> Result<Option<Scene>> {
    let set = made.written.output_set(output)?;
    set.save(policy)?;
    set.remove_unfinished();
    describe(report, maker, &mut made, output);
    Ok(made.scene)
}

/// Adds the notices of the outputs to the report.
pub(super) fn describe(report: &mut JobReport, maker: &Maker<'_>, made: &mut JobOutput, output: &Path) {
    report.describe(&mut made.written, output);
    report.problem = maker.problem(&made.clips);
    report.leave_out(std::mem::take(&mut made.left_out));
    report.clips = std::mem::take(&mut made.clips);
}

/// Refuses anything other than one file on a disk.
pub(super) fn check_one_file(inputs: &[PathBuf], write: &OutputOptions) -> Result<()> {
    let many = inputs.iter().find(|input| Importer::is_of_many(input));
    let (message, help) = match many {
        _ if write.is_stream() => (
            "the job writes to standard output, which only mocap run supports".to_owned(),
            "name a file in write.output, or run the job with mocap run",
        ),
        Some(folder) if !write.is_folder() => (
            format!("{} is a folder: its motions need an output folder", folder.display()),
            "name a folder in write.output that ends in /, and run the job with mocap run",
        ),
        _ if write.is_folder() => (
            "the job writes one file for each of many motions in a folder".to_owned(),
            "run it with mocap run, or use a Maker, or name a file in write.output",
        ),
        _ => return Ok(()),
    };
    refuse(&message, help)
}
