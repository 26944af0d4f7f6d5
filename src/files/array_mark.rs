//! The mark of archives, pickles and databases of this program, by which an output is told from somebody's arrays.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Stands in the comment of an `.npz`, which ends it, and in a text that a `.pkl` begins with and forgets.
pub(crate) const ARRAY_MARK: &str = "mocap arrays";

/// The first bytes of a database of motions, `.mdb`.
pub(crate) const DATABASE_MARK: &[u8; 8] = b"mocapMDB";

/// The files that have one of both.
pub(super) const MARKED_EXTENSIONS: &[&str] = &["npz", "pkl", "mdb"];

/// Bytes at each end of a file in which the mark stands.
const SEARCHED: usize = 32;

/// Whether the file begins with the mark of a database, or begins or ends with that of arrays.
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
    let is_ours =
        |ends: Vec<u8>| ends.starts_with(DATABASE_MARK) || memchr::memmem::find(&ends, ARRAY_MARK.as_bytes()).is_some();
    ends().is_ok_and(is_ours)
}
