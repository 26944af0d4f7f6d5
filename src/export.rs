//! Output files that are whole or absent. Only this module of the library writes files.

use std::ffi::OsString;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Writes `bytes` to `path`, whole or not at all: to a temporary file beside the target, which is then renamed.
///
/// An existing file is replaced; after an error it is unchanged. A killed process may leave the temporary file, whose
/// name [`unfinished_target`] recognises.
///
/// # Errors
/// [`Code::Io`](crate::Code::Io), with the path.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    write_file_with(path, |file| file.write_all(bytes))?;
    Ok(())
}

/// As [`write_file`], for bytes in several buffers: `write` writes them one after the other. Returns their number.
///
/// # Errors
/// As [`write_file`].
pub(crate) fn write_file_with(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<u64> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let mut prefix = OsString::from(".");
    prefix.push(path.file_name().unwrap_or_default());
    prefix.push(UNFINISHED);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    // A temporary file is private by default; an output has the permissions of any new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let write = || {
        // The system's message for a missing folder would name the temporary file.
        if let Some(folder) = folder.filter(|folder| !folder.is_dir()) {
            let message = format!("there is no folder {}", folder.display());
            return Err(io::Error::new(io::ErrorKind::NotFound, message));
        }
        let mut file = builder.tempfile_in(folder.unwrap_or(Path::new(".")))?;
        write(&mut file)?;
        let length = file.as_file().metadata()?.len();
        file.persist(path)?;
        Ok(length)
    };
    write().map_err(|source| Error::io(path, source))
}

/// The part of a temporary file's name between the target's name and the random end.
const UNFINISHED: &str = ".unfinished-";

/// The target of a temporary file that a killed process has left behind; `None` for any other file.
///
/// ```
/// use std::path::Path;
/// use mocap::export::unfinished_target;
///
/// let left = Path::new("out/.walk.glb.unfinished-x7Qz1a");
/// assert_eq!(unfinished_target(left).as_deref(), Some(Path::new("out/walk.glb")));
/// assert_eq!(unfinished_target(Path::new("out/walk.glb")), None);
/// ```
pub fn unfinished_target(path: &Path) -> Option<PathBuf> {
    let (target, _) = path.file_name()?.to_str()?.strip_prefix('.')?.rsplit_once(UNFINISHED)?;
    Some(path.with_file_name(target))
}
