//! Output files that are whole or absent, and what they may replace. Only this module of the library writes files.

mod array_mark;
pub(crate) mod confined;
mod csv_table;
mod existing;
mod fbx_header;
mod unfinished;
mod usd_header;

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

#[doc(hidden)]
pub use self::array_mark::{ANALOG_MARK, ANGLES_MARK, ARRAY_MARK, DATABASE_MARK, FORCES_MARK, PARQUET_CREATOR};
pub use self::confined::{check_confined, confine};
pub use self::csv_table::csv_field;
#[doc(hidden)]
pub use self::csv_table::{PointColumns, Records, is_csv_of_points, is_own_csv, point_of};
#[doc(hidden)]
pub use self::existing::percent_decoded;
pub use self::existing::{ReplacePolicy, has_provenance};
#[doc(hidden)]
pub use self::fbx_header::{FBX_HEAD, PROVENANCE, fbx_provenance};
use self::unfinished::{Unfinished, named};
#[doc(hidden)]
pub use self::usd_header::{USD_HEAD, ZIP_HEAD};
use crate::error::{Error, Result};

/// The text of a file.
///
/// # Errors
/// [`Code::Io`](crate::Code::Io) where it cannot be read or is no UTF-8.
#[doc(hidden)]
pub fn read_text(path: &Path) -> Result<String> {
    check_confined(path)?;
    fs::read_to_string(path).map_err(|source| Error::io(path, source))
}

/// Writes `bytes` to `path`, whole or not at all: to a file without a name in the same folder, which then gets its
/// name.
///
/// An existing file is replaced and keeps its permissions; after an error it is unchanged. A read-only file is not
/// replaced. A link is followed. A pipe or a device is written directly.
///
/// To replace a file, the new one has a temporary name for a moment. Where the system has no files without a name,
/// which only Linux has, it has that name from the start. A process that is killed then leaves the temporary file;
/// [`remove_unfinished`] removes it, and [`unfinished_target`] recognises its name.
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
#[doc(hidden)]
pub fn write_file_with(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<u64> {
    let write = || match Target::of(path)? {
        Target::Stream => write_stream(path, write),
        Target::File(target) => {
            let file = Unfinished::new(&target, write)?;
            let length = file.file().metadata()?.len();
            file.persist(&target)?;
            Ok(length)
        }
    };
    write().map_err(|source| Error::io(path, source))
}

/// Writes several files as one output: all of them are replaced, or none.
///
/// The last file is the one that refers to the others. It is renamed away before the others are replaced, so that it
/// never refers to files of another output, even if the process is killed. It has a temporary name then, by which
/// [`ReplacePolicy`] knows the others as its own.
///
/// The bytes of a file are in parts. One file may be a pipe or a device.
///
/// # Errors
/// As [`write_file`]. All files are then unchanged.
#[doc(hidden)]
pub fn write_whole(files: &[(&Path, &[impl AsRef<[u8]>])]) -> Result<()> {
    if let [(path, parts)] = files {
        write_file_with(path, |file| write_parts(file, parts))?;
        return Ok(());
    }
    // All files are complete before the first is replaced.
    let mut written = Vec::new();
    for (path, parts) in files {
        let write = || match Target::of(path)? {
            Target::Stream => Err(io::Error::other(
                "an output of several files cannot be written to a pipe or a device",
            )),
            Target::File(target) => {
                let file = Unfinished::new(&target, |file| write_parts(file, parts))?;
                Ok((*path, target, file))
            }
        };
        written.push(write().map_err(|source| Error::io(path, source))?);
    }
    // If the process is killed now, this file tells whose the others are.
    if let Some((path, target, file)) = written.pop() {
        let file = file.with_name(&target).map_err(|source| Error::io(path, source))?;
        written.push((path, target, file));
    }
    let mut replaced = Replaced::default();
    for (path, target, _) in written.iter().rev() {
        replaced.set_aside(target).map_err(|source| Error::io(path, source))?;
    }
    for (path, target, file) in written {
        file.persist(&target).map_err(|error| Error::io(path, error))?;
        replaced.new.push(target);
    }
    replaced.keep();
    Ok(())
}

fn write_parts(file: &mut dyn Write, parts: &[impl AsRef<[u8]>]) -> io::Result<()> {
    parts.iter().try_for_each(|part| file.write_all(part.as_ref()))
}

/// Existing files that were renamed to make room for new ones. Dropping it restores them, unless
/// [`Replaced::keep`] was called.
#[derive(Default)]
#[doc(hidden)]
pub struct Replaced {
    /// The path of each existing file, and its temporary path.
    old: Vec<(PathBuf, TempPath)>,
    /// The new files.
    pub new: Vec<PathBuf>,
}

impl Replaced {
    pub fn set_aside(&mut self, target: &Path) -> io::Result<()> {
        if !target.try_exists()? {
            return Ok(());
        }
        let aside = named(target)?.into_temp_path();
        fs::rename(target, &aside)?;
        self.old.push((target.to_owned(), aside));
        Ok(())
    }

    fn keep(mut self) {
        // Dropping a temporary path removes its file.
        self.old.clear();
        self.new.clear();
    }
}

impl Drop for Replaced {
    fn drop(&mut self) {
        for path in &self.new {
            // An error cannot be handled here.
            let _ = fs::remove_file(path);
        }
        for (target, aside) in self.old.drain(..).rev() {
            let _ = aside.persist(target);
        }
    }
}

/// What a path stands for.
enum Target {
    /// A regular file or a new one; links are followed.
    File(PathBuf),
    /// A pipe or a device.
    Stream,
}

impl Target {
    fn of(path: &Path) -> io::Result<Self> {
        confined::check_path(path)?;
        let target = match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => {
                return Err(io::Error::new(io::ErrorKind::IsADirectory, "the path is a folder"));
            }
            Ok(metadata) if !metadata.is_file() => return Ok(Self::Stream),
            Ok(metadata) => {
                if metadata.permissions().readonly() {
                    return Err(io::Error::new(
                        io::ErrorKind::PermissionDenied,
                        "the existing file is read-only",
                    ));
                }
                match fs::symlink_metadata(path)?.is_symlink() {
                    true => fs::canonicalize(path)?,
                    false => path.to_owned(),
                }
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => end_of_links(path),
            Err(error) => return Err(error),
        };
        // The system's message for a missing folder would name the temporary file.
        let folder = folder_of(&target);
        if !folder.is_dir() {
            let message = format!("there is no folder {}", folder.display());
            return Err(io::Error::new(io::ErrorKind::NotFound, message));
        }
        Ok(Self::File(target))
    }
}

/// The path at the end of links whose target does not exist. The system has checked that there is no loop.
fn end_of_links(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    while let Ok(next) = fs::read_link(&path) {
        path = folder_of(&path).join(next);
    }
    path
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Writes to a pipe or a device, which cannot be replaced and cannot lose data.
fn write_stream(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<u64> {
    let mut stream = Counted {
        file: File::options().write(true).open(path)?,
        bytes: 0,
    };
    write(&mut stream)?;
    Ok(stream.bytes)
}

struct Counted {
    file: File,
    bytes: u64,
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The part of a temporary file's name between the target's name and the random end.
const UNFINISHED: &str = ".unfinished-";

/// The target of a temporary file that a killed process has left behind; `None` for any other file.
///
/// ```
/// use std::path::Path;
/// use mocap::files::unfinished_target;
///
/// let left = Path::new("out/.walk.glb.unfinished-x7Qz1a");
/// assert_eq!(unfinished_target(left).as_deref(), Some(Path::new("out/walk.glb")));
/// assert_eq!(unfinished_target(Path::new("out/walk.glb")), None);
/// ```
pub fn unfinished_target(path: &Path) -> Option<PathBuf> {
    let (target, _) = path.file_name()?.to_str()?.strip_prefix('.')?.rsplit_once(UNFINISHED)?;
    Some(path.with_file_name(target))
}

/// Removes temporary files that killed processes have left of the output `path`, and, if that is a `.gltf`, of its
/// buffer. Another process must not be at work on the same output.
///
/// ```
/// let folder = tempfile::tempdir().unwrap();
/// let left = folder.path().join(".walk.glb.unfinished-x7Qz1a");
/// std::fs::write(&left, "a part").unwrap();
/// mocap::files::remove_unfinished(&folder.path().join("walk.glb"));
/// assert!(!left.exists());
/// ```
pub fn remove_unfinished(path: &Path) {
    let Ok(Target::File(target)) = Target::of(path) else {
        return;
    };
    let outputs = [target.with_extension("bin"), target.clone()];
    let outputs = if target
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"))
    {
        &outputs[..]
    } else {
        &outputs[1..]
    };
    // Errors are left to the writer of the output, which tells them.
    for entry in fs::read_dir(folder_of(&target)).into_iter().flatten().flatten() {
        let left = unfinished_target(&entry.path());
        if left.is_some_and(|left| outputs.iter().any(|output| output.file_name() == left.file_name())) {
            let _ = fs::remove_file(entry.path());
        }
    }
}
