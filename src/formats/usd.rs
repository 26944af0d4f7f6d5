//! Universal Scene Description: a UsdSkel skeleton with its animations, and its skinned meshes.
//!
//! `write` writes the text form, `.usda`, and `.usdz`, an archive of the text with its textures (`archive`). `read`
//! makes a scene of a `.usda` or a `.usdz` file, and `parse` reads the text. The binary form, `.usdc`, is refused. The
//! error names the command that converts the binary form to text.
//!
//! Matrices in USD map row vectors, so a row in a file is a column in a scene.

#[cfg(feature = "usd")]
pub(crate) mod archive;
#[cfg(feature = "usd")]
mod parse;
#[cfg(feature = "usd")]
mod read;
#[cfg(feature = "usd")]
pub(crate) mod write;

use mocap_scene::files::{USD_HEAD, ZIP_HEAD};
use mocap_scene::scene::Format;

use crate::{FormatInfo, WriteOption, ledger};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Usd,
    name: "USD",
    description: "Universal Scene Description: UsdSkel, as text or as an archive",
    extensions: Format::Usd.extensions(),
    reading: "fair: skeletons and animations of UsdSkel, skinned meshes with blend shapes, colours and textures; a .usdc \
              file is refused, and the error names the command that converts it to .usda",
    writing: "good: UsdSkel with skins, blend shapes, materials and textures",
    sniff,
    feature: Some("usd"),
    reads: cfg!(feature = "usd"),
    read: reader!("usd", read::read),
    write: Some(writer!("usd", write::files)),
    options: &[
        WriteOption::Mesh,
        WriteOption::SkeletonOnly,
        WriteOption::BoneAxis,
        WriteOption::Names,
        WriteOption::Rest,
        WriteOption::RootMotion,
    ],
    carried: ledger::OF_CHARACTERS,
    has_file_meshes: true,
    states_origin: true,
    keeps_shear: true,
    has_key_times: true,
    #[cfg(feature = "usd")]
    provenance: read::provenance,
    ..FormatInfo::BASE
};

/// The first bytes of the binary form.
const BINARY: &[u8] = b"PXR-USDC";

/// The attribute with the kind of each joint of a skeleton: `joint`, `end_site` or `group`.
const KINDS: &str = "mocap:kinds";

/// Marks a mesh that draws the skeleton and does not belong to the character.
const SKELETON_MESH: &str = "mocap:skeletonMesh";

/// The attribute with the frame rate of an animation, in frames per second. `DURATION` is the attribute with the number
/// of frames minus 1.
const RATE: &str = "mocap:ticksPerSecond";
const DURATION: &str = "mocap:duration";

/// Whether the bytes are an archive of a stage, `.usdz`, not an archive of arrays.
pub fn is_archive(bytes: &[u8]) -> bool {
    /// Bytes of an archive entry's header before the length of its name.
    const LENGTH: usize = 26;

    /// Bytes of an archive entry's header before its name.
    const NAME: usize = 30;
    let name = || {
        let length = bytes.get(LENGTH..LENGTH + 2)?.try_into().ok()?;
        bytes.get(NAME..NAME + usize::from(u16::from_le_bytes(length)))
    };
    bytes.starts_with(ZIP_HEAD) && name().is_some_and(is_stage)
}

/// Whether a file of an archive is a stage, by its name.
fn is_stage(name: &[u8]) -> bool {
    let lower = name.to_ascii_lowercase();
    [".usda", ".usdc", ".usd"]
        .iter()
        .any(|end| lower.ends_with(end.as_bytes()))
}

fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(USD_HEAD) || bytes.starts_with(BINARY) || is_archive(bytes)
}
