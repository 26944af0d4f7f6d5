//! `-` as a file: standard input, and standard output.

use std::io::{self, Write};
use std::path::Path;
use std::sync::OnceLock;

use mocap::files::{ReplacePolicy, remove_unfinished, write_file};
use mocap::{Importer, Scene};

use crate::{Failure, report};

/// Whether a path stands for standard input or standard output.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Imports a file or standard input, which is read once however often it is imported.
pub(crate) fn import(importer: &Importer, path: &Path) -> mocap::Result<Scene> {
    static INPUT: OnceLock<Vec<u8>> = OnceLock::new();
    if !is_standard(path) {
        return importer.import(path);
    }
    let bytes = match INPUT.get() {
        Some(bytes) => bytes,
        None => {
            let bytes = importer.read_stream(io::stdin().lock(), path)?;
            INPUT.get_or_init(|| bytes)
        }
    };
    importer.read(bytes, path)
}

/// Refuses an output that would replace an input or a file that may be a source.
pub(crate) fn check_output<P: AsRef<Path>>(inputs: &[P], output: &Path) -> mocap::Result<()> {
    if is_standard(output) {
        return Ok(());
    }
    ReplacePolicy::new(inputs).check(output)
}

/// Writes a file, of which a killed process may have left a part, or to standard output.
pub(crate) fn write(output: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if !is_standard(output) {
        remove_unfinished(output);
        return Ok(write_file(output, bytes)?);
    }
    // Data, and not for a terminal to interpret: what of it could steer one is shown by `report::stdout`.
    let mut out = report::stdout();
    out.write_all(bytes)?;
    Ok(out.flush()?)
}
