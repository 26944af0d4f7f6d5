//! `mocap-manifest.jsonl`: the result of every file, as one line of JSON.
//!
//! During a run, a line is appended after every file, so that a killed run can be continued. At the end the file is
//! written again, sorted by input. The run of a shard has its own manifest, and `mocap merge-manifest` merges them.

use std::collections::{BTreeMap, HashSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use mocap::files::write_file;
use mocap::robot::RobotReport;
use mocap::scene::Assumption;
use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use super::inputs::Input;
use super::shard::Shard;
use crate::report;

/// The result of one file.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Its path below the folder it was found by.
    pub(crate) input: String,
    /// The SHA-256 of its bytes, as `sha256sum` prints it; absent where it could not be read.
    pub(crate) sha256: Option<String>,
    /// Its size.
    pub(crate) bytes: u64,
    /// The path of the output below the output folder; absent if nothing was written.
    pub(crate) output: Option<String>,
    /// The SHA-256 of the output, if its contents do not tell which program wrote it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) output_sha256: Option<String>,
    /// The program's version and options: everything except the input that the output depends on.
    pub(crate) version: String,
    pub(crate) options: String,
    /// The warnings, each as one line of text.
    pub(crate) warnings: Vec<String>,
    pub(crate) error: Option<String>,
    /// The largest distance of a joint from its position, in metres, for a compressed output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) max_error: Option<f64>,
    /// A hash of the joints' names, parents and OFFSETs, by which clips of one skeleton are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) skeleton: Option<String>,
    /// A hash of the unit, the up axis, the map and the T-pose that it shares with others of its skeleton.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) shared_figure: Option<String>,
    /// The unit and the up axis, where they were guessed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) guesses: Vec<Assumption>,
    /// How well the motion sits on the robot: a [`RobotReport`] as text, so that its numbers stay as they are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) robot: Option<Box<RawValue>>,
    /// How well each clip sits on the character: a list of [`RetargetReport`](mocap::retarget::RetargetReport) as text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) retarget: Option<Box<RawValue>>,
    /// What each step changed: a list of [`EditReport`](mocap::edit::EditReport) as text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) edit: Option<Box<RawValue>>,
    /// The duration of the work.
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
            output_sha256: None,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            options: options.to_owned(),
            warnings: Vec::new(),
            error: None,
            max_error: None,
            skeleton: None,
            shared_figure: None,
            guesses: Vec::new(),
            robot: None,
            retarget: None,
            edit: None,
            seconds: 0.0,
        }
    }

    /// How well the motion sits on the robot; `None` too where another version wrote it, with other fields.
    pub(crate) fn robot_report(&self) -> Option<RobotReport> {
        serde_json::from_str(self.robot.as_ref()?.get()).ok()
    }
}

const START: &str = "mocap-manifest";
const EXTENSION: &str = "jsonl";

/// The manifest of a run into a folder.
pub(crate) struct Manifest {
    path: PathBuf,
    /// Absent where nothing is to be written.
    file: Option<File>,
    /// Length of the file.
    bytes: u64,
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

    /// Opens the manifest in `folder` with the records of former runs for the inputs that `is_kept` accepts; empty if
    /// `is_kept` is absent.
    pub(crate) fn open(
        folder: &Path,
        shard: Option<Shard>,
        is_kept: Option<&dyn Fn(&str) -> bool>,
    ) -> io::Result<Self> {
        let mut manifest = Self::unwritten(folder, shard, is_kept)?;
        // A partial line of a killed run must not become the start of the next line.
        write(&manifest.path, &manifest.records)?;
        let file = OpenOptions::new().append(true).open(&manifest.path)?;
        manifest.bytes = file.metadata()?.len();
        manifest.file = Some(file);
        Ok(manifest)
    }

    /// As [`open`](Self::open), of a run that writes nothing.
    pub(crate) fn unwritten(
        folder: &Path,
        shard: Option<Shard>,
        is_kept: Option<&dyn Fn(&str) -> bool>,
    ) -> io::Result<Self> {
        let (whole, path) = (Self::path(folder, None), Self::path(folder, shard));
        let mut records = BTreeMap::new();
        if let Some(is_kept) = is_kept {
            // A shard may have been merged since it ran.
            read(&whole, &mut records)?;
            if path != whole {
                read(&path, &mut records)?;
            }
            records.retain(|input, _| is_kept(input));
        }
        Ok(Self {
            path,
            file: None,
            bytes: 0,
            records,
        })
    }

    /// The records so far, by input.
    pub(crate) fn records(&self) -> &BTreeMap<String, Record> {
        &self.records
    }

    /// Appends the result of a file.
    pub(crate) fn add(&mut self, record: Record) -> io::Result<()> {
        let line = line(&record)?;
        if let Some(file) = &mut self.file
            && let Err(error) = file.write_all(line.as_bytes())
        {
            // Remove the part of a line.
            let _ = file.set_len(self.bytes);
            return Err(error);
        }
        self.bytes += line.len() as u64;
        self.records.insert(record.input.clone(), record);
        Ok(())
    }

    /// Sorts the lines, and drops those that a later run has replaced and those for which `is_input` is false.
    pub(crate) fn finish(mut self, is_input: impl Fn(&str) -> bool) -> io::Result<()> {
        self.records.retain(|input, _| is_input(input));
        match self.file {
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
    parts.sort();
    Ok(parts)
}

/// The outputs that the manifests in `folder` name; none if they cannot be read.
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

/// Reads the complete lines of a manifest; without a file there are none.
fn read(path: &Path, records: &mut BTreeMap<String, Record>) -> io::Result<()> {
    let text = match fs::read(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
    };
    // Other lines come from a killed run or another version; their files are converted again.
    let lines = text.split(|&byte| byte == b'\n');
    let whole = lines.filter_map(|line| serde_json::from_slice::<Record>(line).ok());
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
