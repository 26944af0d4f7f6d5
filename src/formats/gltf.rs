//! glTF 2.0: reads and writes `.glb` and `.gltf`, and VRM animations, which are glTF.
//!
//! `read` converts a file to a scene, `write` a scene to a file. The reader and `verify` access a file's nodes and
//! tracks with `File`.

#[cfg(feature = "gltf")]
mod accessors;
#[cfg(feature = "gltf")]
mod bind;
#[cfg(feature = "gltf")]
mod character;
mod compression;
#[cfg(feature = "gltf")]
mod encoding;
#[cfg(feature = "gltf")]
mod face;
#[cfg(feature = "gltf")]
mod file;
#[cfg(feature = "gltf")]
mod frame_time;
#[cfg(feature = "gltf")]
mod humanoid;
#[cfg(feature = "gltf")]
mod invalid;
#[cfg(feature = "gltf")]
mod json;
#[cfg(feature = "gltf")]
mod meshes;
#[cfg(feature = "gltf")]
mod meshopt;
#[cfg(feature = "gltf")]
mod original;
#[cfg(feature = "gltf")]
mod raw_file;
#[cfg(feature = "gltf")]
mod read;
pub mod report;
#[cfg(feature = "gltf")]
mod required;
#[cfg(feature = "gltf")]
mod stream_size;
#[cfg(feature = "gltf")]
mod streams;
#[cfg(feature = "gltf")]
mod tracks;
#[cfg(feature = "gltf")]
mod unread;
#[cfg(feature = "gltf")]
pub mod vrma;
#[cfg(feature = "gltf")]
mod weights;
#[cfg(feature = "gltf")]
pub(crate) mod write;

use mocap_scene::scene::Format;
use mocap_scene::scene::report::DataKind;

use crate::{Carriage, FormatInfo, WriteOption, ledger};

#[cfg(feature = "gltf")]
#[doc(hidden)]
pub use self::character::Character;
pub use self::compression::Compression;
#[cfg(feature = "gltf")]
#[doc(hidden)]
pub use self::file::File;
#[cfg(feature = "gltf")]
#[doc(hidden)]
pub use self::raw_file::RawFile;
#[cfg(feature = "gltf")]
#[doc(hidden)]
pub use self::tracks::{Bend, Values};
#[cfg(feature = "gltf")]
#[doc(hidden)]
pub use self::write::Document;
#[cfg(feature = "gltf")]
pub use self::write::GltfOptions;

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Gltf,
    name: "glTF",
    description: "glTF 2.0, skeleton and animation",
    extensions: Format::Gltf.extensions(),
    reading: "excellent: skeleton and animation",
    writing: "excellent",
    sniff,
    feature: Some("gltf"),
    reads: cfg!(feature = "gltf"),
    read: reader!("gltf", read::read),
    write: Some(writer!("gltf", write::files)),
    options: &[
        WriteOption::Mesh,
        WriteOption::SkeletonOnly,
        WriteOption::KeepConstant,
        WriteOption::Embed,
        WriteOption::Compress,
        WriteOption::MaxError,
        WriteOption::ShellDistance,
        WriteOption::BoneAxis,
        WriteOption::Names,
        WriteOption::Rest,
        WriteOption::RootMotion,
    ],
    carried: ledger::OF_CHARACTERS,
    passed_through: &[
        DataKind::VertexColors,
        DataKind::Expressions,
        DataKind::SurfaceMaps,
        DataKind::Springs,
        DataKind::Constraints,
        DataKind::CharacterSettings,
        DataKind::Cameras,
        DataKind::Lights,
        DataKind::Extras,
    ],
    states_origin: true,
    keeps_characters: true,
    has_key_times: true,
    ..FormatInfo::BASE
};

pub(super) const VRM_ANIMATION: FormatInfo = FormatInfo {
    format: Format::Vrma,
    name: "a VRM animation",
    description: "VRM animation 1.0",
    extensions: Format::Vrma.extensions(),
    reading: "good: the motion of the humanoid",
    writing: "excellent",
    sniff: sniff_vrm_animation,
    feature: Some("gltf"),
    reads: cfg!(feature = "gltf"),
    read: reader!("gltf", read::read_vrm_animation),
    write: Some(writer!("gltf", vrma::files)),
    options: &[
        WriteOption::Compress,
        WriteOption::MaxError,
        WriteOption::ShellDistance,
        WriteOption::Names,
    ],
    carried: &[
        (DataKind::Clips, Carriage::Kept),
        (DataKind::Frames, Carriage::Kept),
        (DataKind::FrameRates, Carriage::Kept),
        (DataKind::Durations, Carriage::Kept),
        (DataKind::Units, Carriage::Converted),
        (DataKind::MovingJoints, Carriage::Converted),
        (DataKind::PositionCurves, Carriage::OfRoot),
        (DataKind::RestScales, Carriage::Converted),
        (DataKind::FaceCurves, Carriage::Kept),
    ],
    passed_through: &[DataKind::Extras],
    states_bones: true,
    states_origin: true,
    keeps_shear: true,
    has_key_times: true,
    ..FormatInfo::BASE
};

/// The place of a `.gltf` file's buffer.
///
/// [`GltfOptions`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum BufferPlace {
    /// In a `.bin` file in the same folder.
    #[default]
    Beside,
    /// In the file itself, as a data URI, which takes a third more bytes.
    Embedded,
}

/// The magic number of a `.glb` file.
const MAGIC: &[u8] = b"glTF";
/// Bytes of the header of a `.glb` file.
const HEADER: usize = 12;
/// Bytes of the header of each chunk.
const CHUNK_HEADER: usize = 8;

/// The extension of VRM animations.
const VRM_ANIMATION_EXTENSION: &str = "VRMC_vrm_animation";

/// A `.glb` begins with its magic number. A `.gltf` is a JSON object with a member `asset`.
fn sniff(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let is_json = text.trim_ascii_start().starts_with(b"{");
    bytes.starts_with(MAGIC) || (is_json && memchr::memmem::find(bytes, b"\"asset\"").is_some())
}

/// Whether a file is glTF and names the extension of VRM animations.
fn sniff_vrm_animation(bytes: &[u8]) -> bool {
    /// Bytes of a file in which to search for the name of the extension.
    const SEARCHED: usize = 1 << 20;
    let names_it = |text: &[u8]| {
        let text = &text[..text.len().min(SEARCHED)];
        memchr::memmem::find(text, VRM_ANIMATION_EXTENSION.as_bytes()).is_some()
    };
    sniff(bytes) && names_it(beginning(bytes))
}

/// The JSON of a file, which may be cut off, without checks.
fn beginning(bytes: &[u8]) -> &[u8] {
    if !bytes.starts_with(MAGIC) {
        return bytes;
    }
    let length = bytes.get(HEADER..HEADER + 4).and_then(|length| length.try_into().ok());
    let length = length.map_or(0, u32::from_le_bytes) as usize;
    let json = bytes.get(HEADER + CHUNK_HEADER..).unwrap_or_default();
    &json[..json.len().min(length)]
}
