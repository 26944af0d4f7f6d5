//! The bytes of a file: read where it is small, mapped into memory where it is large.

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
        // SAFETY: the mapping is private and read-only, so nothing in this process writes to it, and it keeps the
        // pages alive until it is dropped. What no program can rule out is that another one changes the file
        // meanwhile. Readers here take bytes for no more than bytes: text that changes under them may give an error or
        // other numbers, as it may with reads. A file that is cut short meanwhile ends the process with SIGBUS; that is
        // the price of not holding a second copy of large files, and `Importer::read` does not pay it.
        #[allow(unsafe_code, reason = "a mapping cannot be had without")]
        let map = unsafe { Mmap::map(&file)? };
        Ok(Self::Mapped(map))
    }

    /// Lets the pages that lie within a range of bytes go. They are read from the file again if they are looked at.
    pub(super) fn release(&self, range: Range<usize>) {
        #[cfg(unix)]
        if let Self::Mapped(map) = self {
            // SAFETY: `DontNeed` drops what was written to pages, and nothing writes to these.
            #[allow(unsafe_code, reason = "the only way to give pages back")]
            let released =
                unsafe { map.unchecked_advise_range(memmap2::UncheckedAdvice::DontNeed, range.start, range.len()) };
            // It is advice: memory stays in use where it is not taken.
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
