//! The driver of all commands that make one output for each of many files, in a folder with a manifest.
//!
//! A command defines its work on one file by [`FileTask`]. This module does everything else: inputs, names of outputs,
//! results of former runs, shards, threads, progress, the manifest, and the summary.

use std::cell::Cell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use mocap::files::{ReplacePolicy, remove_all_unfinished};
use mocap::retarget::report::Verdict;

use super::hash::sha256;
use super::inputs::{self, Input, InputArgs};
use super::manifest::{Manifest, Record};
use super::outputs::{Claims, KnownOutputs, Output, name_outputs};
use super::progress::{Counts, Outcome, Progress};
use super::spread::SpreadArgs;
use super::{PANICKED, for_each, thread_count};
use crate::{Failure, report};

/// The work of a command on each of many files.
pub(crate) trait FileTask: Sync {
    /// The extension of the outputs.
    fn extension(&self) -> &str;

    /// Refuses impossible work before anything is written.
    fn check(&mut self, _: &ReplacePolicy) -> Result<(), Failure> {
        Ok(())
    }

    /// The clips of a file that each get an output, with their numbers and names. With fewer than two, the file gets
    /// one output.
    fn clips(&self, _: &Path) -> Vec<(usize, String)> {
        Vec::new()
    }

    /// Receives all files, including the files of other shards.
    fn inputs(&mut self, _: &[Input]) {}

    /// Makes the output of a file without printing. Notices go to `record`.
    fn make(&self, input: &Input, output: &Output<'_>, record: &mut Record) -> Result<FileState, String>;

    /// Whether the record of a former run with the same options has all requested data.
    fn is_complete(&self, _: &Record) -> bool {
        true
    }

    /// Whether the output of a former run exists, but was never compared with its source.
    fn is_unverified(&self, _: &Record) -> bool {
        false
    }

    /// Compares the output of a former run with its source.
    fn verify(&self, _: &Input, _: &Output<'_>, _: &mut Record) -> Result<(), String> {
        Ok(())
    }

    /// A hash of the facts about a file's skeleton that the output depends on, and that other files may determine.
    fn shared_figure(&self, _: &Path) -> Option<String> {
        None
    }

    /// Whether the results of other files may change the output of a former run. Then the file waits for these results.
    fn waits(&self, _: &Record) -> bool {
        false
    }

    /// Receives the results of all other files, before the waiting files are made.
    fn learn(&mut self, _: &[&Record]) {}

    /// The notices below the summary about all files, including files of former runs.
    fn summary(&self, _: &[&Record]) -> Vec<String> {
        Vec::new()
    }

    /// Receives the records of all files so far, after each file.
    fn keep(&self, _: &BTreeMap<String, Record>) {}

    /// Returns the verdict of the run, which decides the exit code.
    fn finish(&self, _: &[&Record], counts: &Counts) -> Result<(), Failure> {
        counts.verdict()
    }
}

/// Whether the output of a file was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FileState {
    Done,
    /// The file waits for other results, and is made again after [`FileTask::learn`].
    Waits,
}

/// Many files, and the folder of their outputs.
pub(crate) struct FileBatch<'a> {
    pub(crate) paths: &'a [PathBuf],
    pub(crate) folder: &'a Path,
    /// The body to which motions are retargeted. It is not an input, and is never replaced.
    pub(crate) target: Option<&'a Path>,
    /// Further files that every output depends on. They are never replaced. If one of them is among the inputs, an
    /// output is made from this file too.
    pub(crate) others: &'a [PathBuf],
    pub(crate) inputs: &'a InputArgs,
    pub(crate) spread: &'a SpreadArgs,
    pub(crate) resume: bool,
    pub(crate) force: bool,
    /// Whether the run must not write files.
    pub(crate) is_dry_run: bool,
    /// Everything that an output depends on except the input, as text, for the manifest.
    pub(crate) options: String,
}

/// The result of a file, and its new record, if it has one. `None` while the file waits for other files.
type FileOutcome = Option<(Outcome, Option<Record>)>;

impl FileBatch<'_> {
    /// Runs the work on all files.
    pub(crate) fn run(&self, work: &mut impl FileTask) -> Result<(), Failure> {
        let (folder, spread) = (self.folder, self.spread);
        let in_folder = |error: io::Error| Failure::Folder(folder.to_owned(), error);
        // The input folder may contain outputs of a former run.
        let known = KnownOutputs::of(folder);
        let left_out = Cell::new(false);
        let is_target = |path: &Path| {
            let is_it = self.target.is_some_and(|target| is_same_file(path, target));
            left_out.set(left_out.get() || is_it);
            is_it
        };
        let mut inputs = inputs::find_except(self.paths, self.inputs, &|base, path| {
            known.has(base, path) || is_target(path)
        })?;
        inputs::refuse_missing(&inputs)?;
        if let Some(target) = self.target.filter(|_| left_out.get()) {
            report::say(&format!(
                "{}: this is the target of the motions, so it cannot be an input",
                target.display()
            ));
        }
        inputs = inputs::split_clips(inputs, thread_count(spread.threads), |file| work.clips(file));
        // Outputs are named before the shard is selected, so that all shards use the same names.
        let outputs = name_outputs(&inputs, work.extension())?;
        let all = inputs
            .iter()
            .map(|input| input.path.as_path())
            .chain(self.others.iter().map(PathBuf::as_path))
            .chain(self.target);
        let policy = ReplacePolicy::new(all).force(self.force);
        work.check(&policy)?;
        work.inputs(&inputs);
        inputs.retain(|input| spread.shard.is_none_or(|shard| shard.has(input)));
        refuse_file(folder)?;
        let names: HashSet<&str> = inputs.iter().map(|input| input.relative.as_str()).collect();
        let is_input = |input: &str| names.contains(input);
        let mut manifest = match self.is_dry_run {
            true => Manifest::unwritten(folder, spread.shard, Some(&is_input)),
            false => {
                make_folder(folder)?;
                Manifest::open(folder, spread.shard, Some(&is_input))
            }
        }
        .map_err(in_folder)?;
        let run = Run {
            many: self,
            outputs,
            former: manifest.records().clone(),
            policy,
            claims: Claims::default(),
        };
        let mut progress = Progress::new(spread.progress(), &inputs);
        let done = self.rounds(&run, &inputs, work, &mut manifest, &mut progress);
        done.map_err(|error| self.stopped(progress.counts(), error))?;
        let counts = progress.finish();
        let records = manifest.records().clone();
        let finished = manifest.finish(is_input);
        finished.map_err(|error| self.stopped(&counts, error))?;
        let records: Vec<&Record> = records.values().filter(|record| is_input(&record.input)).collect();
        match self.is_dry_run {
            true => self.tell_dry_run(&records),
            false => report::say(&summary(&counts)),
        }
        work.summary(&records).iter().for_each(|line| report::say(line));
        work.finish(&records, &counts)
    }

    /// Works on the inputs, then on the inputs that waited for other results.
    fn rounds<W: FileTask>(
        &self,
        run: &Run<'_>,
        inputs: &[Input],
        work: &mut W,
        manifest: &mut Manifest,
        progress: &mut Progress,
    ) -> io::Result<()> {
        let waiting = run.round(inputs, &*work, manifest, progress)?;
        if !waiting.is_empty() {
            let waits: HashSet<&str> = waiting.iter().map(|input| input.relative.as_str()).collect();
            let records = manifest.records().values();
            work.learn(&Vec::from_iter(
                records.filter(|record| !waits.contains(record.input.as_str())),
            ));
            run.round(&waiting, &*work, manifest, progress)?;
        }
        if self.is_dry_run {
            return Ok(());
        }
        let own = inputs.iter().filter_map(|input| run.outputs.get(&input.relative));
        let own = own.map(|output| self.folder.join(output));
        // An existing `.gltf` output also has a buffer, a `.bin`.
        let mut own: Vec<PathBuf> = own.flat_map(|output| [output.with_extension("bin"), output]).collect();
        own.extend(run.claims.paths());
        own.push(Manifest::path(self.folder, self.spread.shard));
        // Do not remove temporary files earlier, because a remaining `.gltf` shows the owner of its buffer. Keep the
        // temporary files of other shards, which may be running in the same folder.
        remove_all_unfinished(own.iter().map(PathBuf::as_path));
        Ok(())
    }

    /// Prints the outputs that the run would write without `--dry-run`, with the assumptions about each file.
    fn tell_dry_run(&self, records: &[&Record]) {
        for record in records {
            let Some(output) = &record.output else { continue };
            let output = self.folder.join(output);
            let replaces = if output.exists() {
                ", replacing the existing file"
            } else {
                ""
            };
            report::say(&format!("{} -> {}{replaces}", record.input, output.display()));
            let guesses = record.guesses.iter().map(ToString::to_string);
            guesses
                .chain(record.warnings.iter().cloned())
                .for_each(|line| report::say(&format!("  {line}")));
        }
        let done = records.iter().filter(|record| record.output.is_some()).count();
        report::say(&format!("dry run: {done} of {} files would be written", records.len()));
    }

    /// The failure of a run that cannot continue, for example on a full disk. If some files are done, only the others
    /// failed.
    fn stopped(&self, counts: &Counts, error: io::Error) -> Failure {
        let failure = Failure::Folder(self.folder.to_owned(), error);
        if counts.done == counts.failed {
            return failure;
        }
        report::complain(&failure.into_words());
        Failure::Some
    }
}

/// Refuses a file if the outputs need a folder.
fn refuse_file(folder: &Path) -> Result<(), Failure> {
    // Remove a separator at the end, which the name of a file cannot have.
    let name: PathBuf = folder.components().collect();
    if name.exists() && !name.is_dir() {
        let what = if name.is_file() { "a file" } else { "a device or a pipe" };
        let message = format!(
            "{}: this is {what}, but the outputs need a folder; name a folder",
            name.display()
        );
        return Err(Failure::Usage(message));
    }
    Ok(())
}

/// Creates the output folder and its parent folders, if missing.
pub(crate) fn make_folder(folder: &Path) -> Result<(), Failure> {
    refuse_file(folder)?;
    fs::create_dir_all(folder).map_err(|error| Failure::Folder(folder.to_owned(), error))
}

/// Whether two paths lead to one file.
fn is_same_file(path: &Path, other: &Path) -> bool {
    let is_same = || Some(path.canonicalize().ok()? == other.canonicalize().ok()?);
    path == other || (path.file_name() == other.file_name() && is_same() == Some(true))
}

struct Run<'a> {
    many: &'a FileBatch<'a>,
    /// The output path of every input, relative to the folder.
    outputs: HashMap<String, String>,
    /// The records of former runs.
    former: BTreeMap<String, Record>,
    policy: ReplacePolicy,
    claims: Claims,
}

impl Run<'_> {
    /// Processes the inputs. Returns the inputs that must wait for other results, sorted.
    fn round<W: FileTask>(
        &self,
        inputs: &[Input],
        work: &W,
        manifest: &mut Manifest,
        progress: &mut Progress,
    ) -> io::Result<Vec<Input>> {
        let mut waiting = Vec::new();
        let one = |input: &Input| self.one(input, work);
        let panicked = |input: &Input| {
            let mut record = Record::new(input, &self.many.options);
            record.error = Some(PANICKED.to_owned());
            Some((Outcome::Failed, Some(record)))
        };
        let add = |index: usize, ended: FileOutcome| {
            let input = &inputs[index];
            let Some((outcome, record)) = ended else {
                waiting.push(input.clone());
                return Ok::<_, io::Error>(());
            };
            progress.add(input, outcome);
            if let Some(error) = record.as_ref().and_then(|record| record.error.as_ref()) {
                progress.tell_failure(input, error);
            }
            if let Some(record) = record {
                manifest.add(record)?;
                work.keep(manifest.records());
            }
            Ok(())
        };
        for_each(inputs, thread_count(self.many.spread.threads), one, panicked, add)?;
        waiting.sort_by(|a, b| a.relative.cmp(&b.relative));
        Ok(waiting)
    }

    fn one(&self, input: &Input, work: &impl FileTask) -> FileOutcome {
        let start = Instant::now();
        let mut record = Record::new(input, &self.many.options);
        let outcome = match self.make(input, &mut record, work) {
            Ok(None) => return None,
            // A file that was skipped keeps its former record. But if its former output was compared now, the file gets
            // a new record.
            Ok(Some(Outcome::Skipped)) if record.output.is_none() => return Some((Outcome::Skipped, None)),
            Ok(Some(outcome)) => outcome,
            Err(error) => {
                record.error = Some(error);
                Outcome::Failed
            }
        };
        record.seconds = start.elapsed().as_secs_f64();
        Some((outcome, Some(record)))
    }

    /// Makes the output of a file, unless a former run has made it. `None` if the file waits.
    fn make(&self, input: &Input, record: &mut Record, work: &impl FileTask) -> Result<Option<Outcome>, String> {
        let in_file = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
        let file = input.path().map_err(|error| error.to_string())?;
        record.sha256 = Some(sha256(file).map_err(|error| in_file(file, error))?);
        let name = &self.outputs[&input.relative];
        let former = self.former.get(&input.relative);
        let of_former = former.filter(|former| former.output.as_ref() == Some(name));
        let output = Output {
            name,
            path: self.many.folder.join(name),
            input: file,
            policy: &self.policy,
            folder: self.many.folder,
            former: of_former,
            claims: &self.claims,
        };
        record.shared_figure = work.shared_figure(file);
        let is_there = |former: &&Record| is_alike(former, record) && former.is_whole(self.many.folder);
        if let Some(former) = of_former.filter(|_| self.many.resume).filter(is_there) {
            if work.waits(former) {
                return Ok(None);
            }
            if work.is_complete(former) {
                if work.is_unverified(former) {
                    *record = former.clone();
                    work.verify(input, &output, record)?;
                }
                return Ok(Some(Outcome::Skipped));
            }
        }
        let folder = output.path.parent().unwrap_or(self.many.folder);
        // Check first: creating would lock the parent folder, where another thread may be working.
        if !folder.is_dir() && !self.many.is_dry_run {
            fs::create_dir_all(folder).map_err(|error| in_file(folder, error))?;
        }
        match work.make(input, &output, record)? {
            FileState::Done => {
                record.output = Some(name.clone());
                Ok(Some(Outcome::Done))
            }
            FileState::Waits => Ok(None),
        }
    }
}

/// Whether a former run has read these bytes with these options, without an error.
fn is_alike(former: &Record, record: &Record) -> bool {
    former.error.is_none()
        && former.sha256 == record.sha256
        && former.options == record.options
        && former.shared_figure == record.shared_figure
        && former.version == record.version
}

/// `motions on the robot: 5 good, 1 fair, 0 poor`; `None` without any.
pub(crate) fn verdicts(name: &str, found: impl Iterator<Item = Verdict>) -> Option<String> {
    let found: Vec<Verdict> = found.collect();
    let counts = [Verdict::Good, Verdict::Fair, Verdict::Poor].map(|verdict| {
        let count = found.iter().filter(|other| **other == verdict).count();
        format!("{count} {}", verdict.as_str())
    });
    (!found.is_empty()).then(|| format!("{name}: {}", counts.join(", ")))
}

/// `9,998 of 10,000 files in 4.2 s`, with further counts.
fn summary(counts: &Counts) -> String {
    let Counts {
        files,
        skipped,
        failed,
        seconds,
        megabytes_per_second,
        ..
    } = counts;
    let converted = files - skipped - failed;
    format!(
        "{converted} of {files} files converted, {skipped} done before, {failed} failed: \
         {seconds:.1} s, {megabytes_per_second:.1} MB/s"
    )
}
