//! The files that this process, or a process whose work it continues, has written since it was confined. A confined
//! process replaces no other files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use serde::{Deserialize, Serialize};

use super::confined::is_confined;
use super::file_id::FileId;

/// Written files, by their real paths.
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

/// The function that receives each file that this process writes. It is called before the process may end.
static HEARS: OnceLock<fn(OwnFiles)> = OnceLock::new();

/// Continues the work of other processes. Their files count as written by this process. `hears` is called with each
/// file that this process writes.
#[doc(hidden)]
pub fn go_on(others: OwnFiles, hears: fn(OwnFiles)) {
    WRITTEN.lock().unwrap_or_else(PoisonError::into_inner).extend(others);
    let _ = HEARS.set(hears);
}

/// The reason why a confined process does not replace a file.
pub(super) const OF_OTHERS: &str = "the file exists, and this process has not written it";

/// Notes a written file if the process is confined.
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

/// Whether this process is confined and has written the file at `path`. A link does not count.
pub(super) fn has_written(path: &Path) -> bool {
    is_confined() && !path.is_symlink() && is_noted(path)
}

/// Whether this process is confined, and another program has put something at `path`.
pub(super) fn is_of_others(path: &Path) -> bool {
    is_confined() && path.symlink_metadata().is_ok() && !has_written(path)
}

/// Whether the file at `path` is a written file. If another program has replaced the file, its id differs.
fn is_noted(path: &Path) -> bool {
    let written = WRITTEN.lock().unwrap_or_else(PoisonError::into_inner);
    let noted = fs::canonicalize(path).ok().and_then(|real| written.0.get(&real));
    noted.is_some_and(|noted| FileId::of(path).as_ref() == Some(noted))
}
