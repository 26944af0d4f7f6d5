//! The folder of a session: what a call may read and write.

use std::collections::BTreeSet;
use std::env;
use std::fs;
use std::path::{Component, Path, PathBuf};

use mocap::files::{check_confined, confine};
use serde_json::Value;

use crate::Failure;

/// The folder in which all files of a session are, and those that the session has written.
pub(super) struct Root {
    written: BTreeSet<PathBuf>,
}

impl Root {
    /// Makes `folder` the current one, and the only one whose files this process opens.
    pub(super) fn enter(folder: &Path) -> Result<Self, Failure> {
        confine(folder)?;
        env::set_current_dir(folder).map_err(|error| Failure::Folder(folder.to_owned(), error))?;
        Ok(Self {
            written: BTreeSet::new(),
        })
    }

    /// Refuses arguments with a text that leads out of the folder, whatever the text is for. A path with `..` is
    /// refused before anything is looked for on the disk.
    pub(super) fn check(&self, arguments: &Value) -> Result<(), Failure> {
        match arguments {
            Value::String(text) => check_text(text),
            Value::Array(values) => values.iter().try_for_each(|value| self.check(value)),
            Value::Object(fields) => fields.iter().try_for_each(|(key, value)| {
                check_text(key)?;
                self.check(value)
            }),
            _ => Ok(()),
        }
    }

    /// Refuses an output that would replace what this session has not written. Returns whether it replaces what the
    /// session has written.
    pub(super) fn check_output(&self, output: &Path) -> Result<bool, Failure> {
        check_confined(output)?;
        let buffer = output.with_extension("bin");
        let has_buffer = output.extension().is_some_and(|it| it.eq_ignore_ascii_case("gltf"));
        let beside = has_buffer.then_some(buffer.as_path());
        for path in beside.into_iter().chain([output]) {
            if path.symlink_metadata().is_ok() && !self.has_written(path) {
                return Err(Failure::Usage(format!(
                    "{} exists, and this session has not written it; name another output",
                    path.display()
                )));
            }
        }
        Ok(output.exists())
    }

    /// Refuses a folder of outputs that has files which this session has not written.
    pub(super) fn check_folder(&self, folder: &Path) -> Result<(), Failure> {
        check_confined(folder)?;
        let entries = || fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
        let is_free = folder.symlink_metadata().is_err() || self.has_written(folder) || folder.is_dir() && !entries();
        match is_free {
            true => Ok(()),
            false => Err(Failure::Usage(format!(
                "{} has files that this session has not written; name a new folder",
                folder.display()
            ))),
        }
    }

    /// Notes a file or a folder that a call has written.
    pub(super) fn note(&mut self, path: &Path) {
        self.written.extend(path.canonicalize().ok());
    }

    fn has_written(&self, path: &Path) -> bool {
        let Ok(real) = path.canonicalize() else { return false };
        let is_link = path.is_symlink();
        !is_link && self.written.contains(&real)
    }
}

fn check_text(text: &str) -> Result<(), Failure> {
    let path = Path::new(text);
    let leads_up = path.components().any(|part| part == Component::ParentDir);
    let is_long = text.len() > MOST_PATH;
    let is_within = !leads_up && (is_long || check_confined(path).is_ok());
    let shown: String = text.chars().take(80).collect();
    match (text, is_within) {
        ("-", _) => Err(Failure::Usage(
            "- is standard input or output, which belong to the protocol; name a file".to_owned(),
        )),
        (_, true) => Ok(()),
        (_, false) => Err(Failure::Usage(format!(
            "{shown:?} leads out of the root folder; name a path inside of it, without .. and links that lead out"
        ))),
    }
}

/// The longest text that is taken for a path, in bytes: no system has longer ones.
const MOST_PATH: usize = 32_768;
