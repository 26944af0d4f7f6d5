//! A user's record of outputs: a file of JSON lines, each with the path of an output, its size, its hash and the names
//! of its inputs.
//!
//! One system call appends a line, so that several processes can write at once. A line that cannot be read is ignored.

use std::collections::{HashMap, HashSet};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

/// The size of the file in bytes above which outdated lines are removed.
const MOST: u64 = 8 << 20;

/// The largest accepted length of a line in bytes.
const LONGEST_LINE: usize = 64 << 10;

/// Returns the number of readable bytes, and their SHA-256 as text.
pub(crate) type Hash = fn(&mut dyn Read) -> io::Result<(u64, String)>;

/// The record's knowledge of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordState {
    /// The record does not know the file.
    Unknown,
    /// The file was an output, and its contents have changed.
    Changed {
        /// Whether the file is shorter than the record states.
        is_shorter: bool,
    },
    /// The file is an unchanged output; the value has the names of its inputs.
    Unchanged(Vec<String>),
}

#[derive(Serialize, Deserialize)]
struct Line {
    path: String,
    bytes: u64,
    sha256: String,
    /// The names of the inputs.
    #[serde(default)]
    from: Vec<String>,
}

/// The record in a folder. It stores paths without links.
pub struct UserRecord {
    folder: PathBuf,
    hash: Hash,
    is_usable: OnceLock<bool>,
    known: Mutex<RecordContent>,
}

/// The record as read so far.
#[derive(Default)]
struct RecordContent {
    /// The lines of each path, newest last.
    lines: HashMap<String, Vec<Line>>,
    /// The number of bytes read.
    read: u64,
    /// The time when lines were last moved to the older file.
    moved: Option<SystemTime>,
}

impl UserRecord {
    /// The record in `folder`, which need not exist.
    pub fn new(folder: PathBuf, hash: Hash) -> Self {
        Self {
            folder,
            hash,
            is_usable: OnceLock::new(),
            known: Mutex::default(),
        }
    }

    fn file(&self) -> PathBuf {
        self.folder.join("outputs.jsonl")
    }

    /// The file of lines that were moved and are still valid.
    fn older(&self) -> PathBuf {
        self.folder.join("outputs.older.jsonl")
    }

    /// Opens the file to append a line.
    fn open(&self) -> io::Result<File> {
        let path = self.file();
        // Opening a pipe could block until it has a reader.
        if fs::metadata(&path).is_ok_and(|found| !found.is_file()) {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        let mut options = OpenOptions::new();
        options.append(true).create(true);
        private(&mut options).open(path)
    }

    /// Creates the folder and the file.
    fn prepare(&self) -> io::Result<()> {
        let mut builder = fs::DirBuilder::new();
        builder.recursive(true);
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        builder.create(&self.folder)?;
        let mut file = self.open()?;
        // A full disk may have cut off the last line. The next line must not continue it.
        let mut last = [b'\n'];
        let mut reader = File::open(self.file())?;
        if reader.seek(SeekFrom::End(-1)).is_ok() {
            reader.read_exact(&mut last)?;
        }
        match last {
            [b'\n'] => Ok(()),
            _ => file.write_all(b"\n"),
        }
    }

    fn append(&self, line: &Line) -> io::Result<()> {
        let mut text = serde_json::to_string(line)?;
        text.push('\n');
        let mut file = self.open()?;
        if file.metadata()?.len() > MOST {
            self.compact()?;
            file = self.open()?;
        }
        file.write_all(text.as_bytes())
    }

    /// Moves the valid lines to the older file, which keeps the newest of them. Another process that appends a line
    /// meanwhile writes to the moved file or to a new one. If two processes do this at once, lines may be lost, and
    /// their outputs are then unknown.
    fn compact(&self) -> io::Result<()> {
        // Another process may have moved the lines in the meantime, so check the size again.
        if fs::metadata(self.file())?.len() <= MOST {
            return Ok(());
        }
        let moved = self.folder.join("outputs.moved.jsonl");
        fs::rename(self.file(), &moved)?;
        let texts = [read_from(&self.older(), 0), read_from(&moved, 0)].map(Result::unwrap_or_default);
        let mut newest: Vec<&str> = Vec::new();
        let mut seen = HashSet::new();
        let mut bytes = 0;
        let lines: Vec<&str> = texts.iter().flat_map(|text| lines(text)).collect();
        for text in lines.into_iter().rev() {
            let path = serde_json::from_str::<Line>(text).map(|line| line.path);
            if path.is_ok_and(|path| seen.insert(path)) {
                bytes += text.len() as u64 + 1;
                if bytes > MOST {
                    break;
                }
                newest.push(text);
            }
        }
        newest.reverse();
        let mut older = tempfile::NamedTempFile::new_in(&self.folder)?;
        newest.iter().try_for_each(|text| writeln!(older, "{text}"))?;
        older.persist(self.older())?;
        fs::remove_file(moved)
    }

    /// Whether outputs can be recorded: the folder can be written.
    pub fn is_usable(&self) -> bool {
        *self.is_usable.get_or_init(|| self.prepare().is_ok())
    }

    /// Records that the file at `path` gets these contents, made from files named `sources`. Skips files that cannot be
    /// recorded.
    pub fn note(&self, path: &Path, contents: &mut dyn Read, sources: &[&str]) {
        let Some(path) = path.to_str().filter(|_| self.is_usable()) else {
            return;
        };
        if let Ok((bytes, sha256)) = (self.hash)(contents) {
            let line = Line {
                path: path.to_owned(),
                bytes,
                sha256,
                from: sources.iter().map(|&name| name.to_owned()).collect(),
            };
            // Later commands do not know a file that is not recorded, and refuse to replace it without `force`.
            let _ = self.append(&line);
        }
    }

    /// Looks up the file at `path`. A killed process may have recorded an output that it did not write, so any line of
    /// the path may describe the file.
    pub fn find(&self, path: &Path) -> RecordState {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.catch_up(self);
        let lines = path.to_str().and_then(|path| known.lines.get(path));
        let Some((newest, lines)) = lines.and_then(|lines| Some((lines.last()?, lines))) else {
            return RecordState::Unknown;
        };
        let length = fs::metadata(path).map_or(0, |found| found.len());
        let sha256 = match lines.iter().any(|line| line.bytes == length) {
            true => File::open(path).and_then(|mut file| (self.hash)(&mut file)),
            false => Ok((length, String::new())),
        };
        let is_same =
            |line: &&Line| line.bytes == length && sha256.as_ref().is_ok_and(|(_, found)| *found == line.sha256);
        match lines.iter().rev().find(is_same) {
            Some(line) => RecordState::Unchanged(line.from.clone()),
            None => RecordState::Changed {
                is_shorter: length < newest.bytes,
            },
        }
    }
}

impl RecordContent {
    /// Reads the lines that this or another process has appended since the last reading.
    fn catch_up(&mut self, record: &UserRecord) {
        let file = record.file();
        let length = fs::metadata(&file).map_or(0, |found| found.len());
        let moved = fs::metadata(record.older()).and_then(|older| older.modified()).ok();
        if length < self.read || moved != self.moved {
            // The file is new, and its former lines are in the older file.
            *self = Self {
                moved,
                ..Self::default()
            };
            self.take(&read_from(&record.older(), 0).unwrap_or_default());
        }
        if length > self.read
            && let Ok(bytes) = read_from(&file, self.read)
        {
            self.read += bytes.len() as u64;
            self.take(&bytes);
        }
    }

    fn take(&mut self, bytes: &[u8]) {
        for line in lines(bytes).filter_map(|text| serde_json::from_str::<Line>(text).ok()) {
            self.lines.entry(line.path.clone()).or_default().push(line);
        }
    }
}

/// The lines that may be records.
fn lines(bytes: &[u8]) -> impl DoubleEndedIterator<Item = &str> {
    let lines = bytes.split(|byte| *byte == b'\n');
    lines.filter_map(|line| str::from_utf8(line).ok().filter(|line| line.len() <= LONGEST_LINE))
}

/// The bytes of a regular file from an offset, up to a fixed limit.
fn read_from(path: &Path, offset: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    if fs::metadata(path)?.is_file() {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(offset))?;
        file.take(2 * MOST).read_to_end(&mut bytes)?;
    }
    Ok(bytes)
}

/// Makes a new file readable only by its user, because the record has the names of the user's files.
fn private(options: &mut OpenOptions) -> &mut OpenOptions {
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(options, 0o600);
    options
}
