//! MikuMikuDance: `.pmx`, a model, and `.vmd`, a motion for models with matching bone names.
//!
//! A VMD has keys of bones and morphs by name, and no skeleton. The reader combines the VMD with the PMX of its model.
//! Without a model, the motion is applied to the bones that most models have, with generic proportions. The frame rate
//! is 30 frames per second.
//!
//! | files | scene |
//! |---|---|
//! | bones of the model | nodes, without rotations at rest |
//! | bones with the usual names | bones of a humanoid |
//! | keys of bones, with their Bezier curves | rotations and positions at every frame |
//! | IK of the model, with its loops, links and limits | rotations of the links |
//! | rotation and position that a bone inherits | part of the rotation and position of the bone's node |
//! | morphs | [`Node::face`](mocap_scene::scene::Node::face): VRM expressions if they match one, otherwise custom expressions with their name |
//! | camera, lights, shadows | nothing, with an assumption |
//! | meshes, materials, physics | nothing, with an assumption |
//!
//! MMD is left-handed with +Y up, and a model faces -Z. The mirror `diag(1, 1, -1)` makes the model right-handed,
//! facing +Z, with its left hand at +X. A unit is about 0.08 m. docs/mmd.md has the formulas.

#[cfg(feature = "mmd")]
pub(crate) mod bezier;
#[cfg(feature = "mmd")]
mod bytes;
#[cfg(feature = "mmd")]
pub(crate) mod generic;
#[cfg(feature = "mmd")]
#[doc(hidden)]
pub(crate) mod model;
#[cfg(feature = "mmd")]
mod motion;
#[cfg(feature = "mmd")]
#[doc(hidden)]
pub(crate) mod names;
#[cfg(feature = "mmd")]
mod pose;
#[cfg(feature = "mmd")]
mod read;
#[cfg(feature = "mmd")]
mod scene;
#[cfg(feature = "mmd")]
mod tracks;
#[cfg(feature = "mmd")]
mod write;

use mocap_scene::scene::Format;
use mocap_scene::scene::report::DataKind;

use super::{Carriage, Contents, FormatInfo};

pub(super) const VMD: FormatInfo = FormatInfo {
    format: Format::Vmd,
    name: "VMD",
    description: "MikuMikuDance motion",
    extensions: Format::Vmd.extensions(),
    reading: "fair: on the skeleton of its .pmx model, or on a skeleton of generic proportions",
    writing: "good: for the .pmx model of the scene, or for the standard bones of MMD",
    sniff: |bytes| bytes.starts_with(MOTION_HEAD),
    feature: Some("mmd"),
    reads: cfg!(feature = "mmd"),
    read: reader!("mmd", read::motion),
    write: Some(writer!("mmd", write::files)),
    carried: &[
        (DataKind::Clips, Carriage::Kept),
        (DataKind::Frames, Carriage::AtFrames),
        (DataKind::FrameRates, Carriage::Lost),
        (DataKind::Durations, Carriage::AtFrames),
        (DataKind::Units, Carriage::Converted),
        (DataKind::MovingJoints, Carriage::Converted),
        (DataKind::PositionCurves, Carriage::OfRoot),
        (DataKind::RestScales, Carriage::Converted),
        (DataKind::FaceCurves, Carriage::Kept),
    ],
    has_one_clip: true,
    rate: Some(FRAME_RATE),
    has_rest_rotations: false,
    keeps_shear: true,
    contents: Contents::Keys,
    ..FormatInfo::BASE
};

pub(super) const PMX: FormatInfo = FormatInfo {
    format: Format::Pmx,
    name: "PMX",
    description: "MikuMikuDance model, whose skeleton is read",
    extensions: Format::Pmx.extensions(),
    reading: "fair: the skeleton and the names of morphs, as the target of motions",
    writing: "no",
    sniff: |bytes| bytes.starts_with(MODEL_HEAD) || is_old_model(bytes),
    feature: Some("mmd"),
    reads: cfg!(feature = "mmd"),
    read: reader!("mmd", read::model),
    ..FormatInfo::BASE
};

/// The first bytes of a motion.
const MOTION_HEAD: &[u8] = b"Vocaloid Motion Data ";

/// The first bytes of a model.
const MODEL_HEAD: &[u8] = b"PMX ";

/// Whether the file is PMD, or PMX 1.0. These files are refused with advice.
fn is_old_model(bytes: &[u8]) -> bool {
    bytes.starts_with(b"Pmd") || bytes.starts_with(b"Pmx")
}

/// Metres per unit: the usual choice, with which a model of 20 units is 1.6 m tall. Files state no unit.
const METRES_PER_UNIT: f64 = 0.08;

/// The frame rate in frames per second of every MikuMikuDance motion.
const FRAME_RATE: f64 = 30.0;

/// The help for a broken file.
const EXPORT_AGAIN: &str = "export or download it again";
