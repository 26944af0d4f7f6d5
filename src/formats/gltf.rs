//! glTF 2.0: `.glb` and `.gltf`, read and written; and VRM animations, which are glTF.
//!
//! `read` makes a scene of a file, `write` a file of a scene. The reader and `verify` use `File` to access a
//! file's nodes and tracks.

mod accessors;
mod bind;
mod character;
mod compression;
mod encoding;
mod face;
mod file;
mod humanoid;
mod invalid;
mod json;
mod meshes;
mod meshopt;
mod original;
mod read;
mod required;
mod stream_size;
mod streams;
mod tracks;
pub mod vrma;
mod weights;
mod write;

use crate::{FormatInfo, WriteOption};
use mocap_scene::scene::Format;

pub use self::character::Character;
pub use self::compression::Compression;
#[doc(hidden)]
pub use self::file::File;
#[doc(hidden)]
pub use self::tracks::{Bend, Values};
pub use self::write::{BufferPlace, Document, GltfOptions, GltfReport};
pub use crate::provenance::Provenance;
pub use crate::{Achieved, Renamed};

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Gltf,
    name: "glTF",
    description: "glTF 2.0, skeleton and animation",
    extensions: &["glb", "gltf"],
    reading: "excellent: skeleton and animation",
    writing: "excellent",
    sniff: File::sniff,
    reads_blocks: false,
    reads: true,
    read: read::read,
    write: Some(write::files),
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
    has_one_clip: false,
    has_file_meshes: false,
    states_bones: false,
    states_origin: true,
    has_rest_rotations: true,
    keeps_shear: false,
};

pub(super) const VRM_ANIMATION: FormatInfo = FormatInfo {
    format: Format::Vrma,
    name: "a VRM animation",
    description: "VRM animation 1.0",
    extensions: &["vrma"],
    reading: "good: the motion of the humanoid",
    writing: "excellent",
    sniff: vrma::sniff,
    reads_blocks: false,
    reads: true,
    read: read::read_vrm_animation,
    write: Some(vrma::files),
    options: &[
        WriteOption::Compress,
        WriteOption::MaxError,
        WriteOption::ShellDistance,
        WriteOption::Names,
    ],
    has_one_clip: false,
    has_file_meshes: false,
    states_bones: true,
    states_origin: true,
    has_rest_rotations: true,
    keeps_shear: true,
};
