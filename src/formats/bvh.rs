//! Biovision hierarchy: a skeleton as nested blocks, then one row of numbers a frame.
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
//! No standard exists; what real files make of this is listed, dialect by dialect, in `fixtures/README.md`. `read`
//! makes a scene of a file, `write` a file of a scene. Degrees, columns and rotation orders stay in this folder.

mod read;
mod write;

use crate::{FormatInfo, WriteOption};
use mocap_scene::scene::Format;

pub use self::write::{BvhOptions, Channels};

#[doc(hidden)]
pub const FORMAT: FormatInfo = FormatInfo {
    format: Format::Bvh,
    name: "BVH",
    description: "Biovision hierarchy",
    extensions: &["bvh"],
    reading: "excellent",
    writing: "excellent",
    sniff: read::sniff,
    reads_blocks: true,
    reads: true,
    read: read::read,
    write: Some(write::files),
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
    has_one_clip: true,
    has_file_meshes: false,
    states_bones: false,
    states_origin: false,
    has_rest_rotations: false,
    keeps_shear: false,
};
