//! The outputs of many files in a folder: their names, and permission to write them.

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use mocap::files::{FilePart, OutputSet, ReplacePolicy, has_provenance};
use mocap::{Code, Diagnostic, Error, Export, FormatInfo};

use super::inputs::Input;
use super::manifest::{self, OutputFile, Record};
use crate::Failure;

/// One of the outputs, for the thread that makes it.
pub(crate) struct Output<'a> {
    /// The path of the output, relative to the folder.
    pub(crate) name: &'a str,
    pub(crate) path: PathBuf,
    /// The file from which the output is made.
    pub(super) input: &'a Path,
    pub(super) policy: &'a ReplacePolicy,
    pub(super) folder: &'a Path,
    /// The record of this output in the manifest of a former run.
    pub(super) former: Option<&'a Record>,
    pub(super) claims: &'a Claims,
}

impl Output<'_> {
    /// Writes the files, unless one would replace an input, a file that may be a source, or another output of the run.
    /// Returns their entries for the manifest.
    pub(crate) fn save(&self, written: &Export) -> mocap::Result<Vec<OutputFile>> {
        let (set, policy, files) = self.checked(written)?;
        set.save(&policy)?;
        Ok(files)
    }

    /// Makes the checks of [`save`](Self::save), and writes nothing.
    pub(crate) fn check(&self, written: &Export) -> mocap::Result<()> {
        self.checked(written).map(drop)
    }

    /// Makes the checks that need no output.
    pub(crate) fn check_ahead(&self) -> mocap::Result<()> {
        self.allowed(|policy| policy.check_ahead(&self.path)).map(drop)
    }

    fn checked<'w>(&self, written: &'w Export) -> mocap::Result<(OutputSet<'w>, ReplacePolicy, Vec<OutputFile>)> {
        let set = written.output_set(&self.path)?;
        let policy = self.allowed(|policy| set.check(policy))?;
        let files = self.claims.take(&set)?;
        Ok((set, policy, files))
    }

    /// The replace policy under which `check` accepts the output. If `check` refuses it, the policy also accepts
    /// unchanged files of the former run's manifest.
    fn allowed(&self, check: impl Fn(&ReplacePolicy) -> mocap::Result<()>) -> mocap::Result<ReplacePolicy> {
        let policy = self.policy.clone().made_from(self.input);
        let Err(error) = check(&policy) else {
            return Ok(policy);
        };
        let former = self.former.ok_or(error)?;
        // Hashing takes time, so it is only done if a file does not name its writer.
        let unchanged = former.unchanged_files(self.folder);
        let policy = policy.outputs(&unchanged);
        check(&policy).map_err(|error| former_has_changed(former, &unchanged, error))?;
        Ok(policy)
    }
}

/// Adds the reason why a former output that is not among `unchanged` is not replaced.
fn former_has_changed(former: &Record, unchanged: &[PathBuf], error: Error) -> Error {
    let Some(path) = error.path().filter(|_| error.code() == Code::OutputExists) else {
        return error;
    };
    let is_of_former = former.files.iter().any(|file| path.ends_with(&file.name));
    if !is_of_former || unchanged.iter().any(|file| file == path) {
        return error;
    }
    let message = "the file was changed after an earlier run wrote it";
    let diagnostic = Diagnostic::new(Code::OutputExists, message).help("move it, or replace it with --force");
    Error::from(diagnostic).with_path(path)
}

/// The files of a run's outputs, with their SHA-256. Two outputs may share a file, such as a texture of one character,
/// if it has the same bytes for both.
#[derive(Default)]
pub(super) struct Claims(Mutex<BTreeMap<PathBuf, OutputFile>>);

impl Claims {
    /// Reserves the files of an output. Refuses a file that another output has with other bytes.
    fn take(&self, set: &OutputSet<'_>) -> mocap::Result<Vec<OutputFile>> {
        let file = |(path, parts): (&Path, &[FilePart<'_>])| (path.to_owned(), OutputFile::new(path, parts));
        let mut files: Vec<(PathBuf, OutputFile)> = set.files().map(file).collect();
        // Some file systems ignore case, so names are compared in lower case. The last file is excepted: its name comes
        // from the input.
        if let Some((_, beside)) = files.split_last_mut() {
            for (key, file) in beside {
                *key = key.with_file_name(file.name.to_lowercase());
            }
        }
        let mut claims = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_taken =
            |(key, file): &&(PathBuf, OutputFile)| claims.get(key).is_some_and(|it| it.sha256 != file.sha256);
        if let Some((key, file)) = files.iter().find(is_taken) {
            let message = "another output of this run needs a file with this name and other contents";
            let diagnostic = Diagnostic::new(Code::OutputExists, message)
                .help("write the two outputs into different folders, or embed the textures");
            return Err(Error::from(diagnostic).with_path(&key.with_file_name(&file.name)));
        }
        claims.extend(files.iter().cloned());
        Ok(files.into_iter().map(|(_, file)| file).collect())
    }

    pub(super) fn paths(&self) -> Vec<PathBuf> {
        let claims = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        claims
            .iter()
            .map(|(key, file)| key.with_file_name(&file.name))
            .collect()
    }
}

/// Which files are outputs of former runs, and therefore no inputs again.
pub(crate) struct KnownOutputs {
    /// The output folder of this run.
    folder: Option<PathBuf>,
    /// The folders in which files were found, and the folders that contain them.
    folders: RefCell<HashMap<PathBuf, FolderOutputs>>,
}

/// The outputs of former runs in a folder.
struct FolderOutputs {
    /// Whether this is the output folder of this run.
    is_own: bool,
    /// The outputs that the manifests of the folder list.
    listed: HashSet<String>,
}

impl KnownOutputs {
    pub(crate) fn of(folder: &Path) -> Self {
        Self {
            folder: folder.canonicalize().ok(),
            folders: RefCell::default(),
        }
    }

    /// Whether a file is an output of a former run: in the output folder of this run, in an output folder below `base`,
    /// or beside its source. `base` is the folder that the user named, and the file was found in it. If the user names
    /// the output folder of another run, its files are inputs.
    pub(crate) fn has(&self, base: &Path, path: &Path) -> bool {
        if !path.is_file() {
            return false;
        }
        let mut folders = self.folders.borrow_mut();
        for folder in path.ancestors().skip(1).take_while(|folder| folder.starts_with(base)) {
            let outputs = folders
                .entry(folder.to_owned())
                .or_insert_with(|| self.outputs_in(folder));
            if outputs.is_own || (folder != base && !outputs.listed.is_empty()) {
                let parts = path.strip_prefix(folder).unwrap_or(path).components();
                let parts: Vec<_> = parts.map(|part| part.as_os_str().to_string_lossy()).collect();
                return has_provenance(path) || outputs.listed.contains(&parts.join("/"));
            }
        }
        has_provenance(path) && has_source_beside(path)
    }

    fn outputs_in(&self, folder: &Path) -> FolderOutputs {
        // The folder of a file without a folder in its path.
        let folder = match folder.as_os_str().is_empty() {
            true => Path::new("."),
            false => folder,
        };
        FolderOutputs {
            is_own: self.folder.is_some() && folder.canonicalize().ok() == self.folder,
            listed: manifest::outputs(folder),
        }
    }
}

/// Whether the folder of an output has a motion with the same name that is not an output.
fn has_source_beside(path: &Path) -> bool {
    let is_source = |extension: &&str| {
        let source = path.with_extension(extension);
        source != path && source.is_file() && !has_provenance(&source)
    };
    let extensions = FormatInfo::ALL.iter().flat_map(|row| row.extensions);
    extensions.copied().any(|extension| is_source(&extension))
}

/// The output of every input, as relative paths. The new extension replaces the old one. If two inputs would get the
/// same output, the new extension is appended to the old one. Clips of one file are in a folder with its name.
pub(crate) fn name_outputs(inputs: &[Input], extension: &str) -> Result<HashMap<String, String>, Failure> {
    // An unreadable entry has no output, so that it does not change the name of another output.
    let inputs = || inputs.iter().filter(|input| input.problem.is_none());
    let replaced = |input: &Input| {
        let relative = Path::new(&input.relative);
        match (input.clip, relative.parent(), relative.file_name()) {
            (Some(_), Some(file), Some(clip)) => {
                let name = format!("{}.{extension}", clip.to_string_lossy());
                file.with_extension("").join(name)
            }
            _ => relative.with_extension(extension),
        }
    };
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
            let message = "two inputs have this path relative to their input folders; name one folder that holds both";
            return Err(Failure::Usage(format!("{}: {message}", input.relative)));
        }
        if !is_new {
            let message = "another input has the same output; rename one of the two";
            return Err(Failure::Usage(format!("{}: {message}", input.relative)));
        }
    }
    Ok(outputs)
}
