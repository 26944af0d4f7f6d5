//! Biovision hierarchy: a skeleton as nested blocks, then one row of numbers per frame.
//!
//! ```text
//! file      := "HIERARCHY" root+ motion?
//! root      := "ROOT" name "{" item* "}"
//! item      := "OFFSET" x y z | "CHANNELS" n name{n} | "JOINT" name "{" item* "}" | "End Site" name? "{" item* "}"
//! motion    := "MOTION" "Frames:" n "Frame Time:" seconds row*
//! row       := one number a channel, in the order in which the hierarchy names them
//! ```
//! # std::env::set_current_dir("../..").unwrap();
//!
//! There is no standard for BVH. `fixtures/README.md` lists the dialects of real files. `read` converts a file to a
//! scene, `write` a scene to a file. Degrees, columns and rotation orders stay in this folder.

mod options;
#[cfg(feature = "bvh")]
pub(crate) mod read;
#[cfg(feature = "bvh")]
pub(crate) mod write;

use mocap_scene::scene::Format;
use mocap_scene::scene::report::DataKind;

use crate::text::{Cursor, decode, is_line_end};
use crate::{Carriage, FormatInfo, WriteOption};

pub use self::options::{BvhOptions, Channels};

#[doc(hidden)]
pub const FORMAT: FormatInfo = FormatInfo {
    format: Format::Bvh,
    name: "BVH",
    description: "Biovision hierarchy",
    extensions: Format::Bvh.extensions(),
    reading: "excellent",
    writing: "excellent",
    sniff,
    reads_blocks: true,
    feature: Some("bvh"),
    reads: cfg!(feature = "bvh"),
    read: reader!("bvh", read::read),
    write: Some(writer!("bvh", write::files)),
    options: &[
        WriteOption::Order,
        WriteOption::Digits,
        WriteOption::Channels,
        WriteOption::Sidecar,
        WriteOption::OutUnit,
        WriteOption::OutUp,
        WriteOption::Names,
        WriteOption::Rest,
        WriteOption::RootMotion,
    ],
    carried: &[
        (DataKind::Clips, Carriage::Kept),
        (DataKind::Frames, Carriage::AtFrames),
        (DataKind::FrameRates, Carriage::Kept),
        (DataKind::Durations, Carriage::AtFrames),
        (DataKind::Units, Carriage::Lost),
        (DataKind::MovingJoints, Carriage::Kept),
        (DataKind::PositionCurves, Carriage::Kept),
        (DataKind::ScaleCurves, Carriage::Converted),
        (DataKind::RestScales, Carriage::Converted),
    ],
    has_one_clip: true,
    has_rest_rotations: false,
    has_sidecar: true,
    names_clips: false,
    ..FormatInfo::BASE
};

/// A BVH file begins with `HIERARCHY`. Only comment lines may precede this word.
fn sniff(bytes: &[u8]) -> bool {
    /// The number of bytes at the start of a file that must contain `HIERARCHY` after comment lines.
    const ENOUGH: usize = 64 << 10;
    decode(&bytes[..bytes.len().min(ENOUGH)]).is_ok_and(|text| {
        let mut cursor = Cursor::new(&text);
        pass_comments(&mut cursor);
        cursor.next_word().is_some_and(|word| word.is("HIERARCHY"))
    })
}

/// Skips the comment lines before `HIERARCHY`.
fn pass_comments(cursor: &mut Cursor<'_>) {
    loop {
        cursor.skip_spaces();
        match cursor.peek() {
            Some(b'#') => cursor.take_while(|byte| !is_line_end(byte)),
            _ => break,
        };
    }
}
