//! A large file that is read block by block, and completely only if a reader requests that.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::ops::Deref;
use std::sync::{Mutex, MutexGuard, OnceLock};

use memmap2::MmapMut;
use mocap_formats::{Blocks, Failure};
use mocap_scene::error::{Code, Diagnostic};

use super::sha256::Sha256Sum;

/// Bytes at the beginning of the file, which are always in memory.
pub const BEGINNING: u64 = 1 << 20;

/// Bytes of a block: small enough that the block is still in the second-level cache for hashing and parsing.
pub const BLOCK: u64 = 1 << 18;

pub struct LargeFile {
    beginning: Vec<u8>,
    size: u64,
    /// The number of bytes in a block.
    block: u64,
    state: Mutex<State>,
    pub whole: OnceLock<Pages>,
}

struct State {
    file: File,
    /// The hash of the bytes that were read so far.
    sum: Option<Sha256Sum>,
    position: u64,
    failure: Option<io::Error>,
}

/// The first bytes, in large memory pages. Filling large pages takes half as long as filling small pages.
pub struct Pages {
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
    pub fn new(file: File, size: u64) -> io::Result<Self> {
        Self::with_lengths(file, size, BEGINNING, BLOCK)
    }

    pub fn with_lengths(file: File, size: u64, beginning_length: u64, block: u64) -> io::Result<Self> {
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
    pub fn beginning(&self) -> &[u8] {
        &self.beginning
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().expect("nothing panics while it holds this lock")
    }

    /// Starts the hash of the bytes that were read and of the bytes to come.
    pub(super) fn start_hash(&self) {
        let mut sum = Sha256Sum::default();
        sum.add(&self.beginning);
        self.state().sum = Some(sum);
    }

    /// The hash of the whole file, if [`Self::start_hash`] was called.
    pub(super) fn finish_hash(&self) -> io::Result<String> {
        let mut state = self.state();
        // Reads the rest of the file if the reader did not need it.
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
            // This cannot fail: the cell is empty, and the lock is held.
            let _ = self.whole.set(whole);
        }
        Ok(self.whole.get().map_or(&[], |whole| whole))
    }

    /// The error that stopped reading. A [`Failure`] has only the message of the error.
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
    /// Appends at most `length` further bytes of a file of `size` bytes.
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

/// The remaining bytes of a file of `size` bytes. If the size changes during reading, returns the bytes that the file
/// then has.
fn read_pages(mut file: &File, size: u64) -> io::Result<Pages> {
    // Reading one byte more finds the end of the file.
    let capacity = usize::try_from(size).unwrap_or(usize::MAX).saturating_add(1);
    let mut memory = MmapMut::map_anon(capacity)?;
    // The system may ignore this advice.
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
