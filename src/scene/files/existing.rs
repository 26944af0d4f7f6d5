//! The rules for replacing files.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;

use super::array_mark::{MARKED_EXTENSIONS, has_mark};
use super::csv_table::{CSV_HEAD, is_csv_of_points, is_own_csv};
use super::fbx_header::{FBX_HEAD, HEADER, PROVENANCE, fbx_provenance};
use super::file_id::FileId;
use super::record::{self, RecordState};
use super::usd_header::{USD_HEAD, USD_HEADER, ZIP_HEAD, usd_provenance};
use super::{FilePart, Target, check_confined, folder_of, own, unfinished_target};
use crate::error::{Code, Diagnostic, Error, Result};
use crate::scene::Format;

/// Extensions of files that state who wrote them: glTF, FBX and USD.
const TELLING_EXTENSIONS: &[&str] = &["glb", "gltf", "vrm", "vrma", "fbx", "usda", "usdz"];

/// Extensions of files that may be a user's source, in addition to the formats: characters, USD that cannot be read,
/// databases.
const OTHER_SOURCES: &[&str] = &["vrm", "usdc", "usd", "mdb"];

/// The files that an output may replace.
///
/// An input is never replaced, not even through a link. Another existing file may be a user's, and is replaced only
/// with [`force`](Self::force). The following exceptions let you run a command again:
///
/// - An empty file, and a file whose bytes are the first bytes of the output, or all of them.
/// - An `.npz`, `.pkl`, `.mdb`, `.mot`, `.sto` or `.parquet` with this crate's mark, and a `.csv` of this crate.
/// - A file that the record of outputs knows, if the program keeps a record (`mocap::job::remember_outputs`). A file
///   with the extension of a format ([`is_source`](Self::is_source)) must also be made from inputs of this call.
/// - Without a record: a file without the extension of a format, such as a picture, and a `.csv` that is not a table of
///   points.
/// - A glTF, FBX or USD file that this crate wrote, according to its `Provenance`. If an input has one of these
///   formats, the file must also name an input as its source. Without this rule, a shell that expands `*.glb` to two
///   files would make the second file an output. A character file to which this crate added animations names the inputs
///   in `extras.mocap`: one animation must name both its motion and the character.
///
/// The last three exceptions do not apply to a file that has changed since it was recorded.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::files::ReplacePolicy;
///
/// let walk = "fixtures/real/cmu_12_01_walk.bvh";
/// let policy = ReplacePolicy::new([walk]);
/// let error = policy.check("fixtures/real/../real/cmu_12_01_walk.bvh".as_ref()).unwrap_err();
/// assert_eq!(error.code().as_str(), "output-is-input");
/// let error = policy.check("fixtures/real/cmu_short.bvh".as_ref()).unwrap_err();
/// assert_eq!(error.code().as_str(), "output-exists");
/// assert!(policy.check("fixtures/real/cmu_12_01_walk.glb".as_ref()).is_ok());
/// ```
#[derive(Clone, Debug, Default)]
pub struct ReplacePolicy {
    inputs: Arc<HashSet<FileId>>,
    /// Files that the caller declares as outputs.
    outputs: Arc<HashSet<FileId>>,
    /// The names of the inputs.
    source_names: Arc<HashSet<String>>,
    /// The inputs of the next output, if it is made from only some of the inputs.
    made_from: Option<Arc<HashSet<String>>>,
    /// Whether an input is glTF, FBX or USD.
    may_tell: bool,
    force: bool,
}

impl ReplacePolicy {
    /// Whether a file has the extension of a format, so that it may be a user's source.
    pub fn is_source(path: &Path) -> bool {
        let mut formats = Format::ALL.into_iter();
        formats.any(|format| has_extension(path, format.extensions())) || has_extension(path, OTHER_SOURCES)
    }

    /// A policy for outputs that are made from `inputs`. The buffers and images of a `.gltf` are inputs too. `-` is the
    /// file from which standard input reads, if it is a file.
    pub fn new(inputs: impl IntoIterator<Item = impl AsRef<Path>>) -> Self {
        let (mut files, mut names, mut may_tell) = (HashSet::new(), HashSet::new(), false);
        for input in inputs {
            let input = input.as_ref();
            let is_standard = input == Path::new("-");
            files.extend(if is_standard {
                FileId::of_standard_input()
            } else {
                FileId::of(input)
            });
            let name = input.file_name().map(|name| name.to_string_lossy().into_owned());
            names.extend(name);
            // Standard input has no name that shows its format.
            may_tell |= is_standard || has_extension(input, TELLING_EXTENSIONS);
            if has_extension(input, &["gltf"])
                && let Ok(asset) = Asset::of(input)
            {
                let beside = asset.buffers.iter().chain(&asset.images);
                for file in beside.filter_map(FileBeside::file_name) {
                    files.extend(FileId::of(&input.with_file_name(file)));
                }
            }
        }
        Self {
            inputs: Arc::new(files),
            outputs: Arc::default(),
            source_names: Arc::new(names),
            made_from: None,
            may_tell,
            force: false,
        }
    }

    /// Whether to replace files that may be a user's source. Inputs are never replaced. Default: no.
    #[must_use]
    pub fn force(mut self, force: bool) -> Self {
        self.force = force;
        self
    }

    /// Files to replace: outputs of a former run that are unchanged, according to the manifest of that run.
    #[doc(hidden)]
    #[must_use]
    pub fn outputs(mut self, outputs: impl IntoIterator<Item = impl AsRef<Path>>) -> Self {
        let outputs = outputs.into_iter().filter_map(|output| FileId::of(output.as_ref()));
        self.outputs = Arc::new(outputs.collect());
        self
    }

    /// Adds the name of an input that is in memory.
    #[doc(hidden)]
    #[must_use]
    pub fn source_name(mut self, name: &str) -> Self {
        Arc::make_mut(&mut self.source_names).insert(name.to_owned());
        self
    }

    /// The single input of the next output, for a call with many outputs.
    #[doc(hidden)]
    #[must_use]
    pub fn made_from(mut self, input: &Path) -> Self {
        let name = input.file_name().map(|name| name.to_string_lossy().into_owned());
        self.made_from = Some(Arc::new(name.into_iter().collect()));
        self
    }

    /// The input names that the record gets for an output; none if there are too many.
    pub(super) fn noted_sources(&self) -> Vec<&str> {
        /// The largest number of recorded input names. More names do not help to identify an output.
        const MOST: usize = 16;
        let names = self.made_from.as_ref().unwrap_or(&self.source_names);
        let mut names: Vec<&str> = names.iter().map(String::as_str).collect();
        names.sort_unstable();
        if names.len() > MOST {
            names.clear();
        }
        names
    }

    /// Whether this process wrote the file, or the caller declared it as an output.
    fn knows(&self, path: &Path) -> bool {
        let is_known = || FileId::of(path).is_some_and(|id| self.outputs.contains(&id));
        own::has_written(path) || !self.outputs.is_empty() && is_known()
    }

    /// Whether an output was made only from inputs of this call. Other outputs must not be replaced, for three reasons.
    /// If a shell expands `*.bvh` to two files, the second file is not meant as an output. A character file would lose
    /// its former motion. An output without inputs, such as a recording, cannot be made again.
    fn is_made_from_inputs(&self, sources: &[String]) -> bool {
        !sources.is_empty() && sources.iter().all(|name| self.source_names.contains(name))
    }

    /// Checks whether an output may go to `path`.
    ///
    /// # Errors
    /// [`Code::OutputIsInput`] and [`Code::OutputExists`].
    pub fn check(&self, path: &Path) -> Result<()> {
        self.check_or(path, || false)
    }

    /// Checks whether an output may go to `path`, before the output exists. Without a record of outputs, the answer
    /// depends on the bytes of the output, so this function checks only the inputs.
    ///
    /// # Errors
    /// The errors of [`Self::check`].
    #[doc(hidden)]
    pub fn check_ahead(&self, path: &Path) -> Result<()> {
        self.check_inputs(path)?;
        let may_be_cut_off = || record::find(path) == RecordState::Changed { is_shorter: true };
        match self.check(path) {
            Err(error) if record::is_complete() && !may_be_cut_off() => Err(error),
            _ => Ok(()),
        }
    }

    /// Checks whether an output with these bytes may go to `path`. The output may replace a file that is its own
    /// beginning, such as an incomplete output: no byte is lost, whoever wrote the file.
    ///
    /// # Errors
    /// The errors of [`Self::check`].
    pub fn check_bytes(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        self.check_parts(path, &[bytes.into()])
    }

    /// Like [`Self::check_bytes`], for bytes in several parts.
    pub(super) fn check_parts(&self, path: &Path, parts: &[FilePart<'_>]) -> Result<()> {
        self.check_or(path, || is_beginning(path, parts))
    }

    fn check_or(&self, path: &Path, is_same: impl FnOnce() -> bool) -> Result<()> {
        self.check_inputs(path)?;
        let found = fs::metadata(path);
        // Folders, pipes and devices are not replaced.
        if self.force || !found.is_ok_and(|found| found.is_file() && found.len() > 0) {
            return Ok(());
        }
        let recorded = record::find(path);
        let has_changed = matches!(recorded, RecordState::Changed { .. });
        let is_told = is_told(path) && !is_other_table(path);
        let is_ours = self.knows(path)
            || matches!(&recorded, RecordState::Unchanged(sources) if !is_told || self.is_made_from_inputs(sources))
            || !has_changed && !self.may_be_of_user(path, is_told);
        if is_ours {
            let sources = needs_record(path).then(|| self.noted_sources());
            record::may_replace(path, sources.as_deref());
            return Ok(());
        }
        if is_same() {
            return Ok(());
        }
        let message = match (has_changed, is_told) {
            (true, _) => "the file has changed since mocap wrote it",
            (false, true) => "the output would replace a file that mocap did not write from these inputs",
            (false, false) => "the output would replace a file that mocap did not write",
        };
        let diagnostic = Diagnostic::new(Code::OutputExists, message)
            .help("name another output (for several inputs a folder, with {output}), or replace the file with {force}");
        Err(Error::from(diagnostic).with_path(path))
    }

    /// Checks whether a companion file of an output, such as a texture, may go to `path`. It may go there if the path
    /// is free or has an earlier output, or if replacing is forced. Returns `false` if the file at `path` has the same
    /// bytes, even if it is an input. The output then refers to that file, and nothing is written. A buffer may replace
    /// the buffer of a former output, but two outputs never share a buffer.
    ///
    /// # Errors
    /// The errors of [`Self::check`].
    pub(super) fn check_beside(&self, path: &Path, parts: &[FilePart<'_>]) -> Result<bool> {
        if has_extension(path, &["bin"]) {
            return self.check_parts(path, parts).map(|()| true);
        }
        check_confined(path)?;
        if has_bytes(path, parts) {
            return Ok(false);
        }
        self.check_inputs(path)?;
        if path.symlink_metadata().is_err() || self.force || self.knows(path) || is_beginning(path, parts) {
            return Ok(true);
        }
        if let RecordState::Unchanged(sources) = record::find(path)
            && self.is_made_from_inputs(&sources)
        {
            return Ok(true);
        }
        let message = "a companion file of the output would replace another file with the same name";
        let diagnostic = Diagnostic::new(Code::OutputExists, message)
            .help("write into another folder, or replace the file with {force}");
        Err(Error::from(diagnostic).with_path(path))
    }

    /// Checks that `path` is not an input. In a [confined](super::confine) process, also checks that the file at `path`
    /// is not another user's.
    ///
    /// # Errors
    /// [`Code::OutputIsInput`] and [`Code::OutputExists`].
    pub fn check_inputs(&self, path: &Path) -> Result<()> {
        check_confined(path)?;
        if own::is_of_others(path) {
            let diagnostic = Diagnostic::new(Code::OutputExists, own::OF_OTHERS).help("name another output");
            return Err(Error::from(diagnostic).with_path(path));
        }
        if FileId::of(path).is_none_or(|id| !self.inputs.contains(&id)) {
            return Ok(());
        }
        let diagnostic = Diagnostic::new(Code::OutputIsInput, "the output would replace one of the inputs")
            .help("name another output");
        Err(Error::from(diagnostic).with_path(path))
    }

    /// Whether the non-empty file at `path`, which the record does not know, may be a user's own file. `is_told` means
    /// that the extension belongs to a format. Other files, such as pictures and pages, do not state who wrote them.
    fn may_be_of_user(&self, path: &Path, is_told: bool) -> bool {
        if !is_told {
            return record::is_complete() && !is_own_table(path);
        }
        // A link and its target may have different extensions.
        let target = match Target::of(path) {
            Ok(Target::File(target)) => target,
            _ => path.to_owned(),
        };
        if has_extension(path, &["bin"]) || has_extension(&target, &["bin"]) {
            return !is_our_buffer(&target);
        }
        if has_extension(&target, MARKED_EXTENSIONS) && has_mark(&target) {
            return false;
        }
        if has_extension(&target, &["csv"]) {
            return !is_own_table(&target);
        }
        (Self::is_source(path) || Self::is_source(&target))
            && !Asset::of(&target).is_ok_and(|asset| self.is_output(&asset))
    }

    fn is_output(&self, asset: &Asset) -> bool {
        let is_input = |name: Option<&str>| name.is_some_and(|name| self.source_names.contains(name));
        let is_added = |animation: &Extras| {
            let names = [animation.source_name(), animation.character_name()];
            animation.is_ours() && names.into_iter().all(is_input)
        };
        let is_whole = asset.asset.is_ours() && (!self.may_tell || is_input(asset.asset.source_name()));
        is_whole || asset.animations.iter().any(is_added)
    }
}

/// Whether the file at `path` states that it is a glTF, FBX or USD file that this crate wrote, or to which this crate
/// added animations.
pub fn has_provenance(path: &Path) -> bool {
    let is_ours = |asset: Asset| asset.asset.is_ours() || asset.animations.iter().any(Extras::is_ours);
    has_extension(path, TELLING_EXTENSIONS) && Asset::of(path).is_ok_and(is_ours)
}

/// Whether the file name has an extension of a format. Files of formats can state who wrote them; pictures and pages
/// cannot.
fn is_told(path: &Path) -> bool {
    has_extension(path, &["bin"]) || ReplacePolicy::is_source(path)
}

/// Whether a file with this name may be a motion or a character without a mark.
pub(super) fn may_be_motion(path: &Path) -> bool {
    is_told(path) && needs_record(path)
}

/// Whether only the record can identify an output with this name. Other files have a mark.
pub(super) fn needs_record(path: &Path) -> bool {
    !has_extension(path, MARKED_EXTENSIONS)
}

/// Whether `path` is the buffer of a `.gltf` file of this crate in the same folder.
fn is_our_buffer(path: &Path) -> bool {
    let is_buffer_of = |asset: &Asset| {
        let mut names = asset.buffers.iter().filter_map(FileBeside::file_name);
        // Animations in a character file never have their own buffer.
        let is_ours = asset.asset.is_ours() || asset.animations.iter().any(Extras::is_ours);
        is_ours && names.any(|name| path.ends_with(name))
    };
    let text = path.with_extension("gltf");
    // A process may have been killed after it wrote the buffer. Then the `.gltf` has a temporary name.
    let unfinished = fs::read_dir(folder_of(path)).into_iter().flatten().flatten();
    let unfinished = unfinished.map(|entry| entry.path());
    let unfinished =
        unfinished.filter(|left| unfinished_target(left).is_some_and(|left| left.file_name() == text.file_name()));
    std::iter::once(text.clone())
        .chain(unfinished)
        .any(|text| Asset::of(&text).is_ok_and(|asset| is_buffer_of(&asset)))
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().unwrap_or_default();
    extensions.iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// The first bytes of a file with the extension `.csv`; `None` for other files.
fn csv_head(path: &Path) -> Option<Vec<u8>> {
    let mut head = Vec::new();
    let file = File::open(path).ok().filter(|_| has_extension(path, &["csv"]))?;
    file.take(CSV_HEAD as u64).read_to_end(&mut head).ok()?;
    Some(head)
}

/// Whether the file is a table that states that this crate wrote it.
fn is_own_table(path: &Path) -> bool {
    csv_head(path).is_some_and(|head| is_own_csv(&head))
}

/// Whether the file is a table without points, so that it is no motion.
fn is_other_table(path: &Path) -> bool {
    csv_head(path).is_some_and(|head| !is_own_csv(&head) && !is_csv_of_points(&head))
}

fn has_bytes(path: &Path, parts: &[FilePart<'_>]) -> bool {
    let length: usize = parts.iter().map(FilePart::len).sum();
    fs::metadata(path).is_ok_and(|found| found.len() == length as u64) && is_beginning(path, parts)
}

/// Whether the output begins with all bytes of the file.
fn is_beginning(path: &Path, parts: &[FilePart<'_>]) -> bool {
    let has_bytes = || -> io::Result<bool> {
        let mut file = BufReader::with_capacity(1 << 16, File::open(path)?);
        for part in parts {
            let mut rest = &*part.bytes();
            while !rest.is_empty() {
                let block = file.fill_buf()?;
                if block.is_empty() {
                    return Ok(true);
                }
                let length = block.len().min(rest.len());
                if block[..length] != rest[..length] {
                    return Ok(false);
                }
                file.consume(length);
                rest = &rest[length..];
            }
        }
        Ok(file.fill_buf()?.is_empty())
    };
    fs::metadata(path).is_ok_and(|found| found.is_file()) && has_bytes().unwrap_or(false)
}

/// The entries of a glTF, FBX or USD file that state its writer. The reader of the format is not used, because errors
/// in the rest of the file do not matter here.
#[derive(Default, Deserialize)]
struct Asset {
    asset: Extras,
    #[serde(default)]
    animations: Vec<Extras>,
    #[serde(default)]
    buffers: Vec<FileBeside>,
    #[serde(default)]
    images: Vec<FileBeside>,
}

#[derive(Default, Deserialize)]
struct Extras {
    extras: Option<serde_json::Map<String, serde_json::Value>>,
}

/// A buffer or an image of a glTF file.
#[derive(Deserialize)]
struct FileBeside {
    uri: Option<String>,
}

impl FileBeside {
    /// The file with the bytes, relative to the folder of the glTF file.
    fn file_name(&self) -> Option<PathBuf> {
        let uri = self.uri.as_deref().filter(|uri| !uri.starts_with("data:"))?;
        Some(PathBuf::from(percent_decoded(uri)))
    }
}

impl Asset {
    fn of(path: &Path) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(path)?);
        let mut header = [0; 20];
        file.read_exact(&mut header)?;
        let is_usd = header.starts_with(USD_HEAD) || header.starts_with(ZIP_HEAD);
        if is_usd || header.starts_with(FBX_HEAD) {
            let mut bytes = header.to_vec();
            file.take(HEADER.max(USD_HEADER) as u64).read_to_end(&mut bytes)?;
            let json = match is_usd {
                true => usd_provenance(&bytes),
                false => fbx_provenance(&bytes).map(str::to_owned),
            };
            return Ok(Self::of_provenance(json.as_deref()));
        }
        let asset = if header.starts_with(b"glTF") {
            let length = u32::from_le_bytes([header[12], header[13], header[14], header[15]]);
            serde_json::from_reader(file.take(length.into()))
        } else {
            serde_json::from_reader(header.chain(file))
        };
        Ok(asset?)
    }

    fn of_provenance(json: Option<&str>) -> Self {
        let provenance = json.and_then(|json| serde_json::from_str(json).ok());
        let extras = provenance.map(|provenance| {
            let mut extras = serde_json::Map::new();
            extras.insert(PROVENANCE.to_owned(), provenance);
            extras
        });
        Self {
            asset: Extras { extras },
            ..Self::default()
        }
    }
}

impl Extras {
    fn provenance(&self) -> Option<&serde_json::Value> {
        self.extras.as_ref()?.get(PROVENANCE)
    }

    fn is_ours(&self) -> bool {
        self.provenance()
            .is_some_and(|provenance| provenance.get("version").is_some())
    }

    fn source_name(&self) -> Option<&str> {
        self.provenance()?.get("source")?.get("name")?.as_str()
    }

    /// The file with the skeleton to which the motion was retargeted.
    fn character_name(&self) -> Option<&str> {
        let steps = self.provenance()?.get("steps")?.as_array()?;
        let onto = steps.iter().rev().find_map(|step| step.get("onto"))?;
        onto.get("source")?.get("name")?.as_str()
    }
}

/// Decodes a relative URI: `%` and two hexadecimal digits stand for a byte.
#[doc(hidden)]
pub fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        let digits = after
            .get(..2)
            .filter(|_| byte == b'%')
            .and_then(|digits| std::str::from_utf8(digits).ok());
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(decoded) => {
                bytes.push(decoded);
                rest = &after[2..];
            }
            None => {
                bytes.push(byte);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
