//! A large file that is read block by block, and whole only where a reader asks for that.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::ops::Deref;
use std::sync::{Mutex, MutexGuard, OnceLock};

use memmap2::MmapMut;
use mocap_formats::{Blocks, Failure};
use mocap_scene::error::{Code, Diagnostic};

use super::sha256::Sha256Sum;

/// Bytes of the beginning, which is always in memory.
const BEGINNING: u64 = 1 << 20;

/// Bytes of a block: few enough that it is still in the second-level cache when it is hashed and its numbers are read.
const BLOCK: u64 = 1 << 18;

pub(super) struct LargeFile {
    beginning: Vec<u8>,
    size: u64,
    /// Bytes of a block.
    block: u64,
    state: Mutex<State>,
    whole: OnceLock<Pages>,
}

struct State {
    file: File,
    /// Of the bytes that were read so far.
    sum: Option<Sha256Sum>,
    position: u64,
    failure: Option<io::Error>,
}

/// The first bytes of memory in large pages, which take half the time to fill.
struct Pages {
    memory: MmapMut,
    length: usize,
}

impl Deref for Pages {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.memory[..self.length]
    }
}

impl LargeFile {
    /// A file of `size` bytes.
    pub(super) fn new(file: File, size: u64) -> io::Result<Self> {
        Self::with_lengths(file, size, BEGINNING, BLOCK)
    }

    fn with_lengths(file: File, size: u64, beginning_length: u64, block: u64) -> io::Result<Self> {
        let mut beginning = Vec::new();
        (&file).take(beginning_length).read_to_end(&mut beginning)?;
        Ok(Self {
            state: Mutex::new(State {
                file,
                sum: None,
                position: beginning.len() as u64,
                failure: None,
            }),
            beginning,
            size,
            block,
            whole: OnceLock::new(),
        })
    }

    /// The bytes before the first block.
    pub(super) fn beginning(&self) -> &[u8] {
        &self.beginning
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("nothing panics while it holds this lock")
    }

    /// Hashes what was read, and what will be.
    pub(super) fn start_hash(&self) {
        let mut sum = Sha256Sum::default();
        sum.add(&self.beginning);
        self.state().sum = Some(sum);
    }

    /// The hash of the whole file, if it was started.
    pub(super) fn finish_hash(&self) -> io::Result<String> {
        let mut state = self.state();
        // The rest, if the reader did not need it.
        let mut block = Vec::new();
        while self.whole.get().is_none() && state.read(&mut block, self.block, self.size)? > 0 {
            block.clear();
        }
        Ok(state.sum.take().map_or_else(String::new, Sha256Sum::finish))
    }

    /// All bytes of the file.
    pub(super) fn read_whole(&self) -> io::Result<&[u8]> {
        let mut state = self.state();
        if self.whole.get().is_none() {
            let whole = state.read_whole(self.size, &self.beginning)?;
            // It was empty, and the lock is held.
            let _ = self.whole.set(whole);
        }
        Ok(self.whole.get().map_or(&[], |whole| whole))
    }

    /// What prevented that the file was read, of which a [`Failure`] has only the message.
    pub(super) fn take_failure(&self) -> Option<io::Error> {
        self.state().failure.take()
    }

    fn keep<T>(&self, result: io::Result<T>) -> Result<T, Failure> {
        result.map_err(|failure| {
            let diagnostic = Diagnostic::new(Code::Io, failure.to_string());
            self.state().failure = Some(failure);
            Box::new(diagnostic)
        })
    }
}

impl State {
    /// Appends the next bytes, at most `length`, of a file of `size` bytes.
    fn read(&mut self, block: &mut Vec<u8>, length: u64, size: u64) -> io::Result<usize> {
        let before = block.len();
        block.reserve(usize::try_from(length).unwrap_or_default());
        let length = (&self.file).take(length).read_to_end(block)?;
        self.position += length as u64;
        if self.position > size {
            return Err(io::Error::other("the file grew while it was read"));
        }
        if let Some(sum) = &mut self.sum {
            sum.add(&block[before..]);
        }
        Ok(length)
    }

    fn read_whole(&mut self, size: u64, beginning: &[u8]) -> io::Result<Pages> {
        self.file.rewind()?;
        let whole = read_pages(&self.file, size)?;
        let position = usize::try_from(self.position).unwrap_or(usize::MAX);
        let is_same = whole.len() >= position
            && whole.starts_with(beginning)
            && (self.sum.as_ref()).is_none_or(|sum| sum.clone().finish() == Sha256Sum::of(&whole[..position]));
        if !is_same {
            return Err(io::Error::other("the file changed while it was read"));
        }
        if let Some(sum) = &mut self.sum {
            sum.add(&whole[position..]);
        }
        Ok(whole)
    }
}

impl Blocks for LargeFile {
    fn read(&self, block: &mut Vec<u8>) -> Result<usize, Failure> {
        let read = self.state().read(block, self.block, self.size);
        self.keep(read)
    }

    fn whole(&self) -> Result<&[u8], Failure> {
        self.keep(self.read_whole())
    }

    fn size(&self) -> usize {
        usize::try_from(self.size).unwrap_or(usize::MAX)
    }
}

/// The bytes of a file of `size` bytes from here on, or as many as there are when it is read.
fn read_pages(mut file: &File, size: u64) -> io::Result<Pages> {
    // A byte more finds the end of the file.
    let capacity = usize::try_from(size).unwrap_or(usize::MAX).saturating_add(1);
    let mut memory = MmapMut::map_anon(capacity)?;
    // It is only advice; the system may ignore it.
    #[cfg(target_os = "linux")]
    let _ = memory.advise(memmap2::Advice::HugePage);
    let mut length = 0;
    while length < capacity {
        match file.read(&mut memory[length..]) {
            Ok(0) => return Ok(Pages { memory, length }),
            Ok(more) => length += more,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other("the file grew while it was read"))
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;
    use std::fs;
    use std::path::Path;

    use super::*;
    use crate::import::Importer;
    use mocap_formats::Source;
    use mocap_scene::scene::Scene;

    /// More bytes than the beginning; `row` writes a row.
    fn take(row: impl Fn(usize) -> String) -> String {
        const ROWS: usize = 120_000;
        let mut text = String::from("HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\nMOTION\n");
        write!(text, "Frames: {ROWS}\nFrame Time: 0.1\n").unwrap();
        (0..ROWS).for_each(|index| text += &row(index));
        assert!(text.len() as u64 > BEGINNING + 2 * BLOCK);
        text
    }

    fn plain(index: usize) -> String {
        format!("{}.0000000000\n", index % 360)
    }

    /// Reads a file of `text`, on which `change` is called when its beginning was read.
    fn read(text: &str, change: impl Fn(&Path)) -> (mocap_scene::error::Result<Scene>, LargeFile) {
        let file = tempfile::NamedTempFile::with_suffix(".bvh").unwrap();
        fs::write(file.path(), text).unwrap();
        let large = LargeFile::new(File::open(file.path()).unwrap(), text.len() as u64).unwrap();
        change(file.path());
        (import(&large, 1), large)
    }

    fn import(large: &LargeFile, threads: usize) -> mocap_scene::error::Result<Scene> {
        let source = Source {
            bytes: large.beginning(),
            blocks: None,
            name: Path::new("take.bvh"),
            release: &|_| {},
            open: &|_| Err(Diagnostic::new(Code::MissingFile, "there is no other file").into()),
            list: &|_| Vec::new(),
        };
        Importer::new().threads(threads).read_large(large, &source)
    }

    /// Whatever the dialect, and wherever blocks end.
    #[test]
    fn every_fixture_is_read_as_from_memory() {
        const LARGEST: usize = 60_000;
        let (mut streamed, mut whole) = (0, 0);
        for folder in ["dialects", "broken", "real"] {
            for entry in fs::read_dir(Path::new("../../fixtures").join(folder)).unwrap() {
                let path = entry.unwrap().path();
                if path.extension().is_none_or(|extension| extension != "bvh") {
                    continue;
                }
                let mut bytes = fs::read(&path).unwrap();
                // The rows of longer ones end early, in some files in the middle of one.
                if bytes.len() > LARGEST {
                    let is_cut_in_a_row = bytes.len() % 3 == 0;
                    bytes.truncate(LARGEST);
                    if !is_cut_in_a_row {
                        bytes.truncate(1 + memchr::memrchr(b'\n', &bytes).unwrap_or(LARGEST));
                    }
                }
                let expected = Importer::new().threads(1).read(&bytes, "take.bvh");
                let copy = tempfile::NamedTempFile::new().unwrap();
                fs::write(copy.path(), &bytes).unwrap();
                for (beginning, block, threads) in [(1 << 20, 1 << 18, 2), (20_000, 1009, 1), (9_000, 300, 3)] {
                    let file = File::open(copy.path()).unwrap();
                    let large = LargeFile::with_lengths(file, bytes.len() as u64, beginning, block).unwrap();
                    match (import(&large, threads), &expected) {
                        (Ok(found), Ok(expected)) => assert!(found == *expected, "{path:?} {block}"),
                        (Err(found), Err(expected)) => assert_eq!(found.to_string(), expected.to_string(), "{path:?}"),
                        (found, _) => panic!("{path:?}: {:?}", found.map(|scene| scene.warnings)),
                    }
                    match large.whole.get() {
                        Some(_) => whole += 1,
                        None => streamed += 1,
                    }
                }
            }
        }
        assert!(streamed > 20 && whole > 20, "{streamed} {whole}");
    }

    #[test]
    fn plain_rows_are_not_held_in_memory() {
        let text = take(plain);
        let (scene, file) = read(&text, |_| {});
        assert!(file.whole.get().is_none());
        let scene = scene.unwrap();
        assert!(scene == Importer::new().read(text.as_bytes(), "take.bvh").unwrap());
        assert_eq!(scene.metadata.origin.unwrap().sha256, Sha256Sum::of(text.as_bytes()));
    }

    #[test]
    fn another_row_is_read_from_the_whole_text() {
        let text = take(|index| match index {
            110_000 => "nan\n".to_owned(),
            _ => plain(index),
        });
        let (scene, file) = read(&text, |_| {});
        assert!(file.whole.get().is_some());
        assert!(scene.unwrap() == Importer::new().read(text.as_bytes(), "take.bvh").unwrap());
    }

    #[test]
    fn a_file_that_changes_is_an_error_or_the_rows_that_are_left() {
        let text = take(plain);
        let shortened = read(&text, |path| {
            let open = File::options().write(true).open(path).unwrap();
            open.set_len(BEGINNING + BLOCK).unwrap();
        });
        let error = read(&text, |path| fs::write(path, text.replace("7.0", "x.0")).unwrap());
        let grown = read(&text, |path| fs::write(path, text.clone() + "1\n").unwrap());
        let scene = shortened.0.unwrap();
        assert_eq!(scene.warnings[0].code, Code::FrameCount);
        assert!(scene.animations[0].frame_count() > 50_000);
        for (result, message) in [
            (error.0, "the file changed while it was read"),
            (grown.0, "the file grew while it was read"),
        ] {
            let error = result.unwrap_err();
            assert_eq!((error.code(), error.diagnostic().message.as_str()), (Code::Io, message));
            assert!(std::error::Error::source(&error).is_some());
        }
    }
}
