//! The record of a user's outputs: by it a command knows the outputs of earlier commands, also in formats that have no
//! place for a mark, such as BVH.

use std::env;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mocap_scene::files::record_outputs;
use sha2::{Digest, Sha256};

/// From now on this process notes each output that it writes in the record of the user. It replaces outputs that the
/// record knows, where nobody has changed them since, and passes the path of each to `replaced`.
///
/// The program and the Python package call it once, at their start. A library does nothing of this unasked: without
/// this call it writes no file that its caller has not named.
///
/// The record is `mocap/outputs.jsonl` in `$XDG_STATE_HOME`, or where that is not set: in `~/.local/state`, on macOS in
/// `~/Library/Application Support`, on Windows in `%LOCALAPPDATA%`. It takes at most 16 MiB. Without a folder that can
/// be written nothing is noted, and nothing fails. Behind [`confine`](mocap_scene::files::confine) it is not used.
///
/// ```no_run
/// mocap::job::remember_outputs(|path| eprintln!("{}: replaced", path.display()));
/// ```
pub fn remember_outputs(replaced: fn(&Path)) {
    if let Some(folder) = state_folder() {
        record_outputs(folder.join("mocap"), sha256, replaced);
    }
}

/// The folder for the state of programs. The specification of XDG ignores a path that is not absolute.
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
