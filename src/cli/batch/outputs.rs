//! The outputs of many files in a folder: their names, and whether they may be written.

use std::collections::{HashMap, HashSet};
use std::io;
use std::path::{Path, PathBuf};

use mocap::Written;
use mocap::files::{ReplacePolicy, has_provenance, unfinished_target};
use walkdir::WalkDir;

use super::hash::sha256;
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
}

impl Output<'_> {
    /// Whether a former run has written the file that is there, according to the manifest, and it has not changed
    /// since.
    fn is_known(&self) -> bool {
        let written = self.written;
        written.is_some_and(|written| sha256(&self.path).is_ok_and(|found| found == written))
    }

    /// Writes the files, unless one would replace an input or a file that may be a source.
    pub(crate) fn save(&self, written: &Written) -> mocap::Result<()> {
        written.save(&self.path, &self.policy())
    }

    /// Refuses what [`save`](Self::save) refuses, and writes nothing.
    pub(crate) fn check(&self, written: &Written) -> mocap::Result<()> {
        written.check(&self.path, &self.policy()).map(drop)
    }

    fn policy(&self) -> ReplacePolicy {
        let policy = self.policy.clone();
        match self.is_known() {
            true => policy.force(true),
            false => policy,
        }
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

/// Removes what a killed run has left of these files under temporary names. Those of other shards, which may be at
/// work in the same folder, stay.
pub(crate) fn remove_unfinished(folder: &Path, files: impl Iterator<Item = PathBuf>) -> io::Result<()> {
    let own: HashSet<PathBuf> = files.flat_map(|file| [file.with_extension("bin"), file]).collect();
    for entry in WalkDir::new(folder) {
        let path = entry?.into_path();
        if unfinished_target(&path).is_some_and(|target| own.contains(&target)) {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}
