//! Marks in this program's archives, pickles, tables, databases and joint angles. They distinguish an output from a
//! user's own arrays.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// The mark of arrays. An `.npz` has the mark in the comment at its end. A `.pkl` has the mark in a string at its
/// start, which unpickling discards.
#[doc(hidden)]
pub const ARRAY_MARK: &str = "mocap arrays";

/// The first bytes of a database of motions, `.mdb`.
#[doc(hidden)]
pub const DATABASE_MARK: &[u8; 8] = b"mocapMDB";

/// The start of the creator in Parquet metadata. Thrift's compact protocol has the creator near the end of the file:
/// the type of a string, its length, and the text. Two bytes for each column and the length of all metadata follow.
#[doc(hidden)]
pub const PARQUET_CREATOR: &str = "mocap ";

/// The last bytes of a Parquet file.
const PARQUET_END: &[u8] = b"PAR1";

/// The first line of an OpenSim motion file, `.mot`, with joint angles.
#[doc(hidden)]
pub const ANGLES_MARK: &str = "mocap joint angles";

/// The first lines of OpenSim files with analog channels and with ground reaction forces.
#[doc(hidden)]
pub const ANALOG_MARK: &str = "mocap analog";
#[doc(hidden)]
pub const FORCES_MARK: &str = "mocap forces";

/// The extensions of files with a mark.
pub(super) const MARKED_EXTENSIONS: &[&str] = &["npz", "pkl", "mdb", "parquet", "mot", "sto"];

/// Bytes at each end of a file in which to search for the mark.
const SEARCHED: usize = 32;

/// Bytes at the end of a Parquet file in which to search for its creator. They suffice for this crate's number of
/// columns.
const CREATOR_SEARCHED: usize = 512;

/// Whether a file has a mark. Arrays have the mark at the beginning or at the end, Parquet files at the end, other
/// files at the beginning.
pub(super) fn has_mark(path: &Path) -> bool {
    let ends = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        let mut ends = Vec::new();
        file.by_ref().take(SEARCHED as u64).read_to_end(&mut ends)?;
        let searched = if ends.starts_with(PARQUET_END) {
            CREATOR_SEARCHED
        } else {
            SEARCHED
        };
        file.seek(SeekFrom::Start(length.saturating_sub(searched as u64)))?;
        file.take(searched as u64).read_to_end(&mut ends)?;
        Ok(ends)
    };
    let is_ours = |ends: Vec<u8>| match ends.starts_with(PARQUET_END) {
        true => has_creator(&ends),
        false => {
            ends.starts_with(DATABASE_MARK)
                || [ANGLES_MARK, ANALOG_MARK, FORCES_MARK]
                    .iter()
                    .any(|mark| ends.starts_with(mark.as_bytes()))
                || memchr::memmem::find(&ends, ARRAY_MARK.as_bytes()).is_some()
        }
    };
    ends().is_ok_and(is_ours)
}

/// Whether the creator is a complete text of the metadata, preceded by its length and followed by a version number.
fn has_creator(ends: &[u8]) -> bool {
    const SHORTEST: u8 = PARQUET_CREATOR.len() as u8 + 5;
    memchr::memmem::find_iter(ends, PARQUET_CREATOR.as_bytes()).any(|at| {
        let length = at.checked_sub(1).map_or(0, |before| ends[before]);
        let version = ends.get(at + PARQUET_CREATOR.len());
        (SHORTEST..64).contains(&length) && version.is_some_and(u8::is_ascii_digit)
    })
}
