//! The files that this process has written since it was confined: it replaces no others.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use super::confined::is_confined;
use super::existing::FileId;

/// The files by their real paths.
static WRITTEN: Mutex<BTreeMap<PathBuf, FileId>> = Mutex::new(BTreeMap::new());

/// Why a confined process does not replace a file.
pub(super) const OF_OTHERS: &str = "the file exists, and this process has not written it";

/// Notes a file that was written, where the process is confined.
pub(super) fn note(path: &Path) {
    if !is_confined() {
        return;
    }
    if let (Ok(real), Some(id)) = (fs::canonicalize(path), FileId::of(path)) {
        WRITTEN.lock().unwrap_or_else(PoisonError::into_inner).insert(real, id);
    }
}

/// Whether this process is confined and has written the file at `path`. A link is not what it has written.
pub(super) fn has_written(path: &Path) -> bool {
    is_confined() && !path.is_symlink() && is_noted(path)
}

/// Whether this process is confined, and somebody else has put something at `path`.
pub(super) fn is_of_others(path: &Path) -> bool {
    is_confined() && path.symlink_metadata().is_ok() && !has_written(path)
}

/// A file that another program has put in place of the written one has another id.
fn is_noted(path: &Path) -> bool {
    let written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    let noted = fs::canonicalize(path).ok().and_then(|real| written.get(&real));
    noted.is_some_and(|noted| FileId::of(path).as_ref() == Some(noted))
}
