//! TRC: marker positions as text, in the form of Motion Analysis and OpenSim.
//!
//! | line | contents |
//! |---|---|
//! | 1 | `PathFileType`, a version, `(X/Y/Z)`, the name of the file |
//! | 2, 3 | keys, and their values in the next line: `DataRate`, `NumFrames`, `NumMarkers`, `Units` and others |
//! | 4 | `Frame#`, `Time`, and the name of each marker above the first of its three columns |
//! | 5 | `X1`, `Y1`, `Z1`, `X2`, ... |
//! | others | a frame: its number, its time, three numbers of each marker; empty cells for a marker that was not seen |
//!
//! Columns are separated by tabs. Some programs write spaces, in the header or everywhere, and then there are no empty
//! cells. Positions keep the unit and the axes of the file, which does not state its up axis. If a marker jumps to 0,
//! 0, 0, it was not seen in that frame.
//!
//! The writer writes the positions of all joints or markers in millimetres. Column names are unique, with `_` for tabs
//! and other control characters. An empty name becomes `Joint`. The format is described by OpenSim, *Marker (.trc)
//! Files*.

#[cfg(feature = "trc")]
mod read;
mod times;
#[cfg(feature = "trc")]
mod write;

use mocap_scene::scene::Format;
use mocap_scene::scene::report::DataKind;

use super::text::{Cursor, decode};
use super::{Carriage, Contents, FormatInfo, WriteOption};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Trc,
    name: "TRC",
    description: "TRC markers",
    extensions: Format::Trc.extensions(),
    reading: "good: markers; `mocap solve` computes a skeleton from them",
    writing: "good: positions of markers or joints",
    sniff,
    feature: Some("trc"),
    reads: cfg!(feature = "trc"),
    read: reader!("trc", read::read),
    write: Some(writer!("trc", write::files)),
    options: &[WriteOption::Names, WriteOption::Rest, WriteOption::RootMotion],
    carried: &[
        (DataKind::Clips, Carriage::Kept),
        (DataKind::Frames, Carriage::AtFrames),
        (DataKind::FrameRates, Carriage::Kept),
        (DataKind::Durations, Carriage::AtFrames),
        (DataKind::Units, Carriage::Converted),
        (DataKind::MovingJoints, Carriage::Converted),
        (DataKind::PositionCurves, Carriage::Converted),
        (DataKind::ScaleCurves, Carriage::Converted),
        (DataKind::RestScales, Carriage::Converted),
        (DataKind::MarkerGaps, Carriage::Kept),
    ],
    has_one_clip: true,
    keeps_shear: true,
    contents: Contents::Points,
    names_clips: false,
    inspect: times::inspect,
    ..FormatInfo::BASE
};

/// The first word of every file.
const FIRST_WORD: &str = "PathFileType";

fn sniff(bytes: &[u8]) -> bool {
    /// The number of bytes at the start of a file that must contain the first word.
    const NEAR: usize = 256;
    let start = decode(&bytes[..bytes.len().min(NEAR)]);
    start.is_ok_and(|text| {
        let first = Cursor::new(&text).next_word();
        first.is_some_and(|word| word.is(FIRST_WORD))
    })
}
