//! The folder of a session. A call may only read and write in this folder.

use std::env;
use std::path::{Component, Path};

use mocap::files::{ReplacePolicy, check_confined, confine};
use serde_json::Value;
use walkdir::WalkDir;

use crate::Failure;

/// The folder in which all files of a session are.
#[derive(Clone, Copy)]
pub(super) struct Root;

impl Root {
    /// Makes `folder` the current folder, and the only folder whose files this process opens. From now on, the process
    /// replaces only files that it has written.
    pub(super) fn enter(folder: &Path) -> Result<Self, Failure> {
        confine(folder)?;
        env::set_current_dir(folder).map_err(|error| Failure::Folder(folder.to_owned(), error))?;
        Ok(Self)
    }

    /// Refuses arguments if any string of them, whatever its purpose, is a path that leads out of the folder. A path
    /// with `..` is refused before any access to the disk.
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
}

/// Refuses an output that would replace a file that this session has not written, before the motion is made. The writer
/// checks again, for all files of the output.
pub(super) fn check_output(output: &Path) -> Result<(), Failure> {
    Ok(ReplacePolicy::default().check_inputs(output)?)
}

/// Refuses an output folder with files that this session has not written.
pub(super) fn check_folder(folder: &Path) -> Result<(), Failure> {
    check_confined(folder)?;
    let is_of_others = |path: &Path| !path.is_dir() && check_output(path).is_err();
    let entries = WalkDir::new(folder).into_iter().flatten();
    match entries
        .map(walkdir::DirEntry::into_path)
        .find(|path| is_of_others(path))
    {
        None => Ok(()),
        Some(path) => Err(Failure::Usage(format!(
            "{} has files that this session has not written, such as {}; name a new folder",
            folder.display(),
            path.display()
        ))),
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
            "- is standard input or output, which the protocol uses; name a file".to_owned(),
        )),
        (_, true) => Ok(()),
        (_, false) => Err(Failure::Usage(format!(
            "{shown:?} leads out of the root folder; name a path inside it, without .. and without links that lead out"
        ))),
    }
}

/// The longest text in bytes that is treated as a path. No system has longer paths.
const MOST_PATH: usize = 32_768;
