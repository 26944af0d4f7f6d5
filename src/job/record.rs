//! The record of a user's outputs. With the record, commands recognise outputs of earlier commands, even in formats
//! without metadata, such as BVH.

use std::env;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mocap_scene::files::record_outputs;
use sha2::{Digest, Sha256};

/// Starts recording. From now on, this process notes each output in the user's record. The process may replace recorded
/// outputs that are unchanged, and passes the path of each replaced file to `replaced`.
///
/// The program and the Python package call this function once, at their start. Without this call, the library only
/// writes files that its caller names.
///
/// The record is `mocap/outputs.jsonl` in `$XDG_STATE_HOME`. If this variable is not set, the folder is
/// `~/.local/state`, on macOS `~/Library/Application Support`, on Windows `%LOCALAPPDATA%`. The record has at most 16
/// MiB. If the folder is not writable, nothing is recorded and nothing fails. After
/// [`confine`](mocap_scene::files::confine) the record is not used.
///
/// ```no_run
/// mocap::job::remember_outputs(|path| eprintln!("{}: replaced", path.display()));
/// ```
pub fn remember_outputs(replaced: fn(&Path)) {
    if let Some(folder) = state_folder() {
        record_outputs(folder.join("mocap"), sha256, replaced);
    }
}

/// The folder for program state. The XDG specification requires that relative paths are ignored.
fn state_folder() -> Option<PathBuf> {
    let folder = |name: &str| {
        env::var_os(name)
            .map(PathBuf::from)
            .filter(|folder| folder.is_absolute())
    };
    let below_home = |below: &str| Some(folder("HOME")?.join(below));
    let of_system = || match env::consts::OS {
        "windows" => folder("LOCALAPPDATA"),
        "macos" => below_home("Library/Application Support"),
        _ => below_home(".local/state"),
    };
    folder("XDG_STATE_HOME").or_else(of_system)
}

/// The number of bytes, and their SHA-256.
fn sha256(contents: &mut dyn Read) -> io::Result<(u64, String)> {
    let mut hasher = Sha256::new();
    let bytes = io::copy(contents, &mut hasher)?;
    Ok((bytes, format!("{:x}", hasher.finalize())))
}
