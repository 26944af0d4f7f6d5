//! The file of a database, `.mdb`. All numbers are little-endian.
//!
//! | bytes | contents |
//! |---|---|
//! | 8 | `mocapMDB` |
//! | 4 | the version, 2 |
//! | 4 | the number of features of a frame, 27 |
//! | 8 | the length of the list in bytes |
//! | list | JSON with, for each clip: its row, its numbers of frames and samples, and the other data of the clip |
//! | 54 each | the features of the frames of all clips, as 16-bit floating-point numbers |
//! | 1 each | the contacts of these frames |
//! | 34 each | the samples of all clips |
//! | bytes | the packed clips (`.mclip`) of the clips whose motions the database has |
//! | 32 | the SHA-256 of all previous bytes |
//!
//! The reader reads blocks and allocates memory only for bytes that it has read, so that a wrong count costs no memory.
//! The list states how many bytes follow. More bytes are an error.

use std::io::{self, Read};

use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::DATABASE_MARK;
use mocap_scene::limits::Limits;
use mocap_scene::math::half;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::clip::{IndexedClip, has_leg_and_begin, is_plausible};
use super::database::Database;
use super::features::FEATURES;
use crate::survey::WIDTH;
use crate::survey::report::ClipRow;

const VERSION: u32 = 2;
/// The longest list, in bytes: some 100,000 clips.
const LONGEST_LIST: u64 = 1 << 28;
/// The most bytes of all packed clips.
const MOST_PACKED: u64 = 1 << 31;
/// The size of a block, in bytes.
const BLOCK: usize = 1 << 16;

/// The entry of a clip in the list.
#[derive(Serialize, Deserialize)]
struct Entry<Row> {
    row: Row,
    mirrored: bool,
    leg: f32,
    begin: f64,
    frames: u64,
    samples: u64,
    /// The size of the packed clip, in bytes; 0 if the database only refers to the file of the motion.
    packed: u64,
}

impl Database {
    /// The bytes of the file of the database.
    pub fn to_bytes(&self) -> Vec<u8> {
        let entry = |clip: &'_ IndexedClip| Entry {
            row: clip.row.clone(),
            mirrored: clip.mirrored,
            leg: clip.leg,
            begin: clip.begin,
            frames: clip.features.len() as u64,
            samples: (clip.samples.len() / WIDTH) as u64,
            packed: clip.packed.len() as u64,
        };
        let entries: Vec<Entry<ClipRow>> = self.clips.iter().map(entry).collect();
        let list = serde_json::to_vec(&entries).expect("rows have string keys and finite numbers");
        let packed: usize = self.clips.iter().map(|clip| clip.packed.len()).sum();
        let mut bytes = Vec::with_capacity(list.len() + 68 * self.frames() + packed + 128);
        bytes.extend_from_slice(DATABASE_MARK);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(&(FEATURES as u32).to_le_bytes());
        bytes.extend_from_slice(&(list.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&list);
        for value in self.features().flatten() {
            bytes.extend_from_slice(&half::to_half(*value).to_le_bytes());
        }
        for clip in &self.clips {
            bytes.extend_from_slice(&clip.contacts);
        }
        for clip in &self.clips {
            bytes.extend_from_slice(bytemuck::cast_slice(&clip.samples));
        }
        for clip in &self.clips {
            bytes.extend_from_slice(&clip.packed);
        }
        let hash = Sha256::digest(&bytes);
        bytes.extend_from_slice(&hash);
        bytes
    }

    /// Reads the file of a database.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::matching::{Database, IndexedClip};
    ///
    /// let walk = mocap::import("fixtures/real/cmu_short.bvh")?;
    /// let bytes = Database::new(IndexedClip::of(&walk, "walk.bvh", true)).to_bytes();
    /// assert_eq!(Database::read(&bytes[..])?.clips().len(), 2);
    /// let error = Database::read(&bytes[..bytes.len() - 40]).unwrap_err();
    /// assert_eq!(error.code().as_str(), "unexpected-end");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::InvalidDatabase`], [`Code::UnexpectedEnd`], [`Code::LimitExceeded`] and [`Code::Io`].
    pub fn read(source: impl Read) -> Result<Self> {
        let mut source = Source {
            source,
            hash: Sha256::new(),
        };
        let entries = source.list()?;
        let mut clips: Vec<IndexedClip> = entries.iter().map(Entry::clip).collect();
        let counts = entries.iter().map(|entry| entry.frames as usize);
        for (clip, frames) in clips.iter_mut().zip(counts.clone()) {
            clip.features = source.features(frames)?;
        }
        for (clip, frames) in clips.iter_mut().zip(counts) {
            clip.contacts = source.bytes(frames)?;
            if clip.contacts.iter().any(|bits| *bits > 15) {
                return Err(invalid("a contact of a frame is above 15"));
            }
        }
        for (clip, entry) in clips.iter_mut().zip(&entries) {
            clip.samples = bytemuck::cast_slice(&source.bytes(entry.samples as usize * WIDTH)?).to_vec();
        }
        for (clip, entry) in clips.iter_mut().zip(&entries) {
            clip.packed = source.bytes(entry.packed as usize)?;
        }
        source.ends_with_hash()?;
        Ok(Self { clips })
    }
}

impl Entry<ClipRow> {
    fn clip(&self) -> IndexedClip {
        IndexedClip {
            row: self.row.clone(),
            mirrored: self.mirrored,
            leg: self.leg,
            begin: self.begin,
            features: Vec::new(),
            contacts: Vec::new(),
            samples: Vec::new(),
            packed: Vec::new(),
        }
    }
}

/// A source that hashes the bytes that are read from it.
struct Source<R> {
    source: R,
    hash: Sha256,
}

impl<R: Read> Source<R> {
    fn fill(&mut self, block: &mut [u8]) -> Result<()> {
        self.source.read_exact(block).map_err(of_io)?;
        self.hash.update(block);
        Ok(())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut array = [0; N];
        self.fill(&mut array)?;
        Ok(array)
    }

    /// Reads `count` bytes, in blocks.
    fn bytes(&mut self, count: usize) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        while bytes.len() < count {
            let begin = bytes.len();
            bytes.resize(count.min(begin + BLOCK), 0);
            self.fill(&mut bytes[begin..])?;
        }
        Ok(bytes)
    }

    fn features(&mut self, frames: usize) -> Result<Vec<[f32; FEATURES]>> {
        let mut features = Vec::new();
        for _ in 0..frames {
            let row: [u8; 2 * FEATURES] = self.array()?;
            let number = |column: usize| half::from_half(u16::from_le_bytes([row[2 * column], row[2 * column + 1]]));
            let row: [f32; FEATURES] = std::array::from_fn(number);
            if !row.iter().all(|value| is_plausible(*value)) {
                return Err(invalid("a feature of a frame is not a finite number"));
            }
            features.push(row);
        }
        Ok(features)
    }

    /// Reads the header and the list, and checks the counts against the limits.
    fn list(&mut self) -> Result<Vec<Entry<ClipRow>>> {
        if self.array::<8>()? != *DATABASE_MARK {
            return Err(invalid("it does not begin with `mocapMDB`"));
        }
        let version = u32::from_le_bytes(self.array()?);
        if version != VERSION {
            return Err(invalid(&format!(
                "its version is {version}, and mocap reads version {VERSION}"
            )));
        }
        let width = u32::from_le_bytes(self.array()?);
        if width as usize != FEATURES {
            return Err(invalid(&format!("a frame has {width} numbers, not {FEATURES}")));
        }
        let bytes = u64::from_le_bytes(self.array()?);
        if bytes > LONGEST_LIST {
            return Err(too_many("bytes of the list of clips", bytes, LONGEST_LIST));
        }
        let list = self.bytes(bytes as usize)?;
        let list = String::from_utf8_lossy(&list);
        let entries: Vec<Entry<ClipRow>> =
            serde_json::from_str(&list).map_err(|error| invalid(&format!("its list of clips is broken: {error}")))?;
        let most = Limits::default().max_values / FEATURES as u64;
        let add = |sum: u64, count: u64| sum.saturating_add(count);
        for (what, most, count) in [
            ("frames", most, entries.iter().map(|entry| entry.frames).fold(0, add)),
            ("samples", most, entries.iter().map(|entry| entry.samples).fold(0, add)),
            (
                "bytes of packed clips",
                MOST_PACKED,
                entries.iter().map(|entry| entry.packed).fold(0, add),
            ),
        ] {
            if count > most {
                return Err(too_many(what, count, most));
            }
        }
        let is_body = |entry: &Entry<ClipRow>| has_leg_and_begin(entry.leg, entry.begin) && entry.frames > 0;
        match entries.iter().find(|entry| !is_body(entry)) {
            None => Ok(entries),
            Some(entry) => Err(invalid(&format!(
                "a clip of {} has no frames, or an implausible leg length or begin",
                entry.row.file
            ))),
        }
    }

    fn ends_with_hash(mut self) -> Result<()> {
        let mut stated = [0; 32];
        let found = self.hash.finalize();
        self.source.read_exact(&mut stated).map_err(of_io)?;
        if stated != *found {
            return Err(invalid("its checksum does not match its bytes: the file is damaged"));
        }
        match self.source.read(&mut [0]).map_err(of_io)? {
            0 => Ok(()),
            _ => Err(invalid("more bytes follow the checksum")),
        }
    }
}

fn of_io(error: io::Error) -> Error {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => Diagnostic::new(Code::UnexpectedEnd, "the database ends before its checksum")
            .help("make the database again with `mocap index`")
            .into(),
        _ => Diagnostic::new(Code::Io, error.to_string()).into(),
    }
}

fn invalid(why: &str) -> Error {
    let message = format!("the file is not a database of motions: {why}");
    Diagnostic::new(Code::InvalidDatabase, message)
        .help("make the database again with `mocap index`")
        .into()
}

fn too_many(what: &str, found: u64, most: u64) -> Error {
    let message = format!("the database has more {what} than the limits allow");
    Diagnostic::new(Code::LimitExceeded, message)
        .expected_found(format!("at most {most}"), found.to_string())
        .into()
}
