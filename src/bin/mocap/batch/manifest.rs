//! `mocap-manifest.jsonl`: the result of every file, as one line of JSON.
//!
//! During a run, a line is appended after every file, so that a killed run can be continued. At the end the file is
//! written again, sorted by input. The run of a shard has its own manifest, and `mocap merge-manifest` merges them.

use std::collections::BTreeMap;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use mocap::export::write_file;
use serde::{Deserialize, Serialize};

use super::inputs::Input;
use super::shard::Shard;

/// The result of one file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Its path below the folder it was found by.
    pub(crate) input: String,
    /// The SHA-256 of its bytes, as `sha256sum` prints it; absent where it could not be read.
    pub(crate) sha256: Option<String>,
    /// Its size.
    pub(crate) bytes: u64,
    /// The path of the output below the output folder; absent if nothing was written.
    pub(crate) output: Option<String>,
    /// The program's version and options: everything except the input that the output depends on.
    pub(crate) version: String,
    pub(crate) options: String,
    /// The warnings, each as one line of text.
    pub(crate) warnings: Vec<String>,
    pub(crate) error: Option<String>,
    /// The largest distance of a joint from its position, in metres, for a compressed output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) max_error: Option<f64>,
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
    /// The path of a run's manifest.
    pub(crate) fn path(folder: &Path, shard: Option<Shard>) -> PathBuf {
        folder.join(match shard {
            Some(shard) => format!("{START}.{}.{EXTENSION}", shard.name()),
            None => format!("{START}.{EXTENSION}"),
        })
    }

    /// Opens the manifest in `folder`: empty, or with the records of former runs.
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
        // A partial line of a killed run must not become the start of the next line.
        write(&path, &records)?;
        let file = OpenOptions::new().append(true).open(&path)?;
        Ok(Self { path, file, records })
    }

    /// The records so far, by input.
    pub(crate) fn records(&self) -> &BTreeMap<String, Record> {
        &self.records
    }

    /// Appends the result of a file.
    pub(crate) fn add(&mut self, record: Record) -> io::Result<()> {
        self.file.write_all(line(&record)?.as_bytes())?;
        self.records.insert(record.input.clone(), record);
        Ok(())
    }

    /// Sorts the lines, and drops those that a later run has replaced and those for which `is_input` is false.
    pub(crate) fn finish(mut self, is_input: impl Fn(&str) -> bool) -> io::Result<()> {
        self.records.retain(|input, _| is_input(input));
        write(&self.path, &self.records)
    }
}

/// Merges the manifests in `folder`, and returns the records.
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
    Ok(serde_json::to_string(record)? + "\n")
}
