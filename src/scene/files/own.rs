//! The files that this process, or those whose work it goes on with, has written since it was confined: it replaces no
//! others.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use serde::{Deserialize, Serialize};

use super::confined::is_confined;
use super::file_id::FileId;

/// Files that were written, by their real paths.
#[doc(hidden)]
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OwnFiles(BTreeMap<PathBuf, FileId>);

impl OwnFiles {
    /// Adds the files of another process.
    pub fn extend(&mut self, others: Self) {
        self.0.extend(others.0);
    }
}

static WRITTEN: Mutex<OwnFiles> = Mutex::new(OwnFiles(BTreeMap::new()));

/// Hears of each file that this process writes, before it may end.
static HEARS: OnceLock<fn(OwnFiles)> = OnceLock::new();

/// Continues the work of other processes. Their files count as written by this one, and `hears` gets each file that
/// this one writes.
#[doc(hidden)]
pub fn go_on(others: OwnFiles, hears: fn(OwnFiles)) {
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner).extend(others);
    let _ = HEARS.set(hears);
}

/// Why a confined process does not replace a file.
pub(super) const OF_OTHERS: &str = "the file exists, and this process has not written it";

/// Notes a file that was written, where the process is confined.
pub(super) fn note(path: &Path) {
    if !is_confined() {
        return;
    }
    if let (Ok(real), Some(id)) = (fs::canonicalize(path), FileId::of(path)) {
        let file = OwnFiles(BTreeMap::from([(real, id)]));
        if let Some(hears) = HEARS.get() {
            hears(file.clone());
        }
        WRITTEN.lock().unwrap_or_else(PoisonError::into_inner).extend(file);
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
    let noted = fs::canonicalize(path).ok().and_then(|real| written.0.get(&real));
    noted.is_some_and(|noted| FileId::of(path).as_ref() == Some(noted))
}
