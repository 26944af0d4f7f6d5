//! Arrays of other programs: NumPy's `.npz` and `.npy`, pickles, and PyTorch's `.pt`.
//!
//! | container | reader |
//! |---|---|
//! | `.npz`, `.pt`: zip | `archive`: each entry stored or deflated, with checked length and check sum |
//! | `.npy` | `npy`: `numpy.lib.format`, versions 1 to 3 |
//! | `.csv` | `csv`: the arrays of this program, and point positions, by column names |
//! | `.csv`, `.json` of faces | `face`: ARKit blend shapes, from Live Link Face and MediaPipe |
//! | `.json` of a robot | `max`: the motion of a robot with four legs, as for the robot MAX |
//! | `.parquet` | `parquet`: the arrays of this program; the claims of its pages are first checked against the file |
//! | `.mot`, `.sto` | `mot`: text with named columns |
//! | `.pkl`, and `data.pkl` in `.pt` | `pickle`: builds arrays, dictionaries, lists, numbers and strings, and calls nothing |
//!
//! Names and shapes determine the meaning of the arrays (`layouts`). An array holds one of:
//!
//! - rotations: AMASS, SMPL-X's dictionaries, GVHMR, GEM-X, Motion-X, PHUMA, Kimodo, SAM 3D Body
//! - joint angles of OpenSim, and the arrays of this program
//! - positions without rotations, which become points without a skeleton
//!
//! Rotations without bone lengths are applied to a given body (`body`), or else to generic proportions (`proportions`).
//! No file of a licensed model is needed, and the code contains no data of a licensed model. `docs/arrays.md` describes
//! each layout.

#[cfg(feature = "arrays")]
pub(crate) mod read;

use mocap_scene::files::{is_csv_of_points, is_own_csv};
use mocap_scene::scene::Format;
use mocap_scene::scene::report::DataKind;

use crate::{Carriage, Contents, FormatInfo};

#[cfg(feature = "arrays")]
#[doc(hidden)]
pub use self::read::{Body, BodyFrames, MHR_ROOT_HEIGHT, SMPL_ROOT, body_model, humanml3d, mhr_frames};
#[cfg(feature = "parquet")]
#[doc(hidden)]
pub use self::read::{ParquetRows, parquet_rows};

/// The fields that the rows of all array formats share.
const ROW: FormatInfo = FormatInfo {
    format: Format::Npy,
    name: "NumPy's .npy",
    description: "one NumPy array",
    extensions: Format::Npy.extensions(),
    reading: "good: layouts, recognised by the shape of the array",
    writing: "no",
    sniff: |bytes| bytes.starts_with(NPY_HEAD),
    feature: Some("arrays"),
    reads: cfg!(feature = "arrays"),
    read: reader!("arrays", read::read_npy),
    contents: Contents::Arrays,
    carried: &[
        (DataKind::Clips, Carriage::Kept),
        (DataKind::Frames, Carriage::AtFrames),
        (DataKind::FrameRates, Carriage::Kept),
        (DataKind::Durations, Carriage::AtFrames),
        (DataKind::Units, Carriage::Converted),
        (DataKind::MovingJoints, Carriage::Kept),
        (DataKind::PositionCurves, Carriage::Converted),
        (DataKind::RestScales, Carriage::Converted),
        (DataKind::MarkerGaps, Carriage::Kept),
    ],
    ..FormatInfo::BASE
};

pub(super) const NPY: FormatInfo = ROW;

pub(super) const NPZ: FormatInfo = FormatInfo {
    format: Format::Npz,
    name: "NumPy's .npz",
    description: "NumPy arrays: AMASS, SMPL-X, Kimodo, mocap fk",
    extensions: Format::Npz.extensions(),
    reading: "good: layouts, recognised by the names of their arrays",
    sniff: is_npz,
    feature: Some("npz"),
    reads: cfg!(feature = "npz"),
    read: reader!("npz", read::read_npz),
    ..ROW
};

pub(super) const TORCH: FormatInfo = FormatInfo {
    format: Format::Torch,
    name: "PyTorch's .pt",
    description: "tensors of PyTorch: GVHMR, GEM-X",
    extensions: Format::Torch.extensions(),
    reading: "good: layouts, recognised by the names of their arrays; no code in the file runs",
    sniff: |bytes| first_name(bytes).is_some_and(|name| name.ends_with("/data.pkl")),
    feature: Some("npz"),
    reads: cfg!(feature = "npz"),
    read: reader!("npz", read::read_torch),
    ..ROW
};

pub(super) const PICKLE: FormatInfo = FormatInfo {
    format: Format::Pickle,
    name: "a pickle",
    description: "Python's pickle of arrays",
    extensions: Format::Pickle.extensions(),
    reading: "good: layouts, recognised by the names of their arrays; no code in the file runs",
    sniff: is_pickle,
    read: reader!("arrays", read::read_pickle),
    ..ROW
};

pub(super) const CSV: FormatInfo = FormatInfo {
    format: Format::Csv,
    name: "CSV",
    description: "text tables: arrays of mocap fk, point positions, Motive's, ARKit face shapes; JSON of MAX",
    extensions: Format::Csv.extensions(),
    reading: "good: tables that mocap wrote, and positions, recognised by the names of their columns",
    sniff: |bytes| is_own_csv(bytes) || is_csv_of_points(bytes) || is_face_json(bytes) || is_max_json(bytes),
    read: reader!("arrays", read::read_csv),
    ..ROW
};

pub(super) const PARQUET: FormatInfo = FormatInfo {
    format: Format::Parquet,
    name: "Parquet",
    description: "column tables: arrays of mocap fk",
    extensions: Format::Parquet.extensions(),
    reading: "good: tables that mocap wrote",
    sniff: |bytes| bytes.starts_with(b"PAR1"),
    feature: Some("parquet"),
    reads: cfg!(feature = "parquet"),
    read: reader!("parquet", read::read_parquet),
    ..ROW
};

pub(super) const MOT: FormatInfo = FormatInfo {
    format: Format::Mot,
    name: "OpenSim's .mot",
    description: "joint angles of OpenSim's models",
    extensions: Format::Mot.extensions(),
    reading: "fair: joint angles of OpenSim's gait models; a body option states the skeleton",
    sniff: is_mot,
    read: reader!("arrays", read::read_mot),
    contents: Contents::Motion,
    ..ROW
};

/// The first bytes of an `.npy`.
const NPY_HEAD: &[u8] = b"\x93NUMPY";

/// The last line of the header of an OpenSim motion.
const END_OF_HEADER: &str = "endheader";

/// The name of the first file of an archive, from its bytes.
fn first_name(bytes: &[u8]) -> Option<&str> {
    /// Bytes of a ZIP entry's header before its name.
    const NAME: usize = 30;
    if !bytes.starts_with(b"PK\x03\x04") {
        return None;
    }
    let length = usize::from(u16::from_le_bytes([*bytes.get(26)?, *bytes.get(27)?]));
    std::str::from_utf8(bytes.get(NAME..NAME + length)?).ok()
}

fn is_npz(bytes: &[u8]) -> bool {
    first_name(bytes).is_some_and(|name| name.ends_with(".npy"))
}

/// Whether JSON begins with blend shapes of a face, as MediaPipe names them.
fn is_face_json(bytes: &[u8]) -> bool {
    const SHAPES: [&[u8]; 3] = [b"\"browInnerUp\"", b"\"eyeBlinkLeft\"", b"\"jawOpen\""];
    SHAPES.iter().any(|shape| has_in_json(bytes, shape))
}

/// Whether JSON begins with the keys of a motion for the robot MAX.
fn is_max_json(bytes: &[u8]) -> bool {
    has_in_json(bytes, b"\"FrameDuration\"") && has_in_json(bytes, b"\"LegOrder\"")
}

/// Whether JSON has these bytes near its beginning.
fn has_in_json(bytes: &[u8], part: &[u8]) -> bool {
    /// The first frame must end within this number of bytes: a face has 52 shapes of about a hundred bytes each.
    const NEAR: usize = 16 << 10;
    let start = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let start = &start[..start.len().min(NEAR)];
    matches!(start.first(), Some(b'[' | b'{')) && start.windows(part.len()).any(|found| found == part)
}

/// Whether bytes begin like a pickle of protocol 2 or later. Earlier protocols are text without a fixed beginning.
fn is_pickle(bytes: &[u8]) -> bool {
    matches!(bytes, [0x80, 2..=5, first, ..] if matches!(first, b'}' | b']' | b'(' | b'c' | 0x95 | b')' | b'X' | 0x8c))
}

/// Whether a string contains the end of an OpenSim header.
fn is_mot(bytes: &[u8]) -> bool {
    /// The header of an OpenSim motion must end within this number of bytes: it has a few lines.
    const NEAR: usize = 4096;
    let start = &bytes[..bytes.len().min(NEAR)];
    start
        .split(|byte| *byte == b'\n')
        .any(|line| line.trim_ascii().eq_ignore_ascii_case(END_OF_HEADER.as_bytes()))
}
