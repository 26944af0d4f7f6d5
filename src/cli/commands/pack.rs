//! `mocap pack`: writes many motion files into Parquet files.

mod dataset;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use mocap::arrays::table::arrow_array::RecordBatch;
use mocap::arrays::table::dataset::DatasetClip;
use mocap::arrays::{ArrayOptions, Arrays, table};
use mocap::files::{unfinished_target, write_file};
use mocap::job::clips_of;
use mocap::{Clips, Code, Diagnostic, Error, Importer, Scene, SkeletonMesh};

use super::{Place, print_report};
use crate::args::{ArgumentSources, ArraysArgs, PackArgs, PackFormatArg, TableArg};
use crate::batch::folder::make_folder;
use crate::batch::hash::sha256;
use crate::batch::inputs::{self, Input};
use crate::batch::manifest::{Manifest, OutputFile, Record};
use crate::batch::progress::{Counts, Outcome, Progress};
use crate::batch::{self, InOrder, thread_count};
use crate::printed::FilesReport;
use crate::{Failure, report};

/// The rows of one file.
struct Packed {
    record: Record,
    rows: Option<Rows>,
    /// Its row on the dataset card.
    clip: Option<DatasetClip>,
}

enum Rows {
    Clip(RecordBatch),
    /// One row for each frame and joint. The rows are made when they are written, because a table is several times as
    /// large.
    Long(String, Box<Arrays>),
}

/// The options for making rows of files.
struct Packer<'a> {
    importer: Importer,
    options: ArrayOptions,
    table: TableArg,
    /// The options as text, for the manifest.
    options_text: &'a str,
}

/// The Parquet files of a run. Rows are in the order of their inputs, so the files do not depend on the number of
/// threads. A file is written when it has enough rows. Only then are its inputs recorded as done.
struct Parts<'a> {
    folder: &'a Path,
    prefix: String,
    next: u64,
    most_bytes: usize,
    bytes: usize,
    rows: Vec<Rows>,
    records: Vec<Record>,
    manifest: Manifest,
    /// The number of files that this run has written.
    written: usize,
}

pub(crate) fn run(args: &PackArgs, given: &ArgumentSources) -> Result<(), Failure> {
    let options_text = given.options.as_str();
    if let TableArg::Inventory = args.table() {
        let why = "an inventory has no motion; leave the option out, or use another --table";
        let names = ArraysArgs::names();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        given.refuse(&names, why)?;
        given.refuse(&["unit", "up", "map"], why)?;
    }
    args.arrays.check(&args.source, given)?;
    let folder = args.out_dir.as_path();
    let in_folder = |error: io::Error| Failure::Folder(folder.to_owned(), error);
    let mut inputs = split(inputs::find(&args.paths, &args.inputs)?, args);
    if let PackFormatArg::Hf = args.to {
        return dataset::run(args, given, &inputs);
    }
    given.refuse(&["license"], "only the card of --to hf states the licence")?;
    inputs.retain(|input| args.spread.shard.is_none_or(|shard| shard.has(input)));
    make_folder(folder)?;
    let prefix = match args.spread.shard {
        Some(shard) => format!("part-{}-", shard.name()),
        None => "part-".to_owned(),
    };
    if !args.force.force {
        refuse_parts_of_others(folder, &prefix)?;
    }
    let all = |_: &str| true;
    let is_kept = args.resume.then_some(&all as &dyn Fn(&str) -> bool);
    let manifest = Manifest::open(folder, args.spread.shard, is_kept).map_err(in_folder)?;
    let former = manifest.records().clone();
    let kept = kept_parts(&former, &inputs, folder, &prefix, options_text);
    remove_parts(folder, &prefix, &kept).map_err(in_folder)?;
    let mut parts = Parts {
        folder,
        next: kept
            .iter()
            .filter_map(|part| number(&prefix, part))
            .max()
            .map_or(0, |last| last + 1),
        prefix,
        most_bytes: args.part_size as usize * 1_000_000,
        bytes: 0,
        rows: Vec::new(),
        records: Vec::new(),
        manifest,
        written: 0,
    };
    let is_kept = |input: &Input| {
        let output = former.get(&input.relative).and_then(|record| record.output.as_deref());
        output.is_some_and(|output| kept.contains(output))
    };
    let (done, left): (Vec<Input>, Vec<Input>) = inputs.iter().cloned().partition(is_kept);
    let mut progress = Progress::new(args.spread.progress(), &inputs);
    for input in &done {
        progress.add(input, Outcome::Skipped);
    }
    let packer = Packer::new(args, options_text, args.arrays.options(&args.source, &args.map));
    let mut failures = Vec::new();
    let mut in_order = InOrder::new();
    let take_in = |index: usize, packed: Packed| -> io::Result<()> {
        if let Some(error) = &packed.record.error {
            failures.push(format!("  {}  {error}", packed.record.input));
        }
        let outcome = if packed.record.error.is_some() {
            Outcome::Failed
        } else {
            Outcome::Done
        };
        progress.add(&left[index], outcome);
        in_order.push(index, packed);
        while let Some(packed) = in_order.pop() {
            parts.push(packed)?;
        }
        Ok(())
    };
    let threads = thread_count(args.spread.threads);
    let (pack, panicked) = (
        |input: &Input| packer.pack(input),
        |input: &Input| packer.panicked(input),
    );
    let packed = batch::for_each(&left, threads, pack, panicked, take_in);
    packed
        .and_then(|()| parts.write())
        .map_err(|error| parts.stopped(error))?;
    let names: BTreeSet<&str> = inputs.iter().map(|input| input.relative.as_str()).collect();
    parts
        .manifest
        .finish(|input| names.contains(input))
        .map_err(in_folder)?;
    tell(args, progress.finish(), failures)
}

/// Makes an input of each clip of the files, because a motion in a table is one clip. An inventory is about files.
fn split(inputs: Vec<Input>, args: &PackArgs) -> Vec<Input> {
    if args.read.clip != Clips::All || matches!(args.table(), TableArg::Inventory) {
        return inputs;
    }
    let importer = args.read.importer().threads(1).skeleton_mesh(SkeletonMesh::None);
    inputs::split_clips(inputs, thread_count(args.spread.threads), |file| {
        clips_of(file, || importer.import(file))
    })
}

/// Reports the number of packed files, and the failures.
fn tell(args: &PackArgs, counts: Counts, mut failures: Vec<String>) -> Result<(), Failure> {
    let packed = counts.files - counts.skipped - counts.failed;
    if args.json {
        let (files, failed) = (counts.files, counts.failed);
        print_report(&FilesReport { files, failed }, true, Place::Message)?;
    }
    report::say(&format!(
        "{packed} of {} files packed, {} done before, {} failed: {:.1} s, {:.1} MB/s",
        counts.files, counts.skipped, counts.failed, counts.seconds, counts.megabytes_per_second
    ));
    failures.sort_unstable();
    // Print only some of the failures. The manifest or the card lists all of them.
    failures.iter().take(20).for_each(|failure| report::say(failure));
    counts.verdict()
}

impl<'a> Packer<'a> {
    fn new(args: &PackArgs, options_text: &'a str, options: ArrayOptions) -> Self {
        Self {
            importer: args.read.importer().skeleton_mesh(SkeletonMesh::None),
            options,
            table: args.table(),
            options_text,
        }
    }

    fn pack(&self, input: &Input) -> Packed {
        let start = Instant::now();
        let mut record = Record::new(input, self.options_text);
        let mut clip = None;
        let rows = self.rows(input, &mut record, &mut clip);
        record.seconds = start.elapsed().as_secs_f64();
        Packed { record, rows, clip }
    }

    /// The row of a file on which [`pack`](Self::pack) panicked.
    fn panicked(&self, input: &Input) -> Packed {
        let record = Record::new(input, self.options_text);
        Packed {
            record: Record {
                error: Some(batch::PANICKED.to_owned()),
                ..record
            },
            rows: None,
            clip: None,
        }
    }

    /// The rows of a file. In tables with one row per file, a file that cannot be read has a row with the error.
    fn rows(&self, input: &Input, record: &mut Record, summary: &mut Option<DatasetClip>) -> Option<Rows> {
        let clip = input.relative.as_str();
        record.sha256 = sha256(&input.path).ok();
        let importer = match input.clip {
            Some(clip) => self.importer.clone().clips(Clips::Index(clip)),
            None => self.importer.clone(),
        };
        let mut scene = input.path().and_then(|path| importer.import(path));
        scene.iter_mut().for_each(Scene::put_main_clip_first);
        if let Ok(scene) = &scene {
            record.warnings = scene.warnings.iter().map(ToString::to_string).collect();
        }
        if let TableArg::Inventory = self.table {
            record.error = scene.as_ref().err().map(ToString::to_string);
            return Some(Rows::Clip(table::inventory(&[(clip, &scene)])));
        }
        let attribution = scene
            .as_ref()
            .map(|scene| scene.metadata.attribution.clone())
            .unwrap_or_default();
        let motion = scene.and_then(|scene: Scene| self.arrays(&scene));
        let motion = motion.map_err(|error| error.to_string());
        record.error = motion.as_ref().err().cloned();
        let about = |motion| DatasetClip::new(clip, motion).attributed(&attribution);
        *summary = motion.as_ref().ok().map(about);
        if let TableArg::Long = self.table {
            return motion.ok().map(|motion| Rows::Long(clip.to_owned(), Box::new(motion)));
        }
        let row = (clip, motion.as_ref().map_err(String::as_str));
        Some(Rows::Clip(table::clips(&[row], &self.options)))
    }

    fn arrays(&self, scene: &Scene) -> Result<Arrays, Error> {
        let motion = Arrays::of(scene, &self.options)?;
        if !matches!(self.table, TableArg::Long) {
            table::check_row(&motion)?;
        }
        Ok(motion)
    }
}

impl Rows {
    fn tables(&self) -> Box<dyn Iterator<Item = RecordBatch> + '_> {
        match self {
            Self::Clip(row) => Box::new(std::iter::once(row.clone())),
            Self::Long(clip, motion) => Box::new(motion.tables(clip)),
        }
    }

    /// The approximate size of the rows as a table, in bytes.
    fn bytes(&self) -> usize {
        match self {
            Self::Clip(row) => row.get_array_memory_size(),
            Self::Long(clip, motion) => {
                let velocities = motion.velocities.as_ref().map_or(0, Vec::len);
                let floats = motion.positions.len() + motion.rotations.len() + velocities;
                // Each row also has two strings with their offsets, a frame and a time. A joint's name has about 8
                // bytes.
                4 * floats + motion.rows() * (clip.len() + 8 + 4 + 4 + 4 + 8)
            }
        }
    }
}

impl Parts<'_> {
    /// The failure of a run that cannot continue, for example on a full disk. If some files are written, only the
    /// others failed.
    fn stopped(&self, error: io::Error) -> Failure {
        let failure = Failure::Folder(self.folder.to_owned(), error);
        if self.written == 0 {
            return failure;
        }
        report::complain(&failure.into_words());
        Failure::Some
    }

    fn push(&mut self, packed: Packed) -> io::Result<()> {
        if let Some(rows) = packed.rows {
            self.bytes += rows.bytes();
            self.rows.push(rows);
        }
        self.records.push(packed.record);
        if self.bytes >= self.most_bytes {
            self.write()
        } else {
            Ok(())
        }
    }

    /// Writes the collected rows as one file, then records its inputs.
    fn write(&mut self) -> io::Result<()> {
        let rows = std::mem::take(&mut self.rows);
        let (mut output, mut files) = (None, Vec::new());
        if !rows.is_empty() {
            let name = part_name(&self.prefix, self.next);
            let bytes = table::to_parquet(rows.iter().flat_map(Rows::tables)).map_err(io::Error::other)?;
            let path = self.folder.join(&name);
            write_file(&path, &bytes).map_err(io::Error::other)?;
            self.next += 1;
            self.written += 1;
            files.push(OutputFile::new(&path, &[bytes.into()]));
            output = Some(name);
        }
        self.bytes = 0;
        for mut record in self.records.drain(..) {
            record.output.clone_from(&output);
            record.files.clone_from(&files);
            self.manifest.add(record)?;
        }
        Ok(())
    }
}

/// The part files of former runs that are still valid. A part is valid if it has every written byte, and each of its
/// inputs exists, is unchanged and was packed with the same options.
fn kept_parts(
    former: &BTreeMap<String, Record>,
    inputs: &[Input],
    folder: &Path,
    prefix: &str,
    options: &str,
) -> BTreeSet<String> {
    let paths: BTreeMap<&str, &Path> = inputs
        .iter()
        .map(|input| (input.relative.as_str(), input.path.as_path()))
        .collect();
    let stands = |record: &Record| {
        let path = paths.get(record.input.as_str());
        let hash = path.and_then(|path| sha256(path).ok());
        record.options == options
            && record.version == env!("CARGO_PKG_VERSION")
            && hash.is_some()
            && record.sha256 == hash
    };
    let mut parts = BTreeMap::<&str, Vec<&Record>>::new();
    for record in former.values() {
        if let Some(output) = &record.output {
            parts.entry(output).or_default().push(record);
        }
    }
    let is_kept = |output: &str, records: &[&Record]| {
        let is_one = records.iter().all(|record| record.files == records[0].files);
        number(prefix, output).is_some()
            && is_one
            && records[0].is_whole(folder)
            && records.iter().copied().all(&stands)
    };
    let kept = parts.into_iter().filter(|(output, records)| is_kept(output, records));
    kept.map(|(output, _)| output.to_owned()).collect()
}

/// The Parquet files in `folder` with names of a run, and temporary files of killed runs, each as its path and its
/// final path.
fn parts(folder: &Path, prefix: &str) -> io::Result<Vec<(PathBuf, PathBuf)>> {
    let mut parts = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let target = unfinished_target(&path).unwrap_or_else(|| path.clone());
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with(prefix) && name.ends_with(".parquet") {
            parts.push((path, target));
        }
    }
    Ok(parts)
}

/// Refuses a folder with Parquet files of other programs: readers take all files of the folder as one table, and parts
/// of former runs are removed.
fn refuse_parts_of_others(folder: &Path, prefix: &str) -> Result<(), Failure> {
    let parts = parts(folder, prefix).map_err(|error| Failure::Folder(folder.to_owned(), error))?;
    let is_ours = |path: &Path| File::open(path).is_ok_and(|file| table::is_own_parquet(&file));
    let is_of_others = |(path, target): &&(PathBuf, PathBuf)| path == target && !is_ours(path);
    match parts.iter().find(is_of_others) {
        None => Ok(()),
        Some((path, _)) => {
            let message = "this Parquet file would be removed, but mocap did not write it, or it is incomplete";
            let diagnostic = Diagnostic::new(Code::OutputExists, message)
                .help("name another folder, or replace the Parquet files of this one with --force");
            Err(Error::from(diagnostic).with_path(path).into())
        }
    }
}

/// Removes the files of former runs that are not kept, and temporary files of killed runs.
fn remove_parts(folder: &Path, prefix: &str, kept: &BTreeSet<String>) -> io::Result<()> {
    for (path, target) in parts(folder, prefix)? {
        let name = target.file_name().unwrap_or_default().to_string_lossy();
        if path != target || !kept.contains(name.as_ref()) {
            fs::remove_file(path)?;
        }
    }
    Ok(())
}

fn part_name(prefix: &str, number: u64) -> String {
    format!("{prefix}{number:05}.parquet")
}

/// The number in the name of a part. `None` for a name that no run uses.
fn number(prefix: &str, output: &str) -> Option<u64> {
    let number: u32 = output.strip_prefix(prefix)?.strip_suffix(".parquet")?.parse().ok()?;
    (output == part_name(prefix, number.into())).then_some(number.into())
}
