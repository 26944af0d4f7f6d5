//! How keys are stored, within a largest error.
//!
//! | | rotations | translations | times | who reads it |
//! |---|---|---|---|---|
//! | [`Compression::None`] | 32-bit floats | 32-bit floats | 32-bit floats | everyone |
//! | [`Compression::Int16`] | 16-bit normalised integers | 32-bit floats | 32-bit floats | readers of all of core glTF |
//! | [`Compression::Meshopt`] | QUATERNION filter, 4 to 16 bits | EXPONENTIAL filter | 32-bit floats | readers of EXT_meshopt_compression |
//! | [`Compression::MeshoptKhr`] | the same | the same | the same | readers of KHR_meshopt_compression |
//!
//! Times are 32-bit floats, as glTF requires, and not rounded further. The bit rate of a joint depends on the distance
//! of its descendants; this hierarchical error metric is that of the Animation Compression Library (Nicholas
//! Frechette). The formulas of the filters are those of EXT_meshopt_compression, appendix B.

use serde::Serialize;

use crate::compress::Storage;

/// How the keys of animations are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// 32-bit floats, which every client reads.
    #[default]
    None,
    /// Rotations as 16-bit normalised integers, half the size. Core glTF, no extension; but Assimp reads wrong values.
    Int16,
    /// As streams of `EXT_meshopt_compression`, which the file then requires. Needs the feature `meshopt`.
    Meshopt,
    /// As streams of version 1 of `KHR_meshopt_compression`, a little smaller, which the file then requires. Needs the
    /// feature `meshopt`.
    MeshoptKhr,
}

impl Compression {
    pub(super) fn storage(self) -> Storage {
        match self {
            Self::None => Storage::Float32,
            Self::Int16 => Storage::Int16,
            Self::Meshopt | Self::MeshoptKhr => Storage::Meshopt,
        }
    }

    /// The extension that a file needs.
    pub(super) fn extension(self) -> Option<&'static str> {
        match self {
            Self::None | Self::Int16 => None,
            Self::Meshopt => Some(EXT),
            Self::MeshoptKhr => Some(KHR),
        }
    }
}

pub(super) const EXT: &str = "EXT_meshopt_compression";
pub(super) const KHR: &str = "KHR_meshopt_compression";

/// The error of a file against the scene that it was written from, measured in double precision on the decoded values,
/// at the 32-bit times of the file, and with both interpolations of readers: slerp, and nlerp (component by component).
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Achieved {
    /// The largest distance of a joint or end site from its position in the scene, in metres.
    pub max_error: f64,
    /// The root of the mean square of all distances, in metres.
    pub rms_error: f64,
    /// The name of the node with the largest distance.
    pub joint: String,
    /// The tick of the largest distance.
    pub tick: f64,
    /// The number of keys in the file, of all tracks.
    pub keys: usize,
}
