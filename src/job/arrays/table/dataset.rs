//! A dataset for the library `datasets` of Hugging Face: a folder with Parquet files and a card.
//!
//! | file | contents |
//! |---|---|
//! | `data/train-00000-of-00002.parquet` | rows of [`clips`](super::clips) or [`Arrays::to_table`], without `error` |
//! | `README.md` | the card: metadata as YAML, columns with units, statistics, sources and licences |
//! | `licenses/` | the licence files in the folders of the clips |
//!
//! The layout follows <https://huggingface.co/docs/hub/datasets-manual-configuration> and
//! <https://huggingface.co/docs/hub/datasets-cards>.

mod card;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;
use arrow_schema::{ArrowError, SchemaRef};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::{ReplacePolicy, check_confined, check_folder, copy_file, persist_folder, write_file};
use mocap_scene::scene::UpAxis;
use mocap_scene::scene::report::Attribution;

use super::{skeleton_hash, to_parquet};
use crate::arrays::{ArrayOptions, Arrays};

/// The data of a clip for the card.
#[derive(Clone, Debug)]
pub struct DatasetClip {
    /// The path relative to the searched folder, with `/` as separator.
    pub name: String,
    skeleton: String,
    joints: usize,
    frames: usize,
    frame_rate: f64,
    attribution: Attribution,
}

impl DatasetClip {
    /// The card data of these arrays.
    pub fn new(name: &str, motion: &Arrays) -> Self {
        Self {
            name: name.to_owned(),
            skeleton: skeleton_hash(motion.joints()),
            joints: motion.joints().len(),
            frames: motion.frames,
            frame_rate: motion.frame_rate(),
            attribution: Attribution::default(),
        }
    }

    /// The card data with the licence, the source and the person that the file or a `mocap.toml` states:
    /// [`Metadata::attribution`](mocap_scene::scene::Metadata::attribution).
    #[must_use]
    pub fn attributed(mut self, attribution: &Attribution) -> Self {
        self.attribution = attribution.clone();
        self
    }

    fn seconds(&self) -> f64 {
        match self.frame_rate > 0.0 {
            true => self.frames as f64 / self.frame_rate,
            false => 0.0,
        }
    }

    /// The source folder: the first part of the clip's name.
    fn source(&self) -> &str {
        self.name.split_once('/').map_or("", |(source, _)| source)
    }
}

/// Writes a dataset to a temporary folder, and renames the folder in [`finish`](Self::finish). A writer that is dropped
/// before `finish` leaves no file.
pub struct DatasetWriter {
    folder: PathBuf,
    unfinished: PathBuf,
    policy: ReplacePolicy,
    options: ArrayOptions,
    license: Option<String>,
    schema: Option<SchemaRef>,
    shards: usize,
    rows: usize,
    /// The size of the tables in memory, in bytes.
    bytes: usize,
    file_bytes: usize,
    clips: Vec<DatasetClip>,
    failed: BTreeMap<String, String>,
    /// Folders in which licence files were looked for.
    seen: BTreeSet<PathBuf>,
    /// For each folder of clips, the names of its licence files in the dataset.
    licenses: BTreeMap<String, BTreeSet<String>>,
}

impl DatasetWriter {
    /// Options for the arrays of a dataset: all clips share one unit and one up axis, by default metres and +Y.
    pub fn options(options: ArrayOptions) -> ArrayOptions {
        let (metres_per_unit, up) = (options.out_metres_per_unit, options.out_up);
        options
            .out_metres_per_unit(metres_per_unit.or(Some(1.0)))
            .out_up(up.or(Some(UpAxis::Y)))
    }

    /// Begins a dataset of the arrays of `inputs` with `options`. `license` is the identifier of the licence of all
    /// clips.
    ///
    /// # Errors
    /// [`Code::OutputExists`] if `folder` is a file or has files, unless the record of outputs lists all its files as
    /// an earlier dataset. [`Code::OutputIsInput`] if one of its files is an input. [`Code::InvalidValue`] if `license`
    /// is not an identifier. [`Code::Io`] if the folder cannot be created.
    pub fn create(
        folder: &Path,
        inputs: impl IntoIterator<Item = impl AsRef<Path>>,
        options: &ArrayOptions,
        license: Option<&str>,
    ) -> Result<Self> {
        check_confined(folder)?;
        if let Some(license) = license {
            check_license(license)?;
        }
        let policy = ReplacePolicy::new(inputs);
        check_folder(folder, &policy)?;
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let parent = folder.parent().filter(|parent| !parent.as_os_str().is_empty());
        let parent = parent.unwrap_or(Path::new("."));
        let unfinished = parent.join(format!(".{name}.{}.unfinished", std::process::id()));
        let made = fs::create_dir_all(parent).and_then(|()| fs::create_dir(&unfinished));
        made.map_err(|error| Error::io(folder, error))?;
        let writer = Self {
            folder: folder.to_owned(),
            unfinished,
            policy,
            options: options.clone(),
            license: license.map(str::to_owned),
            schema: None,
            shards: 0,
            rows: 0,
            bytes: 0,
            file_bytes: 0,
            clips: Vec::new(),
            failed: BTreeMap::new(),
            seen: BTreeSet::new(),
            licenses: BTreeMap::new(),
        };
        let data = writer.unfinished.join("data");
        fs::create_dir(data).map_err(|error| Error::io(folder, error))?;
        Ok(writer)
    }

    /// Adds a clip to the card. Its licence files are in the folder of `path`, and in the parent folders that are part
    /// of the clip's name.
    ///
    /// # Errors
    /// [`Code::Io`] if a licence file cannot be copied.
    pub fn add(&mut self, clip: DatasetClip, path: &Path) -> Result<()> {
        let parts: Vec<&str> = clip.name.split('/').collect();
        let mut folder = path.parent();
        for depth in (0..parts.len()).rev() {
            let Some(found) = folder else { break };
            // The folder of a file name without a folder is the current folder.
            let found = if found.as_os_str().is_empty() {
                Path::new(".")
            } else {
                found
            };
            self.copy_licenses(found, &parts[..depth].join("/"))?;
            folder = folder.and_then(Path::parent);
        }
        self.clips.push(clip);
        Ok(())
    }

    /// Lists an unreadable file on the card.
    pub fn leave_out(&mut self, clip: &str, error: &str) {
        self.failed.insert(clip.to_owned(), error.to_owned());
    }

    fn copy_licenses(&mut self, folder: &Path, below: &str) -> Result<()> {
        if !self.seen.insert(folder.to_owned()) {
            return Ok(());
        }
        // A folder that cannot be listed gives no licence files. The files in such a folder can be read nevertheless.
        for entry in folder.read_dir().into_iter().flatten().flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            if !is_license(&name) || !entry.file_type().is_ok_and(|kind| kind.is_file()) {
                continue;
            }
            let parts = ["licenses", below, &name];
            let target = parts.map(str::to_owned).into_iter().filter(|part| !part.is_empty());
            let target = target.collect::<Vec<_>>().join("/");
            // Two input folders may each have a licence file.
            let numbered = (2..).map(|number| format!("{target}.{number}"));
            let is_free = |target: &String| !self.unfinished.join(target).exists();
            let target = std::iter::once(target.clone()).chain(numbered).find(is_free);
            let target = target.unwrap_or_default();
            let path = self.unfinished.join(&target);
            let made = path.parent().map_or(Ok(()), fs::create_dir_all);
            made.map_err(|error| Error::io(&self.folder, error))?;
            copy_file(&entry.path(), &path)?;
            self.licenses.entry(below.to_owned()).or_default().insert(target);
        }
        Ok(())
    }

    /// Writes tables with the same columns as one Parquet file.
    ///
    /// # Errors
    /// [`Code::Unrepresentable`] if Parquet cannot hold the tables, [`Code::Io`] if the file cannot be written.
    pub fn write_shard(&mut self, tables: impl IntoIterator<Item = RecordBatch>) -> Result<()> {
        let (mut rows, mut bytes, mut schema) = (0, 0, None);
        let tables = tables.into_iter().map(|table| {
            let table = without_errors(&table).unwrap_or(table);
            rows += table.num_rows();
            bytes += table.get_array_memory_size();
            schema.get_or_insert_with(|| table.schema());
            table
        });
        let file = to_parquet(tables)?;
        let path = self.unfinished.join("data").join(format!("{:05}", self.shards));
        write_file(&path, &file)?;
        self.schema = self.schema.take().or(schema);
        self.rows += rows;
        self.bytes += bytes;
        self.file_bytes += file.len();
        self.shards += 1;
        Ok(())
    }

    /// Renames the Parquet files, writes the card, and renames the folder. Returns the number of Parquet files.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if no clip was added, [`Code::OutputExists`] if files appeared in the folder in the
    /// meantime, [`Code::Io`] if the folder cannot be written.
    pub fn finish(self) -> Result<usize> {
        if self.shards == 0 {
            let diagnostic = Diagnostic::new(Code::InvalidValue, "no clip could be read, so there is no dataset");
            return Err(Error::from(diagnostic).with_path(&self.folder));
        }
        let in_folder = |error| Error::io(&self.folder, error);
        let data = self.unfinished.join("data");
        for shard in 0..self.shards {
            let name = format!("train-{shard:05}-of-{:05}.parquet", self.shards);
            fs::rename(data.join(format!("{shard:05}")), data.join(name)).map_err(in_folder)?;
        }
        write_file(&self.unfinished.join("README.md"), card::text(&self).as_bytes())?;
        persist_folder(&self.unfinished, &self.folder, &self.policy)?;
        Ok(self.shards)
    }
}

impl Drop for DatasetWriter {
    fn drop(&mut self) {
        // After `finish`, the folder no longer exists.
        let _ = fs::remove_dir_all(&self.unfinished);
    }
}

/// A table without the column `error`, which is empty in a dataset.
fn without_errors(table: &RecordBatch) -> Result<RecordBatch, ArrowError> {
    let fields = table.schema();
    let kept = (0..table.num_columns()).filter(|column| fields.field(*column).name() != "error");
    table.project(&kept.collect::<Vec<_>>())
}

/// Licence identifiers of Hugging Face are SPDX identifiers in lower case, and a few others.
fn check_license(license: &str) -> Result<()> {
    let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || ".-+".contains(c);
    if !license.is_empty() && license.chars().all(is_part) {
        return Ok(());
    }
    let diagnostic = Diagnostic::new(Code::InvalidValue, "{license} is not an identifier of a licence")
        .expected_found("small letters, digits, . - and +", format!("{license:?}"))
        .help("use an identifier of Hugging Face, such as cc-by-4.0, cc0-1.0 or other");
    Err(diagnostic.into())
}

impl DatasetWriter {
    /// The identifier of the licence: from the caller, otherwise the licence that all clips state. It is `other` if the
    /// clips state several licences, or a licence that is not an identifier.
    fn license(&self) -> Option<String> {
        if self.license.is_some() {
            return self.license.clone();
        }
        let stated = self.clips.iter().map(|clip| clip.attribution.licence.as_deref());
        let stated: BTreeSet<Option<String>> = stated.map(|licence| Some(licence?.to_lowercase())).collect();
        let mut stated = stated.into_iter();
        match (stated.next().flatten(), stated.next()) {
            (Some(only), None) if check_license(&only).is_ok() => Some(only),
            (None, None) => None,
            _ => Some("other".to_owned()),
        }
    }
}

/// Whether a file of this name holds a licence, or a notice that a licence requires.
fn is_license(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let stem = name.split(['.', '-', '_']).next().unwrap_or_default();
    [
        "license",
        "licence",
        "licenses",
        "copying",
        "copyright",
        "notice",
        "attribution",
    ]
    .contains(&stem)
}
