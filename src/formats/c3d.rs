//! C3D: the positions of markers in each frame. A file is binary, in blocks of 512 bytes.
//!
//! | part | start | contents |
//! |---|---|---|
//! | header | block 1 | the numbers of points and frames, and the start of the other parts |
//! | parameters | the block that the header names | the processor type, which sets the number format, then named values in groups |
//! | data | the block that `POINT:DATA_START` or the header names | one record per frame: x, y, z and residual of each point, then analog samples |
//!
//! Numbers are in the format of an Intel, DEC or SGI processor. Coordinates are 32-bit floats if the scale factor is
//! negative. Otherwise coordinates are 16-bit integers, multiplied by the factor. A negative residual means that the
//! point was not seen.
//!
//! A marker becomes a node with position keys, the child of a group. The reader computes no skeleton: markers are on
//! the skin, and finding the joints needs a model of the person (`solve`). A file without markers may have the poses of
//! segments in the group `ROTATION`. The segments become joints. Events, analog samples and force plates are in the
//! scene's metadata (`Recording`). Positions are in the file's unit, rotated to +Y up. `POINT:Y_SCREEN` states the
//! file's up axis; without this parameter, +Z is assumed.
//!
//! The format is described by Motion Lab Systems, *The C3D File Format: User Guide*. Existing crates panic on some
//! damaged files. This crate has its own reader, which checks every count against the remaining bytes.

#[cfg(feature = "c3d")]
pub(crate) mod read;

use mocap_scene::scene::Format;

use crate::{Contents, FormatInfo};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::C3d,
    name: "C3D",
    description: "C3D markers",
    extensions: Format::C3d.extensions(),
    reading: "good: markers, from which `mocap solve` computes a skeleton; segments of markerless systems",
    writing: "no",
    sniff,
    feature: Some("c3d"),
    reads: cfg!(feature = "c3d"),
    read: reader!("c3d", read::read),
    contents: Contents::Points,
    names_clips: false,
    ..FormatInfo::BASE
};

/// The block size in bytes. Offsets in the file are block numbers.
const BLOCK: usize = 512;

/// The second byte of every C3D file.
const KEY: u8 = 0x50;

/// Whether the bytes point to a parameter block with one of the three processors.
fn sniff(bytes: &[u8]) -> bool {
    let &[first @ 1..=u8::MAX, KEY, ..] = bytes else {
        return false;
    };
    let start = (usize::from(first) - 1) * BLOCK;
    matches!(bytes.get(start..start + 4), Some([.., 84..=86]))
}
