//! Makes a list of files from paths of files and folders, and from wildcards.

use std::path::{Component, Path, PathBuf};

use mocap::FORMATS;
use walkdir::WalkDir;

use crate::Failure;

/// An input file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Input {
    pub(crate) path: PathBuf,
    /// The path below the folder or the wildcards in which it was found, with `/` as separator; for a file named by the
    /// user, its name.
    pub(crate) relative: String,
    /// Its size when it was found.
    pub(crate) bytes: u64,
}

impl Input {
    fn new(path: PathBuf, folder: &Path) -> Self {
        let below = path.strip_prefix(folder).unwrap_or(&path);
        let parts = below.components().filter_map(|part| match part {
            Component::Normal(name) => Some(name.to_string_lossy()),
            _ => None,
        });
        Self {
            relative: parts.collect::<Vec<_>>().join("/"),
            bytes: path.metadata().map_or(0, |metadata| metadata.len()),
            path,
        }
    }
}

/// The files that `paths` name, sorted by their relative paths: files with any extension; in folders and from wildcards
/// only files with the extension of a known format.
///
/// A path that does not exist is an input too, and fails as one of many.
pub(crate) fn find(paths: &[PathBuf]) -> Result<Vec<Input>, Failure> {
    let mut inputs = Vec::new();
    for path in paths {
        if path.is_dir() {
            add_folder(path, path, &mut inputs)?;
        } else if !path.exists() && has_wildcard(path) {
            add_matches(path, &mut inputs)?;
        } else {
            inputs.push(Input::new(path.clone(), path.parent().unwrap_or(Path::new(""))));
        }
    }
    inputs.sort_by(|a, b| (&a.relative, &a.path).cmp(&(&b.relative, &b.path)));
    inputs.dedup_by(|a, b| a.path == b.path);
    Ok(inputs)
}

/// Adds the motion files at any depth of `folder`.
fn add_folder(folder: &Path, base: &Path, inputs: &mut Vec<Input>) -> Result<(), Failure> {
    for entry in WalkDir::new(folder).follow_links(true) {
        let entry = entry.map_err(|error| Failure::Usage(error.to_string()))?;
        if entry.file_type().is_file() && has_known_extension(entry.path()) {
            inputs.push(Input::new(entry.into_path(), base));
        }
    }
    Ok(())
}

/// Adds the files that a wildcard pattern matches; their relative paths begin at its first wildcard.
fn add_matches(pattern: &Path, inputs: &mut Vec<Input>) -> Result<(), Failure> {
    let base: PathBuf = pattern
        .components()
        .take_while(|part| !has_wildcard(Path::new(part)))
        .collect();
    let text = pattern
        .to_str()
        .ok_or_else(|| Failure::Usage(format!("{} is not UTF-8", pattern.display())))?;
    let matches = glob::glob(text).map_err(|error| Failure::Usage(format!("{text}: {error}")))?;
    for found in matches {
        let path = found.map_err(|error| Failure::Usage(error.to_string()))?;
        if path.is_dir() {
            add_folder(&path, &base, inputs)?;
        } else if has_known_extension(&path) {
            inputs.push(Input::new(path, &base));
        }
    }
    Ok(())
}

fn has_wildcard(path: &Path) -> bool {
    path.to_string_lossy().contains(['*', '?', '['])
}

fn has_known_extension(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("");
    FORMATS
        .iter()
        .flat_map(|format| format.extensions)
        .any(|known| known.eq_ignore_ascii_case(extension))
}
