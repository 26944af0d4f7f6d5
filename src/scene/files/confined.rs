//! Confines file access to a folder, for programs that get file names from others.

use std::env;
use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::OnceLock;

use crate::error::{Error, Result};

/// The folder for all files; every folder is allowed if none is set.
static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// From now on this process imports and writes no file outside of `folder`. This includes the files to which a file
/// refers, such as buffers, skeletons and meshes. A link counts as its target. The process replaces only files that it
/// has written itself. The setting is permanent: a second call has no effect.
///
/// ```no_run
/// mocap::files::confine("takes".as_ref())?;
/// let error = mocap::import("/etc/passwd").unwrap_err();
/// assert!(error.to_string().contains("outside of the folder"));
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// [`Code::Io`](crate::Code::Io) if the folder does not exist.
pub fn confine(folder: &Path) -> Result<()> {
    let in_folder = |error| Error::io(folder, error);
    let real = fs::canonicalize(folder).map_err(in_folder)?;
    if !real.is_dir() {
        return Err(in_folder(io::Error::new(
            io::ErrorKind::NotADirectory,
            "it must be a folder",
        )));
    }
    // The first folder remains set.
    let _ = FOLDER.set(real);
    Ok(())
}

/// Checks whether a file may be opened. Without a call of [`confine`], every file may be opened. The file need not
/// exist.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// assert!(mocap::files::check_confined("fixtures/real/cmu_short.bvh".as_ref()).is_ok());
/// ```
///
/// # Errors
/// [`Code::Io`](crate::Code::Io) for a file outside of the folder. The error does not reveal whether the file exists.
pub fn check_confined(path: &Path) -> Result<()> {
    check_path(path).map_err(|error| Error::io(path, error))
}

/// Like [`check_confined`], without the path in the error.
pub(super) fn check_path(path: &Path) -> io::Result<()> {
    FOLDER.get().map_or(Ok(()), |folder| check_within(path, folder))
}

/// Whether [`confine`] was called.
pub(super) fn is_confined() -> bool {
    FOLDER.get().is_some()
}

/// Refuses a path that is not within the folder.
pub fn check_within(path: &Path, folder: &Path) -> io::Result<()> {
    let is_within = real_path(path).is_some_and(|real| real.starts_with(folder));
    let message = "it is outside of the folder that this program may use, or a link that leads out of it";
    is_within
        .then_some(())
        .ok_or_else(|| io::Error::new(io::ErrorKind::PermissionDenied, message))
}

/// The path without links. Its end need not exist. `None` if unknown: for a link without a target, and if `..` follows
/// a missing entry.
fn real_path(path: &Path) -> Option<PathBuf> {
    let path = env::current_dir().ok()?.join(path);
    let mut missing = Vec::new();
    let mut existing = path.as_path();
    loop {
        if let Ok(real) = fs::canonicalize(existing) {
            return Some(missing.iter().rev().fold(real, |path, name| path.join(name)));
        }
        if existing.is_symlink() {
            return None;
        }
        match existing.components().next_back()? {
            Component::Normal(name) => missing.push(name),
            _ => return None,
        }
        existing = existing.parent()?;
    }
}
