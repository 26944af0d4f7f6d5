//! Universal Scene Description: a skeleton of UsdSkel with its animations, and the meshes that it moves.
//!
//! `write` makes the text form, `.usda`, and `.usdz`, the archive of it with its textures ([`archive`]). `read` makes a
//! scene of the skeleton and the animations of either; [`parse`] reads the text. The binary form, `.usdc`, is refused
//! with the command that makes text of it.
//!
//! Matrices of USD map row vectors, so a row in a file is a column of a scene.

mod archive;
mod parse;
mod read;
mod write;

use crate::provenance::Provenance;
use crate::{FormatInfo, WriteOption};
use mocap_scene::files::USD_HEAD;
use mocap_scene::scene::Format;

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Usd,
    name: "USD",
    description: "Universal Scene Description: UsdSkel, as text or as an archive",
    extensions: &["usda", "usdz"],
    reading: "fair: skeletons and animations of UsdSkel; .usdc is refused with the command that makes .usda of it",
    writing: "good: UsdSkel, with skins, materials and textures",
    sniff,
    reads_blocks: false,
    reads: true,
    read: read::read,
    write: Some(write::files),
    options: &[
        WriteOption::Mesh,
        WriteOption::SkeletonOnly,
        WriteOption::BoneAxis,
        WriteOption::Names,
        WriteOption::Rest,
        WriteOption::RootMotion,
    ],
    has_one_clip: false,
    has_file_meshes: true,
    states_bones: false,
    states_origin: true,
    has_rest_rotations: true,
    keeps_shear: true,
};

/// The first bytes of the binary form.
const BINARY: &[u8] = b"PXR-USDC";

/// What each joint of a skeleton is: `joint`, `end_site` or `group`.
const KINDS: &str = "mocap:kinds";

/// Frames per second of an animation, and its length in frames less one.
const RATE: &str = "mocap:ticksPerSecond";
const DURATION: &str = "mocap:duration";

/// Whether the bytes are an archive of a stage, `.usdz`, and not one of arrays.
#[cfg(feature = "npz")]
pub fn is_archive(bytes: &[u8]) -> bool {
    archive::sniff(bytes)
}

fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(USD_HEAD) || bytes.starts_with(BINARY) || archive::sniff(bytes)
}

/// What a file of this crate says of itself; `None` in files of other programs.
pub fn provenance(bytes: &[u8]) -> Option<Provenance> {
    read::provenance(bytes)
}
