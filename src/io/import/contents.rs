//! Opens input files, and checks their size against the limits while reading.
//!
//! Files are read, not mapped into memory. If another program shortened a mapped file, the operating system would end
//! the process that reads it. If another program changed a mapped file, a reader would meet bytes that it has not
//! checked.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mocap_formats::FormatInfo;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::check_confined;
use mocap_scene::limits::Limits;

use super::large::LargeFile;

/// The size in bytes from which a second thread reads a file faster.
pub(super) const LARGE: usize = 4 << 20;

/// The largest size of a stream in bytes. A stream does not state its length, so memory grows with the bytes that
/// arrive.
const LONGEST_STREAM: u64 = 1 << 30;

/// The number of bytes at the beginning of a stream from which its format is detected.
const BEGINNING: u64 = 64 << 10;

/// An opened input.
pub(super) enum Input {
    Whole(Vec<u8>),
    Large(Box<LargeFile>),
}

/// Opens the file that a caller names: a regular file, a pipe or a device. If the format `is_known`, the beginning of a
/// stream is not checked.
pub(super) fn open(path: &Path, limits: &Limits, is_known: bool) -> Result<Input> {
    check_confined(path)?;
    let file = File::open(path).map_err(|error| Error::io(path, error))?;
    let metadata = file.metadata().map_err(|error| Error::io(path, error))?;
    if metadata.is_file() && metadata.len() >= LARGE as u64 {
        check_size(metadata.len(), path, limits)?;
        let large = LargeFile::new(file, metadata.len()).map_err(|error| Error::io(path, error))?;
        return Ok(Input::Large(Box::new(large)));
    }
    if metadata.is_file() {
        return read_file(file, metadata.len(), path, limits).map(Input::Whole);
    }
    let is_known = is_known || format_of_extension(path).is_some();
    read_stream(file, path, limits, is_known).map(Input::Whole)
}

/// The bytes of a file that another file names, or of a file in the same folder. Refuses a pipe, which could block
/// forever.
pub(super) fn open_named(path: &Path, limits: &Limits) -> Result<Vec<u8>> {
    check_confined(path)?;
    let metadata = fs::metadata(path).map_err(|error| Error::io(path, error))?;
    if !(metadata.is_file() || metadata.is_dir()) {
        let message = "a file that another file refers to must be a regular file, not a pipe or a device";
        return Err(Error::io(path, io::Error::new(io::ErrorKind::InvalidInput, message)));
    }
    let file = File::open(path).map_err(|error| Error::io(path, error))?;
    read_file(file, metadata.len(), path, limits)
}

/// The bytes of a regular file of `size` bytes. If the size changes during reading, returns the bytes that the file
/// then has.
fn read_file(file: File, size: u64, path: &Path, limits: &Limits) -> Result<Vec<u8>> {
    check_size(size, path, limits)?;
    let mut bytes = Vec::new();
    let reserved = bytes.try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX).saturating_add(1));
    reserved.map_err(|error| Error::io(path, io::Error::new(io::ErrorKind::OutOfMemory, error)))?;
    // Reading one byte more than the limit shows that the file has grown beyond the limit.
    let read = file.take(limits.max_bytes.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| Error::io(path, error))?;
    check_size(bytes.len() as u64, path, limits)?;
    Ok(bytes)
}

/// The bytes of a stream. Unless the format is known, the beginning must belong to a known format. This check stops
/// reading early at an endless stream that is no motion.
pub(super) fn read_stream(mut stream: impl Read, name: &Path, limits: &Limits, is_known: bool) -> Result<Vec<u8>> {
    let most = limits.max_bytes.min(LONGEST_STREAM);
    let mut bytes = Vec::new();
    let mut read_up_to = |length: u64, bytes: &mut Vec<u8>| {
        let more = length.saturating_sub(bytes.len() as u64);
        let read = stream.by_ref().take(more).read_to_end(bytes);
        read.map(drop).map_err(|error| Error::io(name, error))
    };
    read_up_to(BEGINNING.min(most.saturating_add(1)), &mut bytes)?;
    if !is_known && bytes.len() as u64 == BEGINNING && FormatInfo::of_contents(&bytes).is_none() {
        let message = "the beginning of the stream belongs to no known format";
        let diagnostic = Diagnostic::new(Code::UnknownFormat, message).help("name the format: {from}");
        return Err(Error::from(diagnostic).with_path(name));
    }
    // The buffer doubles as it grows, up to the limit.
    while bytes.len() as u64 <= most {
        let before = bytes.len();
        let more = (before as u64).max(BEGINNING).min(most + 1 - before as u64);
        let reserved = bytes.try_reserve_exact(usize::try_from(more).unwrap_or(usize::MAX));
        reserved.map_err(|error| Error::io(name, io::Error::new(io::ErrorKind::OutOfMemory, error)))?;
        read_up_to(before as u64 + more, &mut bytes)?;
        if bytes.len() as u64 - (before as u64) < more {
            return Ok(bytes);
        }
    }
    let diagnostic = Diagnostic::new(Code::LimitExceeded, "the stream is longer than the limits allow")
        .expected_found(format!("at most {most} bytes"), "more")
        .help("write the stream to a file first");
    Err(Error::from(diagnostic).with_path(name))
}

/// The format for the extension of a file name.
pub(super) fn format_of_extension(path: &Path) -> Option<&'static FormatInfo> {
    let extension = path.extension()?.to_str()?;
    let has_extension = |format: &&FormatInfo| {
        let mut known = format.extensions.iter();
        known.any(|known| known.eq_ignore_ascii_case(extension))
    };
    FormatInfo::ALL.iter().find(has_extension)
}

pub(super) fn check_size(size: u64, path: &Path, limits: &Limits) -> Result<()> {
    let limit = limits.max_bytes;
    if size <= limit {
        return Ok(());
    }
    let diagnostic = Diagnostic::new(Code::LimitExceeded, "the file is larger than the limits allow")
        .expected_found(format!("at most {limit} bytes"), format!("{size} bytes"));
    Err(Error::from(diagnostic).with_path(path))
}

/// The files with this extension, in any case, in the folder of `path`, sorted by name. The list is empty if the folder
/// cannot be listed. The caller then reports the missing file.
pub(super) fn list_siblings(path: &Path, extension: &str) -> Vec<PathBuf> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let has_extension = |file: &PathBuf| {
        file.extension()
            .is_some_and(|found| found.eq_ignore_ascii_case(extension))
    };
    if check_confined(folder).is_err() {
        return Vec::new();
    }
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .map(|entry| path.with_file_name(entry.file_name()))
        .filter(has_extension)
        .collect();
    files.sort_unstable();
    files
}

pub(super) fn refused_from_memory(other: &Path) -> Error {
    let message = format!("bytes in memory cannot refer to the file \"{}\"", other.display());
    Diagnostic::new(Code::MissingFile, message)
        .help("import the file by its path, or name the second file")
        .into()
}
