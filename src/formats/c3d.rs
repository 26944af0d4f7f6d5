//! C3D: the positions of markers in each frame. Binary, in blocks of 512 bytes.
//!
//! | part | begins at | holds |
//! |---|---|---|
//! | header | block 1 | the numbers of points and frames, and where the other parts begin |
//! | parameters | the block that the header names | the processor type, which gives the number format, then named values in groups |
//! | data | the block that `POINT:DATA_START` or the header names | one record per frame: x, y, z and residual of each point, then analog samples |
//!
//! Numbers are those of an Intel, DEC or SGI processor; coordinates are 32-bit numbers if the scale factor is negative,
//! or else 16-bit integers to be multiplied by it. A negative residual means that the point was not seen.
//!
//! A marker becomes a node with position keys below one group. The file has no skeleton, and the reader does not
//! compute one: markers are on the skin, and finding the joints needs a model of the person (`solve`). Events, analog
//! samples and force plates are in the scene's metadata (`Recording`). Positions are in the file's unit, rotated so
//! that +Y is up; `POINT:Y_SCREEN` states the file's up axis, and without it +Z is assumed.
//!
//! The format is described by Motion Lab Systems, *The C3D File Format: User Guide*. Existing crates panic on some
//! damaged files, so this crate has its own reader, which checks every count against the bytes that follow.

#[cfg(feature = "c3d")]
pub(crate) mod read;

use mocap_scene::scene::Format;

use crate::{Contents, FormatInfo};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::C3d,
    name: "C3D",
    description: "C3D markers",
    extensions: Format::C3d.extensions(),
    reading: "good: markers; `mocap solve` computes a skeleton from them",
    writing: "no",
    sniff,
    feature: Some("c3d"),
    reads: cfg!(feature = "c3d"),
    read: reader!("c3d", read::read),
    contents: Contents::Points,
    names_clips: false,
    ..FormatInfo::BASE
};

/// The block size: offsets in the file are block numbers.
const BLOCK: usize = 512;

/// The second byte of every C3D file.
const KEY: u8 = 0x50;

/// Whether the bytes name a block of parameters, in which the processor is one of three.
fn sniff(bytes: &[u8]) -> bool {
    let &[first @ 1..=u8::MAX, KEY, ..] = bytes else {
        return false;
    };
    let start = (usize::from(first) - 1) * BLOCK;
    matches!(bytes.get(start..start + 4), Some([.., 84..=86]))
}
