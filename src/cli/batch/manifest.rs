//! `mocap-manifest.jsonl`: the result of every file, as one line of JSON.
//!
//! During a run, a line is appended after every file, so that a killed run can be continued. At the end the file is
//! written again, sorted by input. The run of a shard has its own manifest, and `mocap merge-manifest` merges them.

use std::collections::{BTreeMap, HashSet};
use std::ffi::OsStr;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mocap::files::{FilePart, write_file};
use mocap::retarget::robot::report::RobotReport;
use mocap::scene::Assumption;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use super::hash::{sha256, sha256_of_parts};
use super::inputs::Input;
use super::lines::{self, Lines};
use super::shard::Shard;
use crate::report;

/// The result of one file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// The path of the input, relative to the folder in which the input was found.
    pub(crate) input: String,
    /// The SHA-256 of the input, as `sha256sum` prints it; absent if the file could not be read.
    pub(crate) sha256: Option<String>,
    /// The size of the input, in bytes.
    pub(crate) bytes: u64,
    /// The path of the output relative to the output folder; absent if nothing was written.
    pub(crate) output: Option<String>,
    /// The files of the output. The last one has the name of the output.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) files: Vec<OutputFile>,
    /// The program's version and options: everything that the output depends on except the input.
    pub(crate) version: String,
    pub(crate) options: String,
    /// The warnings, each as one line of text.
    pub(crate) warnings: Vec<String>,
    pub(crate) error: Option<String>,
    /// The largest distance of a joint from its position, in metres, for a compressed output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) max_error: Option<f64>,
    /// A hash of the joints' names, parents and OFFSETs. It is equal for clips of one skeleton.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) skeleton: Option<String>,
    /// A hash of the unit, the up axis, the bone map and the T-pose that the motion shares with other motions of its
    /// skeleton.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) shared_figure: Option<String>,
    /// The unit and the up axis, if they were guessed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) guesses: Vec<Assumption>,
    /// The quality of the motion on the robot: a [`RobotReport`] as text, so that its numbers are not rounded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) robot: Option<Box<RawValue>>,
    /// The quality of each clip on the character: a list of [`RetargetReport`](mocap::retarget::report::RetargetReport)
    /// as text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) retarget: Option<Box<RawValue>>,
    /// The changes of each step: a list of [`EditReport`](mocap::edit::report::EditReport) as text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) edit: Option<Box<RawValue>>,
    /// Whether the output was compared with its source, and is within the allowed error.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) verified: bool,
    /// The duration of the work on the file, in seconds.
    pub(crate) seconds: f64,
}

impl Record {
    /// The record of a file before it is read.
    pub(crate) fn new(input: &Input, options: &str) -> Self {
        Self {
            input: input.relative.clone(),
            sha256: None,
            bytes: input.bytes,
            output: None,
            files: Vec::new(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            options: options.to_owned(),
            warnings: Vec::new(),
            error: None,
            max_error: None,
            skeleton: None,
            shared_figure: None,
            guesses: Vec::new(),
            robot: None,
            verified: false,
            retarget: None,
            edit: None,
            seconds: 0.0,
        }
    }

    /// The paths of the output files in `folder` that have not changed since they were written.
    pub(crate) fn unchanged_files(&self, folder: &Path) -> Vec<PathBuf> {
        let Some(output) = &self.output else { return Vec::new() };
        let output = folder.join(output);
        let paths = self.files.iter().filter_map(|file| file.unchanged_beside(&output));
        paths.collect()
    }

    /// Whether the output in `folder` has all its files, each with every written byte.
    pub(crate) fn is_whole(&self, folder: &Path) -> bool {
        let Some((output, main)) = self.output.as_deref().zip(self.files.last()) else {
            return false;
        };
        Path::new(output).file_name() == Some(OsStr::new(&main.name))
            && self.unchanged_files(folder).len() == self.files.len()
    }

    /// The quality of the motion on the robot; also `None` if another version with other fields wrote it.
    pub(crate) fn robot_report(&self) -> Option<RobotReport> {
        serde_json::from_str(self.robot.as_ref()?.get()).ok()
    }
}

/// One of the files of an output.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct OutputFile {
    /// The name of the file in the folder of the output.
    pub(crate) name: String,
    pub(crate) bytes: u64,
    /// The SHA-256 of the file, as `sha256sum` prints it.
    pub(crate) sha256: String,
}

impl OutputFile {
    pub(crate) fn new(path: &Path, parts: &[FilePart<'_>]) -> Self {
        Self {
            name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            bytes: parts.iter().map(|part| part.len() as u64).sum(),
            sha256: sha256_of_parts(parts),
        }
    }

    /// The path of this file in the folder of `output`, if the folder has a file with the recorded name, size and
    /// bytes.
    fn unchanged_beside(&self, output: &Path) -> Option<PathBuf> {
        // A manifest that a user edited may have a path here, instead of a name.
        let is_name = Path::new(&self.name).file_name() == Some(OsStr::new(&self.name));
        let path = output.with_file_name(&self.name);
        let has_size = || fs::metadata(&path).is_ok_and(|found| found.is_file() && found.len() == self.bytes);
        let is_unchanged = is_name && has_size() && sha256(&path).is_ok_and(|found| found == self.sha256);
        is_unchanged.then_some(path)
    }
}

const START: &str = "mocap-manifest";
const EXTENSION: &str = "jsonl";

/// The manifest of a run with an output folder.
pub(crate) struct Manifest {
    path: PathBuf,
    /// Absent if the run must not write files.
    lines: Option<Lines>,
    records: BTreeMap<String, Record>,
}

impl Manifest {
    /// The path of a run's manifest.
    pub(crate) fn path(folder: &Path, shard: Option<Shard>) -> PathBuf {
        folder.join(match shard {
            Some(shard) => format!("{START}.{}.{EXTENSION}", shard.name()),
            None => format!("{START}.{EXTENSION}"),
        })
    }

    /// Opens the manifest in `folder`. Keeps the records of former runs that `is_kept` accepts. Without `is_kept`,
    /// keeps no records.
    pub(crate) fn open(
        folder: &Path,
        shard: Option<Shard>,
        is_kept: Option<&dyn Fn(&str) -> bool>,
    ) -> io::Result<Self> {
        check_own(&Self::path(folder, shard))?;
        let mut manifest = Self::unwritten(folder, shard, is_kept)?;
        // Remove the partial line of a killed run, so that it does not become the start of the next line.
        write(&manifest.path, &manifest.records)?;
        let bytes = fs::metadata(&manifest.path)?.len();
        manifest.lines = Some(Lines::open(&manifest.path, bytes)?);
        Ok(manifest)
    }

    /// Reads the manifest as [`open`](Self::open) does, for a run that writes nothing.
    pub(crate) fn unwritten(
        folder: &Path,
        shard: Option<Shard>,
        is_kept: Option<&dyn Fn(&str) -> bool>,
    ) -> io::Result<Self> {
        let (whole, path) = (Self::path(folder, None), Self::path(folder, shard));
        let mut records = BTreeMap::new();
        if let Some(is_kept) = is_kept {
            // The manifest of a shard may have been merged after the shard ran.
            read(&whole, &mut records)?;
            if path != whole {
                read(&path, &mut records)?;
            }
            records.retain(|input, _| is_kept(input));
        }
        Ok(Self {
            path,
            lines: None,
            records,
        })
    }

    /// The records so far, by input.
    pub(crate) fn records(&self) -> &BTreeMap<String, Record> {
        &self.records
    }

    /// Appends the result of a file.
    pub(crate) fn add(&mut self, record: Record) -> io::Result<()> {
        if let Some(lines) = &mut self.lines {
            lines.append(&line(&record)?)?;
        }
        self.records.insert(record.input.clone(), record);
        Ok(())
    }

    /// Sorts the lines. Drops lines that a later run has replaced, and lines for which `is_input` is false.
    pub(crate) fn finish(mut self, is_input: impl Fn(&str) -> bool) -> io::Result<()> {
        self.records.retain(|input, _| is_input(input));
        match self.lines {
            Some(_) => write(&self.path, &self.records),
            None => Ok(()),
        }
    }
}

/// The manifests of shards in `folder`, sorted.
fn shards(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut parts = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let shard = name.strip_prefix(START).and_then(|rest| rest.strip_suffix(EXTENSION));
        if shard.is_some_and(|shard| Shard::of_name(shard.trim_matches('.')).is_some()) {
            parts.push(path);
        }
    }
    parts.sort_unstable();
    Ok(parts)
}

/// The outputs in the manifests of `folder`; none if the manifests cannot be read.
pub(crate) fn outputs(folder: &Path) -> HashSet<String> {
    let mut records = BTreeMap::new();
    let whole = Manifest::path(folder, None);
    for path in shards(folder).unwrap_or_default().iter().chain([&whole]) {
        let _ = read(path, &mut records);
    }
    records.into_values().filter_map(|record| record.output).collect()
}

/// Merges the manifests in `folder`, and returns the records.
pub(crate) fn merge(folder: &Path) -> io::Result<Vec<Record>> {
    let whole = Manifest::path(folder, None);
    let parts = shards(folder)?;
    if parts.is_empty() && !whole.exists() {
        return Err(io::Error::new(io::ErrorKind::NotFound, "the folder has no manifest"));
    }
    for manifest in parts.iter().chain([&whole]) {
        check_own(manifest)?;
    }
    let mut records = BTreeMap::new();
    read(&whole, &mut records)?;
    for part in &parts {
        read(part, &mut records)?;
    }
    write(&whole, &records)?;
    for part in &parts {
        fs::remove_file(part)?;
    }
    Ok(records.into_values().collect())
}

/// Refuses to replace a file that has the name of a manifest, but is not one.
fn check_own(path: &Path) -> io::Result<()> {
    /// The start of every record, even of a record that a killed run has not finished.
    const START_OF_RECORD: &[u8] = b"{\"input\":";
    lines::check_start(path, START_OF_RECORD, || not_a_manifest(path))
}

fn not_a_manifest(path: &Path) -> io::Error {
    let name = path.file_name().unwrap_or_default().display();
    let message = format!("{name} is not a manifest of mocap; move it, or name another folder");
    io::Error::new(io::ErrorKind::AlreadyExists, message)
}

/// Reads the complete lines of a manifest; without a file there are none.
fn read(path: &Path, records: &mut BTreeMap<String, Record>) -> io::Result<()> {
    let Some(mut file) = lines::open(path, || not_a_manifest(path))? else {
        return Ok(());
    };
    let mut text = Vec::new();
    file.read_to_end(&mut text)?;
    // Other lines come from a killed run or another version. Their files are converted again.
    let text = String::from_utf8_lossy(&text);
    let whole = text
        .split('\n')
        .filter_map(|line| serde_json::from_str::<Record>(line).ok());
    records.extend(whole.map(|record| (record.input.clone(), record)));
    Ok(())
}

fn write(path: &Path, records: &BTreeMap<String, Record>) -> io::Result<()> {
    let text = records.values().map(line).collect::<io::Result<String>>()?;
    write_file(path, text.as_bytes()).map_err(io::Error::other)
}

fn line(record: &Record) -> io::Result<String> {
    Ok(report::visible_json(&serde_json::to_string(record)?).into_owned() + "\n")
}
