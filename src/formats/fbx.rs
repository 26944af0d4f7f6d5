//! Autodesk FBX: a tree of elements, and connections between them.
//!
//! `read` makes a scene of a file, with the C library ufbx. `write` makes a binary file of a scene, without any C
//! code. Euler angles, FBX's units of time and its connections stay in this folder.

#[cfg(feature = "fbx")]
mod matrix;
mod options;
#[cfg(feature = "fbx")]
mod phong;
#[cfg(feature = "fbx")]
mod read;
#[cfg(feature = "fbx")]
pub mod report;
#[cfg(feature = "fbx")]
pub(crate) mod write;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::{FBX_HEAD, fbx_provenance};
use mocap_scene::scene::{Format, Scene};

use crate::provenance::Provenance;
use crate::{FormatInfo, WriteOption, ledger};

pub use self::options::{FbxOptions, FbxRest, FbxRoot, FbxTarget, FbxTextures, FbxVersion};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Fbx,
    name: "FBX",
    description: "Autodesk FBX: skeleton, animation, skinned meshes",
    extensions: Format::Fbx.extensions(),
    reading: "good: skeleton, animation, skinned meshes with blend shapes, colours and textures",
    writing: "good: binary FBX 7.5, with blend shapes",
    sniff,
    feature: Some("fbx"),
    reads: cfg!(feature = "fbx"),
    read: reader!("fbx", read::read),
    write: Some(writer!("fbx", write::files)),
    options: &[
        WriteOption::Mesh,
        WriteOption::SkeletonOnly,
        WriteOption::MaxError,
        WriteOption::ShellDistance,
        WriteOption::FbxVersion,
        WriteOption::FbxRest,
        WriteOption::Target,
        WriteOption::Textures,
        WriteOption::BoneAxis,
        WriteOption::Names,
        WriteOption::Rest,
        WriteOption::RootMotion,
    ],
    carried: ledger::OF_CHARACTERS,
    has_file_meshes: true,
    states_origin: true,
    has_one_rate: true,
    provenance,
    inspect,
    ..FormatInfo::BASE
};

/// The user property with the name of a node in the scene, if the node has another name in the file.
const SOURCE_NAME: &str = "mocap_source_name";

/// The user property that marks a node as an end site.
const END_SITE: &str = "mocap_end_site";

/// The last bytes of every FBX file.
const FOOTER_END: [u8; 16] = [
    0xf8, 0x5a, 0x8c, 0x6a, 0xde, 0xf5, 0xd9, 0x7e, 0xec, 0xe9, 0x0c, 0xe3, 0x75, 0x8f, 0x29, 0x0b,
];

/// A text file begins with a comment that names the format.
fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(FBX_HEAD) || bytes.trim_ascii_start().starts_with(b"; FBX")
}

/// Refuses a file of this crate without its footer, because such a file is cut off. Readers of FBX ignore the footer.
fn inspect(bytes: &[u8], _: &Scene) -> Result<Option<Diagnostic>> {
    if fbx_provenance(bytes).is_none() || bytes.ends_with(&FOOTER_END) {
        return Ok(None);
    }
    let message = "the file does not end with the footer that every FBX file has";
    Err(Diagnostic::new(Code::UnexpectedEnd, message)
        .help("the file was cut off or changed after writing; write the file again")
        .into())
}

/// The whole frame rate that is nearly equal to a frame rate, for programs that accept only whole rates; `None` if no
/// whole rate is near.
#[doc(hidden)]
pub fn whole_rate(frames_per_second: f64) -> Option<f64> {
    /// The largest relative difference between a frame rate and the whole rate: the rounding of a frame time with four
    /// digits.
    const NEAR: f64 = 1e-4;
    let whole = frames_per_second.round();
    (whole > 0.0 && (frames_per_second - whole).abs() <= NEAR * whole).then_some(whole)
}

/// The provenance in a file of this crate; `None` in files of other programs.
fn provenance(bytes: &[u8]) -> Option<Provenance> {
    serde_json::from_str(fbx_provenance(bytes)?).ok()
}
