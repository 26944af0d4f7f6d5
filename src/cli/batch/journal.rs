//! `OUTPUT.part`: the rows of a survey that has not finished, so that `--resume` continues a killed run.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use mocap::Error;
use mocap::survey::report::ClipRecord;

use super::lines::{self, Lines};

/// The rows of an unfinished run, as lines of a record. A finished run removes the file.
pub(crate) struct Journal {
    path: PathBuf,
    lines: Lines,
}

impl Journal {
    /// Opens the journal of the record `output`. Keeps the rows of a killed run if `is_resumed`, and returns them.
    pub(crate) fn open(output: &Path, is_resumed: bool) -> mocap::Result<(Self, Vec<ClipRecord>)> {
        let mut name = OsString::from(output);
        name.push(".part");
        let path = PathBuf::from(name);
        let failed = |error| Error::io(&path, error);
        let text = former(&path).map_err(failed)?;
        let kept = if is_resumed { text.as_str() } else { "" };
        let rows = kept.lines().filter_map(|line| ClipRecord::from_lines(line).ok());
        let clips = rows.flatten().collect();
        let lines = Lines::open(&path, kept.len() as u64).map_err(failed)?;
        Ok((Self { path, lines }, clips))
    }

    /// Appends the rows of a file.
    pub(crate) fn add(&mut self, clips: &[ClipRecord]) -> mocap::Result<()> {
        let rows: String = clips.iter().map(|clip| clip.to_line() + "\n").collect();
        let appended = self.lines.append(&rows);
        appended.map_err(|error| Error::io(&self.path, error))
    }

    /// Removes the file: the record has all rows.
    pub(crate) fn finish(self) -> mocap::Result<()> {
        fs::remove_file(&self.path).map_err(|error| Error::io(&self.path, error))
    }
}

/// The complete lines of a journal; none without a file. Refuses a file with other contents.
fn former(path: &Path) -> io::Result<String> {
    /// The start of every row, even of a row that a killed run has not finished.
    const START_OF_ROW: &[u8] = b"{\"file\":";
    lines::check_start(path, START_OF_ROW, not_a_journal)?;
    let mut text = Vec::new();
    if let Some(mut file) = lines::open(path, not_a_journal)? {
        file.read_to_end(&mut text)?;
    }
    // A killed run may have left a partial line.
    text.truncate(text.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1));
    String::from_utf8(text).map_err(|_| not_a_journal())
}

fn not_a_journal() -> io::Error {
    let message = "it is not the unfinished table of a survey; move it, or name another output";
    io::Error::new(io::ErrorKind::AlreadyExists, message)
}
