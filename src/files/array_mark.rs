//! The mark of archives and pickles of this program, by which an output is told from somebody's arrays.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Stands in the comment of an `.npz`, which ends it, and in a text that a `.pkl` begins with and forgets.
pub(crate) const ARRAY_MARK: &str = "mocap arrays";

/// The files that have it.
pub(super) const MARKED_EXTENSIONS: &[&str] = &["npz", "pkl"];

/// Bytes at each end of a file in which the mark stands.
const SEARCHED: usize = 32;

/// Whether the file begins or ends with the mark.
pub(super) fn has_mark(path: &Path) -> bool {
    let ends = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        let mut ends = Vec::new();
        file.by_ref().take(SEARCHED as u64).read_to_end(&mut ends)?;
        file.seek(SeekFrom::Start(length.saturating_sub(SEARCHED as u64)))?;
        file.take(SEARCHED as u64).read_to_end(&mut ends)?;
        Ok(ends)
    };
    ends().is_ok_and(|ends| memchr::memmem::find(&ends, ARRAY_MARK.as_bytes()).is_some())
}
