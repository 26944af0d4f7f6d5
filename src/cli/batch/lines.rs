//! Files of lines that a run extends while it works, so that a killed run loses at most one line.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;

/// A file that grows by whole lines.
pub(super) struct Lines {
    file: File,
    /// The length of the file, in bytes.
    bytes: u64,
}

impl Lines {
    /// Opens a file, or creates it, and keeps its first `bytes` bytes.
    pub(super) fn open(path: &Path, bytes: u64) -> io::Result<Self> {
        let file = OpenOptions::new().create(true).append(true).open(path)?;
        file.set_len(bytes)?;
        Ok(Self { file, bytes })
    }

    /// Appends complete lines.
    pub(super) fn append(&mut self, lines: &str) -> io::Result<()> {
        if let Err(error) = self.file.write_all(lines.as_bytes()) {
            // Writing has failed, so remove the partial line.
            let _ = self.file.set_len(self.bytes);
            return Err(error);
        }
        self.bytes += lines.len() as u64;
        Ok(())
    }
}

/// Refuses to replace a file of another kind. A file of this kind begins with `start`. A killed run may leave only the
/// first bytes of `start`.
pub(super) fn check_start(path: &Path, start: &[u8], refusal: impl Fn() -> io::Error) -> io::Result<()> {
    let Some(file) = open(path, &refusal)? else {
        return Ok(());
    };
    let mut found = Vec::new();
    file.take(start.len() as u64).read_to_end(&mut found)?;
    match start.starts_with(&found) {
        true => Ok(()),
        false => Err(refusal()),
    }
}

/// Opens a file to read it; `None` if there is no file. A pipe would block the program, and a device may have no end.
pub(super) fn open(path: &Path, refusal: impl Fn() -> io::Error) -> io::Result<Option<File>> {
    match fs::metadata(path) {
        Ok(found) if found.is_file() => File::open(path).map(Some),
        Ok(_) => Err(refusal()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}
