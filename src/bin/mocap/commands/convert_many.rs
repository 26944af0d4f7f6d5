//! `mocap convert -o`: many motion files into a folder.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use mocap::files::{ReplacePolicy, has_provenance, unfinished_target};
use mocap::scene::{Confidence, Topic, UpAxis};
use walkdir::WalkDir;

use super::convert::Round;
use super::{convert, verify};
use crate::args::{ConvertArgs, Given};
use crate::batch::hash::sha256;
use crate::batch::inputs::{self, Input};
use crate::batch::manifest::{self, Manifest, Record};
use crate::batch::progress::{Counts, Outcome, Progress};
use crate::batch::{self, thread_count};
use crate::{Failure, report};

/// Where the outputs go, and what they depend on.
struct Run<'a> {
    args: &'a ConvertArgs,
    folder: &'a Path,
    /// The options as text, for the manifest.
    options: &'a str,
    /// The output of every input, below the folder.
    outputs: HashMap<String, String>,
    /// What former runs say of their inputs.
    former: BTreeMap<String, Record>,
    policy: ReplacePolicy,
}

/// How a file ended, and what is new to say of it.
struct Ended {
    outcome: Outcome,
    record: Option<Record>,
    /// Whether nothing is said of it yet, because it waits for what the other clips of its skeleton say.
    waits: bool,
}

/// What has come of the files so far.
struct Results<'a> {
    progress: Progress,
    manifest: Manifest,
    /// The rows of former runs.
    former: &'a BTreeMap<String, Record>,
    /// Inputs that failed, each with its error.
    failures: Vec<(String, String)>,
    clips: Clips,
    /// Inputs that wait for the last round.
    waiting: Vec<Input>,
}

impl Results<'_> {
    fn add(&mut self, input: &Input, ended: Ended) -> io::Result<()> {
        if ended.waits {
            self.waiting.push(input.clone());
            return Ok(());
        }
        self.progress.add(input, ended.outcome);
        if let Some(record) = ended.record.as_ref().or(self.former.get(&input.relative)) {
            self.clips.add(record);
        }
        let Some(record) = ended.record else { return Ok(()) };
        if let Some(error) = &record.error {
            self.failures.push((record.input.clone(), error.clone()));
        }
        self.manifest.add(record)
    }
}

/// What clips say of their skeletons.
#[derive(Default)]
struct Clips {
    /// For each skeleton the up axes of the clips in which it is sure.
    up: BTreeMap<String, BTreeSet<String>>,
    /// The number of files in each unit.
    units: BTreeMap<String, usize>,
}

impl Clips {
    fn add(&mut self, record: &Record) {
        for guess in &record.guesses {
            if guess.topic == Topic::Unit {
                *self.units.entry(guess.choice.clone()).or_default() += 1;
            }
            if let (Topic::Up, Some(Confidence::Sure), Some(skeleton)) =
                (guess.topic, guess.confidence, &record.skeleton)
            {
                self.up
                    .entry(skeleton.clone())
                    .or_default()
                    .insert(guess.choice.clone());
            }
        }
    }

    /// The skeletons all of whose clips stand along one axis.
    fn axes(&self) -> BTreeMap<String, UpAxis> {
        let one = |(skeleton, axes): (&String, &BTreeSet<String>)| {
            let named = |up: &UpAxis| axes.len() == 1 && axes.contains(up.as_str());
            let up = UpAxis::ALL.into_iter().find(named)?;
            Some((skeleton.clone(), up))
        };
        self.up.iter().filter_map(one).collect()
    }

    /// `unit: cm in 12 files, inch in 1 file`.
    fn units(&self) -> Option<String> {
        let unit = |(unit, files): (&String, &usize)| {
            let noun = if *files == 1 { "file" } else { "files" };
            format!("{unit} in {files} {noun}")
        };
        let units: Vec<String> = self.units.iter().map(unit).collect();
        (!units.is_empty()).then(|| format!("unit: {}", units.join(", ")))
    }
}

/// Converts what the arguments name into `folder`.
pub(crate) fn run(args: &ConvertArgs, folder: &Path, given: &Given) -> Result<(), Failure> {
    convert::check(args)?;
    convert::refuse_unused(args, given, args.batch.to)?;
    let spread = &args.batch.spread;
    let in_folder = |error: io::Error| Failure::Folder(folder.to_owned(), error);
    // The input folder may contain outputs of a former run.
    let known = KnownOutputs::of(folder);
    let mut inputs = inputs::find_except(&args.paths, &args.batch.inputs, |path| known.has(path))?;
    // Outputs are named before the shard is taken, so that every shard names them alike.
    let outputs = name_outputs(&inputs, args.batch.to.extension())?;
    let policy = ReplacePolicy::new(inputs.iter().map(|input| &input.path)).force(args.force);
    inputs.retain(|input| spread.shard.is_none_or(|shard| shard.has(input)));
    fs::create_dir_all(folder).map_err(in_folder)?;
    let names: HashSet<&str> = inputs.iter().map(|input| input.relative.as_str()).collect();
    let is_input = |input: &str| names.contains(input);
    let manifest = Manifest::open(folder, spread.shard, Some(&is_input)).map_err(in_folder)?;
    let run = Run {
        args,
        folder,
        options: &given.options,
        outputs,
        former: manifest.records().clone(),
        policy,
    };
    let mut results = Results {
        progress: Progress::new(spread.progress(), &inputs),
        former: &run.former,
        manifest,
        failures: Vec::new(),
        clips: Clips::default(),
        waiting: Vec::new(),
    };
    let threads = thread_count(spread.threads);
    let panicked = |input: &Input| run.panicked(input);
    let convert = |input: &Input| run.convert(input, Round::First);
    let add = |index: usize, ended| results.add(&inputs[index], ended);
    batch::for_each(&inputs, threads, convert, panicked, add).map_err(in_folder)?;
    let (mut waiting, axes) = (std::mem::take(&mut results.waiting), results.clips.axes());
    waiting.sort_by(|a, b| a.relative.cmp(&b.relative));
    let convert = |input: &Input| run.convert(input, Round::Last(&axes));
    let add = |index: usize, ended| results.add(&waiting[index], ended);
    batch::for_each(&waiting, threads, convert, panicked, add).map_err(in_folder)?;
    let own = inputs.iter().filter_map(|input| run.outputs.get(&input.relative));
    let own = own.map(|output| folder.join(output));
    let own = own.chain([Manifest::path(folder, spread.shard)]);
    // Not before, because a `.gltf` that is left says whose its buffer is.
    remove_unfinished(folder, own).map_err(in_folder)?;
    let Results {
        progress,
        manifest,
        failures,
        clips,
        ..
    } = results;
    let counts = progress.finish();
    manifest.finish(is_input).map_err(in_folder)?;
    if !spread.quiet {
        report::say(&summary(&counts));
        if let Some(units) = clips.units() {
            report::say(&units);
        }
        tell_failures(failures);
    }
    counts.verdict()
}

impl Run<'_> {
    fn convert(&self, input: &Input, round: Round<'_>) -> Ended {
        let start = Instant::now();
        let mut record = Record::new(input, self.options);
        let mut waits = false;
        let outcome = match self.fill(input, &mut record, round) {
            Ok(Some(outcome)) => outcome,
            Ok(None) => {
                waits = true;
                Outcome::Skipped
            }
            Err(error) => {
                record.error = Some(error);
                Outcome::Failed
            }
        };
        record.seconds = start.elapsed().as_secs_f64();
        Ended {
            outcome,
            record: (outcome != Outcome::Skipped).then_some(record),
            waits,
        }
    }

    /// The row of a file on which [`convert`](Self::convert) panicked.
    fn panicked(&self, input: &Input) -> Ended {
        let record = Record::new(input, self.options);
        Ended {
            outcome: Outcome::Failed,
            record: Some(Record {
                error: Some(batch::PANICKED.to_owned()),
                ..record
            }),
            waits: false,
        }
    }

    /// Converts a file, and notes in `record` what comes to light. `None` where it waits for the last round.
    fn fill(&self, input: &Input, record: &mut Record, round: Round<'_>) -> Result<Option<Outcome>, String> {
        let in_file = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
        let file = input.path().map_err(|error| error.to_string())?;
        record.sha256 = Some(sha256(file).map_err(|error| in_file(file, error))?);
        let output = &self.outputs[&input.relative];
        let path = self.folder.join(output);
        if self.is_done(record, output) && path.exists() {
            return Ok(Some(Outcome::Skipped));
        }
        let folder = path.parent().unwrap_or(self.folder);
        // Only asking does not lock the folder above, where another thread may be at work.
        if !folder.is_dir() {
            fs::create_dir_all(folder).map_err(|error| in_file(folder, error))?;
        }
        let is_known = || self.is_known(input, output, &path);
        let converted = convert::convert(self.args, file, &path, &self.policy, &is_known, round);
        let converted = converted.map_err(|error| error.to_string())?;
        if converted.waits {
            return Ok(None);
        }
        record.skeleton = Some(converted.skeleton);
        record.guesses = converted.guesses;
        record.warnings = converted.warnings.iter().map(ToString::to_string).collect();
        record.output = Some(output.clone());
        record.output_sha256 = converted.hash;
        record.max_error = converted.max_error;
        let allowed = self.args.compress.tolerance();
        if let Some(verification) = converted.verification.filter(|found| !found.is_within(allowed)) {
            return Err(verify::difference(&verification, allowed));
        }
        Ok(Some(Outcome::Done))
    }

    /// Whether a former run has written the file at `path`, according to the manifest, and it has not changed since.
    fn is_known(&self, input: &Input, output: &str, path: &Path) -> bool {
        self.former.get(&input.relative).is_some_and(|former| {
            let written = former
                .output_sha256
                .as_ref()
                .filter(|_| former.output.as_deref() == Some(output));
            written.is_some_and(|written| sha256(path).is_ok_and(|found| found == *written))
        })
    }

    /// Whether a former run has made `output` of the same bytes in the same way.
    fn is_done(&self, record: &Record, output: &str) -> bool {
        let former = self.former.get(&record.input).filter(|_| self.args.batch.resume);
        former.is_some_and(|former| {
            former.error.is_none()
                && former.sha256 == record.sha256
                && former.options == record.options
                && former.version == record.version
                && former.output.as_deref() == Some(output)
        })
    }
}

/// The files that former runs have written to a folder.
pub(super) struct KnownOutputs {
    folder: Option<PathBuf>,
    outputs: HashSet<String>,
}

impl KnownOutputs {
    pub(super) fn of(folder: &Path) -> Self {
        Self {
            folder: folder.canonicalize().ok(),
            outputs: manifest::outputs(folder),
        }
    }

    /// A glTF file says who wrote it; for other files the manifest says it.
    pub(super) fn has(&self, path: &Path) -> bool {
        let is_listed = || {
            let whole = path.canonicalize().ok()?;
            let below = whole.strip_prefix(self.folder.as_ref()?).ok()?;
            let parts: Vec<_> = below
                .components()
                .map(|part| part.as_os_str().to_string_lossy())
                .collect();
            Some(self.outputs.contains(&parts.join("/")))
        };
        path.is_file() && (has_provenance(path) || (!self.outputs.is_empty() && is_listed() == Some(true)))
    }
}

/// The output of every input, both as relative paths: with the new extension in place of the old, or behind it where
/// two inputs would get the same output.
pub(super) fn name_outputs(inputs: &[Input], extension: &str) -> Result<HashMap<String, String>, Failure> {
    // An entry that cannot be read has no output, so that it does not change the name of another output.
    let inputs = || inputs.iter().filter(|input| input.problem.is_none());
    let replaced = |input: &Input| Path::new(&input.relative).with_extension(extension);
    let mut claims = HashMap::<PathBuf, usize>::new();
    for input in inputs() {
        *claims.entry(replaced(input)).or_default() += 1;
    }
    let mut outputs = HashMap::new();
    let mut taken = HashSet::new();
    for input in inputs() {
        let output = match replaced(input) {
            output if claims[&output] == 1 => output.to_string_lossy().into_owned(),
            _ => format!("{}.{extension}", input.relative),
        };
        let is_new = taken.insert(output.clone());
        if outputs.insert(input.relative.clone(), output).is_some() {
            let message = "two inputs have this path below their input folders; name one folder that holds both";
            return Err(Failure::Usage(format!("{}: {message}", input.relative)));
        }
        if !is_new {
            let message = "another input has the same output; rename one of the two";
            return Err(Failure::Usage(format!("{}: {message}", input.relative)));
        }
    }
    Ok(outputs)
}

/// Removes what a killed run has left of these files under temporary names. Those of other shards, which may be at
/// work in the same folder, stay.
pub(super) fn remove_unfinished(folder: &Path, files: impl Iterator<Item = PathBuf>) -> io::Result<()> {
    let own: HashSet<PathBuf> = files.flat_map(|file| [file.with_extension("bin"), file]).collect();
    for entry in WalkDir::new(folder) {
        let path = entry?.into_path();
        if unfinished_target(&path).is_some_and(|target| own.contains(&target)) {
            fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// `9,998 of 10,000 files in 4.2 s`, with what is worth knowing beside.
pub(super) fn summary(counts: &Counts) -> String {
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

/// A table of the files that failed and why, or of the first of them.
pub(super) fn tell_failures(mut failures: Vec<(String, String)>) {
    const MOST: usize = 20;
    failures.sort();
    let shown = &failures[..failures.len().min(MOST)];
    let width = shown.iter().map(|(input, _)| input.chars().count()).max().unwrap_or(0);
    for (input, error) in shown {
        report::say(&format!("  {input:width$}  {error}"));
    }
    if failures.len() > MOST {
        report::say(&format!("  and {} more, listed in the manifest", failures.len() - MOST));
    }
}
