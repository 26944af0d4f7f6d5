//! The outputs of many files in a folder: their names, and whether they may be written.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use mocap::files::{OutputSet, ReplacePolicy, has_provenance};
use mocap::{Code, Diagnostic, Error, Written};

use super::hash::{sha256, sha256_of_parts};
use super::inputs::Input;
use super::manifest;
use crate::Failure;

/// One of the outputs, for the thread that makes it.
pub(crate) struct Output<'a> {
    /// Its path below the folder.
    pub(crate) name: &'a str,
    pub(crate) path: PathBuf,
    pub(crate) policy: &'a ReplacePolicy,
    /// The SHA-256 that a former run noted when it wrote this file.
    pub(super) written: Option<&'a str>,
    pub(super) claims: &'a Claims,
}

impl Output<'_> {
    /// Whether a former run has written the file that is there, according to the manifest, and it has not changed
    /// since.
    fn is_known(&self) -> bool {
        let written = self.written;
        written.is_some_and(|written| sha256(&self.path).is_ok_and(|found| found == written))
    }

    /// Writes the files, unless one would replace an input, a file that may be a source, or another output of the run.
    pub(crate) fn save(&self, written: &Written) -> mocap::Result<()> {
        self.checked(written)?.save(&self.policy())
    }

    /// Refuses what [`save`](Self::save) refuses, and writes nothing.
    pub(crate) fn check(&self, written: &Written) -> mocap::Result<()> {
        self.checked(written).map(drop)
    }

    fn checked<'w>(&self, written: &'w Written) -> mocap::Result<OutputSet<'w>> {
        let set = written.output_set(&self.path)?;
        set.check(&self.policy())?;
        self.claims.take(&set)?;
        Ok(set)
    }

    fn policy(&self) -> ReplacePolicy {
        let known = self.is_known().then_some(&self.path);
        self.policy.clone().outputs(known)
    }
}

/// The files that the outputs of a run consist of, with their SHA-256. Two outputs may share a file, such as a texture
/// of one character, if it has the same bytes for both.
#[derive(Default)]
pub(super) struct Claims(Mutex<BTreeMap<PathBuf, Claim>>);

struct Claim {
    path: PathBuf,
    sha256: String,
}

impl Claims {
    fn take(&self, set: &OutputSet<'_>) -> mocap::Result<()> {
        let claim = |(path, parts): (&Path, &[&[u8]])| {
            let (path, sha256) = (path.to_owned(), sha256_of_parts(parts));
            (path.clone(), Claim { path, sha256 })
        };
        let mut wanted: Vec<(PathBuf, Claim)> = set.files().map(claim).collect();
        // Some systems do not tell capitals from small letters. The last file has the name of its input.
        if let Some((_, beside)) = wanted.split_last_mut() {
            for (key, _) in beside {
                *key = key.with_file_name(key.file_name().unwrap_or_default().to_string_lossy().to_lowercase());
            }
        }
        let mut claims = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_taken = |(key, claim): &&(PathBuf, Claim)| claims.get(key).is_some_and(|it| it.sha256 != claim.sha256);
        if let Some((_, claim)) = wanted.iter().find(is_taken) {
            let message = "another output of this run has a file of this name with other contents";
            let diagnostic = Diagnostic::new(Code::OutputExists, message)
                .help("write the two outputs into different folders, or embed the textures");
            return Err(Error::from(diagnostic).with_path(&claim.path));
        }
        claims.extend(wanted);
        Ok(())
    }

    pub(super) fn paths(&self) -> Vec<PathBuf> {
        let claims = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        claims.values().map(|claim| claim.path.clone()).collect()
    }
}

/// The files that former runs have written to a folder.
pub(crate) struct KnownOutputs {
    folder: Option<PathBuf>,
    outputs: HashSet<String>,
}

impl KnownOutputs {
    pub(crate) fn of(folder: &Path) -> Self {
        Self {
            folder: folder.canonicalize().ok(),
            outputs: manifest::outputs(folder),
        }
    }

    /// A glTF file says who wrote it; for other files the manifest says it.
    pub(crate) fn has(&self, path: &Path) -> bool {
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

/// The output of every input, both as relative paths: with the new extension instead of the old, or behind it where
/// two inputs would get one output.
pub(crate) fn name_outputs(inputs: &[Input], extension: &str) -> Result<HashMap<String, String>, Failure> {
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
