//! The bytes of a file: read if it is small, mapped into memory if it is large.

use std::fs::{self, File};
use std::io;
use std::ops::{Deref, Range};
use std::path::Path;

use memmap2::Mmap;

use super::LARGE;

/// A file's bytes.
pub(super) enum Contents {
    Read(Vec<u8>),
    Mapped(Mmap),
}

impl Contents {
    /// The contents of a file of `size` bytes.
    pub(super) fn of(path: &Path, size: u64) -> io::Result<Self> {
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
