//! Output files that are complete or absent, and the rules for replacing files. No other module of the library writes
//! files.

mod array_mark;
pub(crate) mod confined;
mod csv_table;
mod existing;
mod fbx_header;
mod file_id;
mod folder;
mod own;
mod part;
pub(crate) mod record;
#[doc(hidden)]
pub mod set;
mod unfinished;
mod usd_header;

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

#[doc(hidden)]
pub use self::array_mark::{ANALOG_MARK, ANGLES_MARK, ARRAY_MARK, DATABASE_MARK, FORCES_MARK, PARQUET_CREATOR};
#[doc(hidden)]
pub use self::confined::{check_confined, confine};
#[doc(hidden)]
pub use self::csv_table::{
    PointColumns, Records, csv_field, is_csv_of_points, is_face_csv, is_motive_csv, is_own_csv, point_of,
};
#[doc(hidden)]
pub use self::existing::{ReplacePolicy, has_provenance, percent_decoded};
#[doc(hidden)]
pub use self::fbx_header::{FBX_HEAD, PROVENANCE, fbx_provenance};
#[doc(hidden)]
pub use self::folder::{check_folder, persist_folder};
#[doc(hidden)]
pub use self::own::{OwnFiles, go_on};
#[doc(hidden)]
pub use self::part::FilePart;
#[doc(hidden)]
pub use self::record::record_outputs;
#[doc(hidden)]
pub use self::set::{OutputSet, check_distinct};
use self::unfinished::UnfinishedFile;
#[doc(hidden)]
pub use self::usd_header::{USD_HEAD, ZIP_HEAD};
use crate::error::{Error, Result};

/// The text of a file, as [`decode_text`] reads it.
///
/// # Errors
/// [`Code::Io`](crate::Code::Io) if the file cannot be read or is not text.
#[doc(hidden)]
pub fn read_text(path: &Path) -> Result<String> {
    check_confined(path)?;
    let bytes = fs::read(path).map_err(|source| Error::io(path, source))?;
    decode_text(bytes).ok_or_else(|| {
        let source = io::Error::new(io::ErrorKind::InvalidData, "the file is not UTF-8 text");
        Error::io(path, source)
    })
}

/// Decodes UTF-8 or UTF-16, and removes a byte order mark. A text without this mark is UTF-8. Windows PowerShell writes
/// UTF-16. `None` if the bytes are not text.
#[doc(hidden)]
pub fn decode_text(mut bytes: Vec<u8>) -> Option<String> {
    let units = |unit: fn([u8; 2]) -> u16| {
        let pairs = bytes[2..].as_chunks::<2>().0;
        String::from_utf16(&pairs.iter().map(|pair| unit(*pair)).collect::<Vec<u16>>()).ok()
    };
    match bytes[..] {
        [0xFF, 0xFE, ..] => return units(u16::from_le_bytes),
        [0xFE, 0xFF, ..] => return units(u16::from_be_bytes),
        [0xEF, 0xBB, 0xBF, ..] => drop(bytes.drain(..3)),
        _ => {}
    }
    String::from_utf8(bytes).ok()
}

/// Copies a file with its permissions. Follows links.
///
/// # Errors
/// [`Code::Io`](crate::Code::Io), with the path of the copied file.
#[doc(hidden)]
pub fn copy_file(from: &Path, to: &Path) -> Result<()> {
    check_confined(from)?;
    fs::copy(from, to).map_err(|source| Error::io(from, source))?;
    Ok(())
}

/// Writes `bytes` to `path`, completely or not at all. Creates a nameless file in the same folder, and then gives the
/// file its name.
///
/// An existing file is replaced and keeps its permissions. After an error the existing file is unchanged. A read-only
/// file is not replaced. Links are followed. A pipe or a device is written directly.
///
/// A file that replaces another has a temporary name for a short time. Only Linux has nameless files; on other systems
/// the file has the temporary name from the start. If the process is killed while the file has the temporary name, the
/// temporary file remains. [`remove_unfinished`] removes this file, and [`unfinished_target`] recognises its name.
///
/// # Errors
/// [`Code::Io`](crate::Code::Io), with the path.
#[doc(hidden)]
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    write_file_with(path, |file| file.write_all(bytes))?;
    Ok(())
}

/// Each writer of an output holds this lock for reading. [`stop_writing`] takes the lock for writing, and never
/// releases it.
static WRITING: RwLock<()> = RwLock::new(());

fn writing() -> RwLockReadGuard<'static, ()> {
    WRITING.read().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until no output is being written, and blocks all later writes. A process calls this function before it ends.
#[doc(hidden)]
pub fn stop_writing() {
    mem::forget(WRITING.write().unwrap_or_else(PoisonError::into_inner));
}

/// Like [`write_file`], for bytes in several buffers, which `write` writes in order. Returns the number of bytes.
///
/// # Errors
/// The errors of [`write_file`].
#[doc(hidden)]
pub fn write_file_with(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<u64> {
    write_noted(path, existing::needs_record(path).then_some(&[]), write)
}

/// Like [`write_file_with`]. The record of outputs gets the names of `sources`; with `None`, the output is not
/// recorded.
fn write_noted(
    path: &Path,
    sources: Option<&[&str]>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<u64> {
    let _writing = writing();
    let write = || match Target::to_write(path)? {
        Target::Stream => write_stream(path, write),
        Target::File(target) => {
            let file = UnfinishedFile::new(&target, write)?;
            let length = file.file().metadata()?.len();
            if let Some(sources) = sources {
                record::note(&target, || file.contents(), sources);
            }
            file.persist(&target)?;
            own::note(&target);
            record::written(path);
            Ok(length)
        }
    };
    write().map_err(|source| Error::io(path, source))
}

/// The kind of file at a path.
enum Target {
    /// A regular or new file, with links followed.
    File(PathBuf),
    /// A pipe or a device.
    Stream,
}

impl Target {
    /// The target of a write. A confined process replaces only its own files.
    fn to_write(path: &Path) -> io::Result<Self> {
        match own::is_of_others(path) {
            true => Err(io::Error::new(io::ErrorKind::AlreadyExists, own::OF_OTHERS)),
            false => Self::of(path),
        }
    }

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
        // Report a missing folder here, because the system's message would name the temporary file.
        let folder = folder_of(&target);
        if !folder.is_dir() {
            let message = format!("there is no folder {}", folder.display());
            return Err(io::Error::new(io::ErrorKind::NotFound, message));
        }
        Ok(Self::File(target))
    }
}

/// The path at the end of a chain of links whose target does not exist. The system has already rejected loops.
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

/// Writes to a pipe or a device, which is never replaced and cannot lose data.
fn write_stream(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<u64> {
    let mut stream = CountingWriter {
        file: File::options().write(true).open(path)?,
        bytes: 0,
    };
    write(&mut stream)?;
    Ok(stream.bytes)
}

struct CountingWriter {
    file: File,
    bytes: u64,
}

impl Write for CountingWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The text in a temporary file's name between the target's name and the random end.
const UNFINISHED: &str = ".unfinished-";

/// The target of a temporary file from a killed process; `None` for any other file.
///
/// ```
/// use std::path::Path;
/// use mocap::files::unfinished_target;
///
/// let left = Path::new("out/.walk.glb.unfinished-x7Qz1a");
/// assert_eq!(unfinished_target(left).as_deref(), Some(Path::new("out/walk.glb")));
/// assert_eq!(unfinished_target(Path::new("out/walk.glb")), None);
/// ```
#[doc(hidden)]
pub fn unfinished_target(path: &Path) -> Option<PathBuf> {
    let (target, _) = path.file_name()?.to_str()?.strip_prefix('.')?.rsplit_once(UNFINISHED)?;
    Some(path.with_file_name(target))
}

/// Removes the temporary files that killed processes left for the output `path`. If `path` is a `.gltf`, also removes
/// the temporary files for its buffer. No other process may be writing the same output.
///
/// ```
/// let folder = tempfile::tempdir().unwrap();
/// let left = folder.path().join(".walk.glb.unfinished-x7Qz1a");
/// std::fs::write(&left, "a part").unwrap();
/// mocap::files::remove_unfinished(&folder.path().join("walk.glb"));
/// assert!(!left.exists());
/// ```
#[doc(hidden)]
pub fn remove_unfinished(path: &Path) {
    let buffer = path.with_extension("bin");
    let has_buffer = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"));
    remove_all_unfinished([path].into_iter().chain(has_buffer.then_some(buffer.as_path())));
}

/// Like [`remove_unfinished`], for several outputs. A confined process removes only its own files.
#[doc(hidden)]
pub fn remove_all_unfinished<'a>(outputs: impl IntoIterator<Item = &'a Path>) {
    if confined::is_confined() {
        return;
    }
    let mut folders = BTreeMap::<PathBuf, BTreeSet<OsString>>::new();
    for output in outputs {
        if let Ok(Target::File(target)) = Target::of(output) {
            let names = folders.entry(folder_of(&target).to_owned()).or_default();
            names.extend(target.file_name().map(OsStr::to_owned));
        }
    }
    // The writer of the output reports errors.
    for (folder, names) in folders {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let left = unfinished_target(&entry.path());
            let name = left.as_deref().and_then(Path::file_name);
            if name.is_some_and(|name| names.contains(name)) {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}
