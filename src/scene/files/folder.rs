//! Writes output folders. A failed command leaves no partial folder. The record of outputs lists each file.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::ReplacePolicy;
use super::existing::may_be_motion;
use super::record::{self, RecordState};
use crate::error::{Code, Diagnostic, Error, Result};

/// Checks whether an output folder may go to `folder`: the path is free, or has an empty folder, or an earlier output.
/// A folder is an earlier output if the record of outputs knows each of its files as unchanged. None of its files may
/// be an input or a motion.
///
/// # Errors
/// [`Code::OutputIsInput`]. [`Code::OutputExists`] for any other folder, and for a file; it names the first file that
/// would be lost.
#[doc(hidden)]
pub fn check_folder(folder: &Path, policy: &ReplacePolicy) -> Result<()> {
    let is_absent = |error: &io::Error| error.kind() == io::ErrorKind::NotFound;
    let lost = match fs::symlink_metadata(folder) {
        Err(error) if is_absent(&error) => return Ok(()),
        // A link is not replaced, because its target would lose the name.
        Ok(found) if !found.is_dir() => Some((folder.to_owned(), false)),
        _ => {
            let files = files_below(folder).map_err(|error| Error::io(folder, error))?;
            files.iter().try_for_each(|path| policy.check_inputs(path))?;
            files.into_iter().find_map(|path| match record::find(&path) {
                _ if path.is_symlink() || may_be_motion(&path) => Some((path, false)),
                RecordState::Unchanged(_) => None,
                state => Some((path, state != RecordState::Unknown)),
            })
        }
    };
    let Some((path, has_changed)) = lost else { return Ok(()) };
    let message = match has_changed {
        true => "the output would replace the folder of this file, and the file has changed since mocap wrote it",
        false => "the output would replace the folder of this file, and mocap has no record of the file",
    };
    let diagnostic = Diagnostic::new(Code::OutputExists, message).help("name another folder, or remove this one");
    Err(Error::from(diagnostic).with_path(&path))
}

/// Renames the folder `made` to `folder`, and records its files as outputs. Both folders have the same parent. Replaces
/// an earlier output if [`check_folder`] allows it. After an error the earlier output is unchanged.
///
/// # Errors
/// The errors of [`check_folder`], and [`Code::Io`] with the path of the folder.
#[doc(hidden)]
pub fn persist_folder(made: &Path, folder: &Path, policy: &ReplacePolicy) -> Result<()> {
    check_folder(folder, policy)?;
    let in_folder = |error| Error::io(folder, error);
    for path in files_below(made).map_err(in_folder)? {
        let below = path.strip_prefix(made).unwrap_or(&path);
        record::note_below(folder, below, &path);
    }
    // Some systems cannot rename to an existing folder, even an empty one.
    let is_new = match fs::remove_dir(folder) {
        Ok(()) => true,
        Err(error) => error.kind() == io::ErrorKind::NotFound,
    };
    if is_new {
        return fs::rename(made, folder).map_err(in_folder);
    }
    let mut earlier = made.as_os_str().to_owned();
    earlier.push(".earlier");
    fs::rename(folder, &earlier).map_err(in_folder)?;
    if let Err(error) = fs::rename(made, folder) {
        fs::rename(&earlier, folder).map_err(in_folder)?;
        return Err(in_folder(error));
    }
    record::replaced(folder);
    fs::remove_dir_all(&earlier).map_err(|error| Error::io(Path::new(&earlier), error))
}

/// The files and links in a folder and its subfolders, sorted by name.
fn files_below(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            let kind = if entry.file_type()?.is_dir() {
                &mut folders
            } else {
                &mut files
            };
            kind.push(entry.path());
        }
    }
    files.sort_unstable();
    Ok(files)
}
