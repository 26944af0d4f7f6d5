//! A job with many motions: writes a folder with a manifest.

mod options;
mod skeletons;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use mocap::files::ReplacePolicy;
use mocap::job::{JobOutput, JobTarget, Maker, MotionJob, Notice};
use mocap::retarget::report::ClipReport;
use mocap::scene::{Assumption, Scene, Topic, UpAxis};
use mocap::{Code, Diagnostic};

use self::options::options;
use self::skeletons::{Clips, doubtful_up, is_doubtful_up, skeleton_hash, told_by_others};
use super::robot_reports::Table;
use super::{looks, made, verify};
use crate::args::ArgumentSources;
use crate::batch::folder::{self, FileState, FileTask, verdicts};
use crate::batch::hash::sha256_of;
use crate::batch::inputs::{Input, InputArgs};
use crate::batch::manifest::Record;
use crate::batch::outputs::Output;
use crate::batch::progress::Counts;
use crate::batch::spread::SpreadArgs;
use crate::report::Voice;
use crate::{Failure, report};

/// Runs a job with many motions.
pub(super) fn run(
    job: &MotionJob,
    given: &ArgumentSources,
    inputs: &InputArgs,
    spread: &SpreadArgs,
    resume: bool,
) -> Result<(), Failure> {
    let many = MotionBatch {
        job,
        given,
        inputs,
        spread,
        resume,
        report: None,
    };
    many.run()
}

/// A job with many motions, and the options of the run.
pub(super) struct MotionBatch<'a> {
    pub(super) job: &'a MotionJob,
    pub(super) given: &'a ArgumentSources,
    pub(super) inputs: &'a InputArgs,
    pub(super) spread: &'a SpreadArgs,
    pub(super) resume: bool,
    /// The table of the reports of a robot's motions.
    pub(super) report: Option<Table<'a>>,
}

impl MotionBatch<'_> {
    pub(super) fn run(self) -> Result<(), Failure> {
        let job = self.job;
        // Each file gets one thread, because many files keep all threads busy.
        let maker = made::maker(job, self.given, &mut |said| Voice::Aloud.hear(said))?.threads(1);
        let many = folder::FileBatch {
            paths: &job.source.inputs,
            folder: &job.write.output,
            target: job.target.as_ref().map(JobTarget::file),
            others: &job.source.with,
            inputs: self.inputs,
            spread: self.spread,
            resume: self.resume,
            force: job.write.force,
            is_dry_run: self.given.is_dry_run(),
            options: options(job)?,
        };
        many.run(&mut ClipGroup {
            job,
            extension: extension(job, &maker),
            is_dry_run: self.given.is_dry_run(),
            maker,
            files: BTreeMap::new(),
            looked: OnceLock::new(),
            axes: None,
            report: self.report,
            table: None,
            rows: AtomicUsize::new(0),
            losses: Mutex::default(),
        })
    }
}

/// The extension of the outputs.
fn extension(job: &MotionJob, maker: &Maker<'_>) -> String {
    let own = maker.extension().or(job.write.to.as_deref());
    own.unwrap_or("glb").to_ascii_lowercase()
}

/// The work on the motions of a job. In some clips the figure stands, which determines the up axis. Other clips of the
/// same skeleton get this axis.
struct ClipGroup<'a> {
    job: &'a MotionJob,
    extension: String,
    is_dry_run: bool,
    maker: Maker<'static>,
    /// All files by their relative paths, with the clip if each clip of the file is a separate input.
    files: BTreeMap<String, (PathBuf, Option<usize>)>,
    /// The maker after it has read all files, made on first use. Files with one skeleton share bones and T-pose.
    looked: OnceLock<Maker<'static>>,
    /// The up axes of skeletons, once standing clips have determined them.
    axes: Option<BTreeMap<String, UpAxis>>,
    report: Option<Table<'a>>,
    /// The file for the table of reports.
    table: Option<PathBuf>,
    /// The number of rows in the table.
    rows: AtomicUsize,
    /// For each motion that lost data in this run, the first loss.
    losses: Mutex<BTreeMap<String, String>>,
}

impl FileTask for ClipGroup<'_> {
    fn extension(&self) -> &str {
        &self.extension
    }

    fn clips(&self, file: &Path) -> Vec<(usize, String)> {
        self.maker.separate_clips(file)
    }

    fn inputs(&mut self, inputs: &[Input]) {
        self.files = inputs
            .iter()
            .map(|input| (input.relative.clone(), (input.path.clone(), input.clip)))
            .collect();
    }

    fn check(&mut self, policy: &ReplacePolicy) -> Result<(), Failure> {
        self.table = self.report.as_ref().map(|table| table.check(policy)).transpose()?;
        Ok(())
    }

    fn make(&self, input: &Input, output: &Output<'_>, record: &mut Record) -> Result<FileState, String> {
        let in_words = |error: mocap::Error| made::refused(error).into_words();
        output.check_ahead().map_err(in_words)?;
        let mut steps = Vec::new();
        // The record of a plain conversion has the guessed unit and up axis in a separate field.
        let keeps_notes = self.job.target.is_some() || !self.job.steps.is_empty();
        let (mut warnings, mut heard) = (Vec::new(), Vec::new());
        let mut hear = |said: Notice<'_>| match said {
            Notice::Step(step) => steps.push(step.clone()),
            Notice::Note(_) if !keeps_notes => {}
            Notice::Warnings(path, found) => {
                heard.extend(found.iter().cloned());
                Voice::Kept(&mut warnings).hear(Notice::Warnings(path, found));
            }
            said => Voice::Kept(&mut warnings).hear(said),
        };
        let made = self.motion(input, output, record, &mut hear);
        let Some(made) = made.map_err(in_words)? else {
            return Ok(FileState::Waits);
        };
        record.warnings = warnings;
        self.note_loss(record, heard.iter().chain(&made.written.warnings));
        record.edit = (!steps.is_empty()).then(|| raw(&steps)).flatten();
        self.save(input, made, output, record, keeps_notes)
    }

    fn is_complete(&self, former: &Record) -> bool {
        let told = former
            .skeleton
            .as_ref()
            .and_then(|skeleton| self.axes.as_ref()?.get(skeleton));
        let is_up_as_told = told.is_none_or(|up| doubtful_up(former).is_none_or(|guess| guess.choice == up.as_str()));
        is_up_as_told
            && match &self.job.target {
                Some(target) => reports_of(former, target).is_some(),
                None => self.job.steps.is_empty() || former.edit.is_some(),
            }
    }

    fn is_unverified(&self, former: &Record) -> bool {
        self.job.verify && !self.is_dry_run && !former.verified
    }

    fn verify(&self, input: &Input, output: &Output<'_>, record: &mut Record) -> Result<(), String> {
        // If the format does not store the provenance, make the motion again to know the provenance.
        let states_origin = self.maker.format().is_some_and(|row| row.states_origin);
        let scene = match states_origin {
            true => None,
            false => {
                let made = self.motion(input, output, &mut record.clone(), &mut |_| {});
                made.map_err(|error| made::refused(error).into_words())?
                    .and_then(|made| made.scene)
            }
        };
        let verified = self.compare(input, scene, &output.path);
        record.verified = verified.is_ok();
        verified
    }

    fn shared_figure(&self, file: &Path) -> Option<String> {
        Some(sha256_of(self.looked().shared_figure(file)?.as_bytes()))
    }

    fn waits(&self, former: &Record) -> bool {
        self.axes.is_none() && doubtful_up(former).is_some()
    }

    fn learn(&mut self, others: &[&Record]) {
        self.axes = Some(Clips::of(others).axes());
    }

    fn summary(&self, records: &[&Record]) -> Vec<String> {
        let lost = self.lost();
        let what = match &self.job.target {
            None => {
                let units = Clips::of(records).units(self.maker.keeps_units());
                return units.into_iter().chain(lost).collect();
            }
            Some(JobTarget::Robot(_)) => "motions on the robot",
            Some(_) => "clips on the character",
        };
        let found = self.reports(records);
        let mut lines = Vec::from_iter(verdicts(what, found.iter().map(ClipReport::verdict)));
        lines.extend(records.iter().flat_map(|record| self.doubts(record)));
        lines.extend(lost);
        lines
    }

    /// Writes the table of the reports when it has grown by an eighth, so that a killed run leaves a table. Each write
    /// replaces the whole table, because Parquet ends with its index.
    fn keep(&self, records: &BTreeMap<String, Record>) {
        let rows = self.rows.load(Ordering::Relaxed);
        let (Some(table), Some(path), false) = (&self.report, &self.table, self.is_dry_run) else {
            return;
        };
        if records.len() > rows + rows / 8 && table.write(path, records.values()).is_ok() {
            // If this write fails, the last write reports the error.
            self.rows.store(records.len(), Ordering::Relaxed);
        }
    }

    fn finish(&self, records: &[&Record], counts: &Counts) -> Result<(), Failure> {
        if let (Some(table), Some(path)) = (&self.report, &self.table) {
            table.write(path, records.iter().copied())?;
        }
        counts.verdict()?;
        let found = self.reports(records);
        let is_worse = |report: &&ClipReport| self.maker.problem(std::slice::from_ref(report)).is_some();
        let worse = found.iter().filter(is_worse).count();
        if worse == 0 {
            return Ok(());
        }
        let what = match &self.job.target {
            Some(JobTarget::Robot(_)) => "motions are worse than --require allows",
            _ => "clips have larger errors than --max-angle allows",
        };
        report::complain(&format!("{worse} of {} {what}", found.len()));
        Err(Failure::Told)
    }
}

impl ClipGroup<'_> {
    /// Notes the first loss of a motion, if it lost data.
    fn note_loss<'a>(&self, record: &Record, mut warnings: impl Iterator<Item = &'a Diagnostic>) {
        if let Some(loss) = warnings.find(|warning| warning.code == Code::NotCarriedOver) {
            let mut losses = self.losses.lock().unwrap_or_else(PoisonError::into_inner);
            losses.insert(record.input.clone(), loss.message.clone());
        }
    }

    /// A line about the lost data of all motions.
    fn lost(&self) -> Option<String> {
        let losses = self.losses.lock().unwrap_or_else(PoisonError::into_inner);
        let (file, loss) = losses.iter().next()?;
        let files = if losses.len() == 1 { "file" } else { "files" };
        Some(format!(
            "data of {} {files} is not in the outputs, such as {file}: {loss}; the manifest lists all lost data",
            losses.len()
        ))
    }

    /// The results of a motion that are not good, each with the command that shows the motion.
    fn doubts(&self, record: &Record) -> Vec<String> {
        let target = self.job.target.as_ref();
        let found =
            target.and_then(|target| Some((target, reports_of(record, target)?, self.files.get(&record.input)?)));
        let Some((target, reports, (input, clip))) = found else {
            return Vec::new();
        };
        let output = record.output.as_ref().filter(|_| !self.is_dry_run);
        let output = output.map(|output| self.job.write.output.join(output));
        looks::of_motion(
            &reports,
            (input, *clip),
            output.as_deref(),
            (target, self.job.read.body.as_deref()),
        )
    }

    fn looked(&self) -> &Maker<'static> {
        self.looked.get_or_init(|| {
            let mut files: Vec<PathBuf> = self.files.values().map(|(path, _)| path.clone()).collect();
            // The clips of a file are successive inputs.
            files.dedup();
            self.maker.clone().look_at(&files)
        })
    }

    /// The outputs of a motion; `None` while it waits for other motions to determine its up axis.
    fn motion(
        &self,
        input: &Input,
        output: &Output<'_>,
        record: &mut Record,
        hear: &mut dyn FnMut(Notice<'_>),
    ) -> mocap::Result<Option<JobOutput>> {
        let file = input.path.as_path();
        let mut scene = match input.clip {
            Some(clip) => self.maker.clone().clip(clip).import(file, hear)?,
            None => self.maker.import(file, hear)?,
        };
        let skeleton = skeleton_hash(&scene);
        let is_open = scene.metadata.up.is_none() && self.job.source.space.up().is_none();
        let of_others = self.axes.as_ref().and_then(|axes| axes.get(&skeleton)).copied();
        let told = of_others.filter(|_| is_open).map(|up| (up, told_by_others(up)));
        let mut maker = self.looked();
        let with_up;
        if let Some((up, told)) = &told {
            scene.metadata.assumptions.push(told.clone());
            with_up = maker.clone().up(*up);
            maker = &with_up;
        }
        let source = maker.prepare(scene, file, hear)?;
        let is_space = |guess: &&Assumption| matches!(guess.topic, Topic::Unit | Topic::Up);
        let mut guesses = Vec::from_iter(source.assumptions.iter().filter(is_space).cloned());
        if self.axes.is_none() && guesses.iter().any(is_doubtful_up) {
            return Ok(None);
        }
        // The conversion of a retargeted motion gets the known axis, so that it does not infer one.
        if let Some((_, told)) = told.filter(|_| self.job.target.is_some()) {
            hear(Notice::Note(&told.to_string()));
            guesses.push(told);
        }
        (record.skeleton, record.guesses) = (Some(skeleton), guesses);
        maker.make_of(source, file, &output.path, hear).map(Some)
    }

    /// Writes an output, and compares it with its source if the job requests it.
    fn save(
        &self,
        input: &Input,
        mut made: JobOutput,
        output: &Output<'_>,
        record: &mut Record,
        keeps_notes: bool,
    ) -> Result<FileState, String> {
        let files = match self.is_dry_run {
            true => output.check(&made.written).map(|()| Vec::new()),
            false => output.save(&made.written),
        };
        record.files = files.map_err(|error| error.to_string())?;
        let written = &mut made.written;
        // Free the bytes of a long take before the next step.
        written.files.clear();
        record.max_error = written.error.as_ref().map(|error| error.max_error);
        match keeps_notes {
            true => made::tell(written, &output.path, &mut Voice::Kept(&mut record.warnings)),
            false => Voice::Kept(&mut record.warnings).warnings(&output.path, &written.warnings),
        }
        match &self.job.target {
            Some(JobTarget::Robot(_)) => record.robot = made.clips.first().and_then(raw),
            Some(_) => record.retarget = raw(&made.clips),
            None => {}
        }
        if !self.job.verify || self.is_dry_run {
            return Ok(FileState::Done);
        }
        let verified = self.compare(input, made.scene, &output.path);
        // The output is written, but may be wrong.
        record.output = Some(output.name.to_owned());
        record.verified = verified.is_ok();
        verified.map(|()| FileState::Done)
    }

    /// Compares an output with its source, from which `scene` was made.
    fn compare(&self, input: &Input, scene: Option<Scene>, output: &Path) -> Result<(), String> {
        let mut one = self.job.clone();
        one.source.inputs = vec![input.path.clone()];
        if let Some(clip) = input.clip {
            one.read.clip = mocap::Clips::Index(clip);
        }
        let verification = one.verify_output(scene, output).map_err(|error| error.to_string())?;
        let allowed = self.job.write.smaller.tolerance();
        match verification.is_within(allowed) {
            true => Ok(()),
            false => Err(verify::difference(&verification, allowed)),
        }
    }

    /// The reports of all retargeted motions, including earlier runs.
    fn reports(&self, records: &[&Record]) -> Vec<ClipReport> {
        let Some(target) = &self.job.target else {
            return Vec::new();
        };
        let found = records.iter().filter_map(|record| reports_of(record, target));
        found.flatten().collect()
    }
}

/// The reports of a retargeted motion; `None` if another version with other fields wrote them.
fn reports_of(record: &Record, target: &JobTarget) -> Option<Vec<ClipReport>> {
    match target {
        JobTarget::Robot(_) => Some(vec![ClipReport::Robot(record.robot_report()?)]),
        _ => {
            let reports = serde_json::from_str::<Vec<_>>(record.retarget.as_ref()?.get());
            Some(reports.ok()?.into_iter().map(ClipReport::Body).collect())
        }
    }
}

fn raw(value: &(impl serde::Serialize + ?Sized)) -> Option<Box<serde_json::value::RawValue>> {
    serde_json::value::to_raw_value(value).ok()
}
