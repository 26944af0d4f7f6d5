//! The record of outputs, which outlives the process. With the record, a command recognises the outputs of earlier
//! commands. Without a call of [`record_outputs`] there is no record.

pub(crate) mod user;

use std::collections::HashSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

pub(super) use self::user::RecordState;
use self::user::{Hash, UserRecord};
use super::confined::is_confined;
use super::{Target, folder_of};

static RECORD: OnceLock<UserRecord> = OnceLock::new();

/// The function that is called with each output that replaced an earlier output.
static REPLACED: Mutex<Option<fn(&Path)>> = Mutex::new(None);

/// The paths of earlier outputs that a policy allows to be replaced. A path is removed once a new output has replaced
/// it.
static REPLACEABLE: Mutex<Option<HashSet<PathBuf>>> = Mutex::new(None);

/// From now on this process records its outputs in `folder`, and replaces outputs that the record knows. It passes the
/// path of each replaced output to `replaced`. The setting is permanent; a second call only changes `replaced`.
#[doc(hidden)]
pub fn record_outputs(folder: PathBuf, hash: Hash, replaced: fn(&Path)) {
    RECORD.get_or_init(|| UserRecord::new(folder, hash));
    *REPLACED.lock().unwrap_or_else(PoisonError::into_inner) = Some(replaced);
}

/// The record. A [confined](super::confine) process has none: it writes nothing outside of its folder, and replaces
/// only its own files.
fn record() -> Option<&'static UserRecord> {
    RECORD.get().filter(|_| !is_confined())
}

/// Whether a file that the record does not know is surely not an output.
pub(super) fn is_complete() -> bool {
    record().is_some_and(UserRecord::is_usable)
}

/// Records a complete file just before it gets the name `target`. If the process is killed in between, the record names
/// a missing file, which does no harm. If the file were recorded later, it could remain unknown.
pub(super) fn note(target: &Path, contents: impl FnOnce() -> io::Result<Box<dyn Read>>, sources: &[&str]) {
    let noted = record().zip(real_path(target));
    if let Some((record, path)) = noted
        && let Ok(mut contents) = contents()
    {
        record.note(&path, &mut contents, sources);
    }
}

/// Records the file `made` just before it gets the name `below` in `folder`.
pub(super) fn note_below(folder: &Path, below: &Path, made: &Path) {
    if let Some((record, path)) = record().zip(real_path(folder))
        && let Ok(mut contents) = File::open(made)
    {
        record.note(&path.join(below), &mut contents, &[]);
    }
}

/// The record's knowledge of the file that an output at `path` would replace.
pub(super) fn find(path: &Path) -> RecordState {
    let Ok(Target::File(target)) = Target::of(path) else {
        return RecordState::Unknown;
    };
    let found = record().zip(real_path(&target));
    found.map_or(RecordState::Unknown, |(record, path)| record.find(&path))
}

fn real_path(target: &Path) -> Option<PathBuf> {
    let name: &OsStr = target.file_name()?;
    Some(fs::canonicalize(folder_of(target)).ok()?.join(name))
}

/// Records that the file at `path` is an earlier output, which a new output may replace. If `sources` is set, both
/// outputs were made from these sources.
pub(super) fn may_replace(path: &Path, sources: Option<&[&str]>) {
    if let Some(record) = record() {
        // A process may be killed after it recorded an output and before it renamed the file. Then the existing file
        // must not look like an output that a user has changed.
        if let Some(sources) = sources
            && find(path) == RecordState::Unknown
            && let Ok(Target::File(target)) = Target::of(path)
            && let Some((path, mut earlier)) = real_path(&target).zip(File::open(&target).ok())
        {
            record.note(&path, &mut earlier, sources);
        }
        let mut paths = REPLACEABLE.lock().unwrap_or_else(PoisonError::into_inner);
        paths.get_or_insert_default().insert(path.to_owned());
    }
}

/// Reports a written output if it replaced an earlier output.
pub(super) fn written(path: &Path) {
    let mut paths = REPLACEABLE.lock().unwrap_or_else(PoisonError::into_inner);
    if paths.as_mut().is_some_and(|paths| paths.remove(path)) {
        drop(paths);
        replaced(path);
    }
}

/// Reports an output that replaced an earlier output.
pub(super) fn replaced(path: &Path) {
    let replaced = *REPLACED.lock().unwrap_or_else(PoisonError::into_inner);
    replaced.into_iter().for_each(|replaced| replaced(path));
}
