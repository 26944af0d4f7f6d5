//! `mocap-manifest.jsonl`: what became of every file, a line of JSON each.
//!
//! While a run goes on, lines are appended as files are done, so that a run that was killed knows how far it came. At
//! its end the file is written anew, sorted by input. A run of one shard has a manifest of its own, and `mocap
//! merge-manifest` makes one of all.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use mocap::export::write_file;
use serde::{Deserialize, Serialize};

use super::inputs::Input;
use super::shard::Shard;

/// What became of one file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Its path below the folder it was found by.
    pub(crate) input: String,
    /// The SHA-256 of its bytes, as `sha256sum` prints it; absent where it could not be read.
    pub(crate) sha256: Option<String>,
    /// Its size.
    pub(crate) bytes: u64,
    /// What was written, below the output folder; absent where nothing was.
    pub(crate) output: Option<String>,
    /// The program's version and the options it ran with: all that an output depends on beside the input.
    pub(crate) version: String,
    pub(crate) options: String,
    /// The warnings, each as one line of text.
    pub(crate) warnings: Vec<String>,
    pub(crate) error: Option<String>,
    /// The largest distance of a joint from its place, in metres, where the output is within a bound.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) max_error: Option<f64>,
    /// How long it took.
    pub(crate) seconds: f64,
}

impl Record {
    /// What is known of a file before anything is done with it.
    pub(crate) fn new(input: &Input, options: &str) -> Self {
        Self {
            input: input.relative.clone(),
            sha256: None,
            bytes: input.bytes,
            output: None,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            options: options.to_owned(),
            warnings: Vec::new(),
            error: None,
            max_error: None,
            seconds: 0.0,
        }
    }
}

const START: &str = "mocap-manifest";
const EXTENSION: &str = "jsonl";

/// The manifest of a run into a folder.
pub(crate) struct Manifest {
    path: PathBuf,
    file: File,
    records: BTreeMap<String, Record>,
}

impl Manifest {
    /// Where the manifest of a run stands.
    pub(crate) fn path(folder: &Path, shard: Option<Shard>) -> PathBuf {
        folder.join(match shard {
            Some(shard) => format!("{START}.{}.{EXTENSION}", shard.name()),
            None => format!("{START}.{EXTENSION}"),
        })
    }

    /// Begins a manifest in `folder`: empty, or with what former runs have left there.
    pub(crate) fn open(folder: &Path, shard: Option<Shard>, resume: bool) -> io::Result<Self> {
        let (whole, path) = (Self::path(folder, None), Self::path(folder, shard));
        let mut records = BTreeMap::new();
        if resume {
            // A shard may have been merged since it ran.
            read(&whole, &mut records)?;
            if path != whole {
                read(&path, &mut records)?;
            }
        }
        // The end of a line that a killed run has left must not become the start of the next.
        write(&path, &records)?;
        let file = OpenOptions::new().append(true).open(&path)?;
        Ok(Self { path, file, records })
    }

    /// The records so far, by input.
    pub(crate) fn records(&self) -> &BTreeMap<String, Record> {
        &self.records
    }

    /// Notes what became of a file, at once.
    pub(crate) fn add(&mut self, record: Record) -> io::Result<()> {
        self.file.write_all(line(&record)?.as_bytes())?;
        self.records.insert(record.input.clone(), record);
        Ok(())
    }

    /// Sorts the lines, and drops those that a later run has replaced or whose input `is_input` no longer knows.
    pub(crate) fn finish(mut self, is_input: impl Fn(&str) -> bool) -> io::Result<()> {
        self.records.retain(|input, _| is_input(input));
        write(&self.path, &self.records)
    }
}

/// Makes one manifest of all in `folder`, and gives its records.
pub(crate) fn merge(folder: &Path) -> io::Result<Vec<Record>> {
    let whole = Manifest::path(folder, None);
    let mut parts = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_manifest = name.starts_with(START) && path.extension().is_some_and(|found| found == EXTENSION);
        if is_manifest && path != whole {
            parts.push(path);
        }
    }
    parts.sort();
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

/// Reads what is whole in a manifest; one that is not there has nothing.
fn read(path: &Path, records: &mut BTreeMap<String, Record>) -> io::Result<()> {
    let text = match fs::read(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(error),
    };
    // A line that is no record is the last of a killed run, or of another version: its file is done again.
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
    Ok(serde_json::to_string(record)? + "\n")
}
