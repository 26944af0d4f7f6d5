//! Opens input files: their sizes are checked, and large ones are mapped into memory.

use std::fs::{self, File};
use std::io;
use std::ops::{Deref, Range};
use std::path::{Path, PathBuf};

use memmap2::Mmap;

use crate::error::{Code, Diagnostic, Error, Result};
use crate::limits::Limits;

/// Bytes from which on a file is mapped and worth a second thread.
pub(super) const LARGE: usize = 4 << 20;

/// A file's bytes.
pub(super) enum Contents {
    Read(Vec<u8>),
    Mapped(Mmap),
}

impl Contents {
    /// The contents of a file of `size` bytes.
    fn of(path: &Path, size: u64) -> io::Result<Self> {
        if size < LARGE as u64 {
            return fs::read(path).map(Self::Read);
        }
        let file = File::open(path)?;
        if !file.metadata()?.is_file() {
            return fs::read(path).map(Self::Read);
        }
        // SAFETY: the mapping is private and read-only, so nothing in this process writes to it, and it keeps the pages
        // alive until it is dropped. Another program may change the file meanwhile. The readers make no assumption
        // about bytes that they read twice, so changed text gives an error or other numbers, as it may with reads. A
        // file that is truncated meanwhile ends the process with SIGBUS; that is the cost of not holding a second copy
        // of large files, and `Importer::read` avoids it.
        #[allow(unsafe_code, reason = "a mapping cannot be had without")]
        let map = unsafe { Mmap::map(&file)? };
        Ok(Self::Mapped(map))
    }

    /// Releases the pages within a range of bytes. They are read from the file again on the next access.
    pub(super) fn release(&self, range: Range<usize>) {
        #[cfg(unix)]
        if let Self::Mapped(map) = self {
            // SAFETY: `DontNeed` drops what was written to pages, and nothing writes to these.
            #[allow(unsafe_code, reason = "the only way to give pages back")]
            let released =
                unsafe { map.unchecked_advise_range(memmap2::UncheckedAdvice::DontNeed, range.start, range.len()) };
            // It is only advice; the system may ignore it.
            drop(released);
        }
        #[cfg(not(unix))]
        let _ = range;
    }
}

impl Deref for Contents {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Self::Read(bytes) => bytes,
            Self::Mapped(map) => map,
        }
    }
}

/// The bytes of a file, if there are not more than the limits allow.
pub(super) fn open(path: &Path, limits: &Limits) -> Result<Vec<u8>> {
    checked_size(path, limits)?;
    fs::read(path).map_err(|error| Error::io(path, error))
}

/// The bytes of a file, where they need not all be in memory.
pub(super) fn look_into(path: &Path, limits: &Limits) -> Result<Contents> {
    let size = checked_size(path, limits)?;
    Contents::of(path, size).map_err(|error| Error::io(path, error))
}

fn checked_size(path: &Path, limits: &Limits) -> Result<u64> {
    let size = fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
    check_size(size, path, limits)?;
    Ok(size)
}

pub(super) fn check_size(size: u64, path: &Path, limits: &Limits) -> Result<()> {
    let limit = limits.max_bytes;
    if size <= limit {
        return Ok(());
    }
    let diagnostic = Diagnostic::new(Code::LimitExceeded, "the file is larger than Limits::max_bytes")
        .expected_found(format!("at most {limit} bytes"), format!("{size} bytes"));
    Err(Error::from(diagnostic).with_path(path))
}

/// The files beside `path` that have this extension, in any case, sorted by name. A folder that cannot be listed has
/// none: whoever asks says what is missing.
pub(super) fn list_siblings(path: &Path, extension: &str) -> Vec<PathBuf> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let has_extension = |file: &PathBuf| {
        file.extension()
            .is_some_and(|found| found.eq_ignore_ascii_case(extension))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .map(|entry| path.with_file_name(entry.file_name()))
        .filter(has_extension)
        .collect();
    files.sort();
    files
}

pub(super) fn refused_from_memory(other: &Path) -> Error {
    let message = format!("bytes in memory cannot refer to the file \"{}\"", other.display());
    Diagnostic::new(Code::MissingFile, message)
        .help("import the file by its path, or name the second file")
        .into()
}
