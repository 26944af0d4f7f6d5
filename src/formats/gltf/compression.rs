//! The storage of keys within a largest error.
//!
//! | | rotations | translations | times | readers need |
//! |---|---|---|---|---|
//! | [`Compression::None`] | 32-bit floats | 32-bit floats | 32-bit floats | nothing special |
//! | [`Compression::Int16`] | 16-bit normalised integers | 32-bit floats | 32-bit floats | all of core glTF |
//! | [`Compression::Meshopt`] | QUATERNION filter, 4 to 16 bits | EXPONENTIAL filter | 32-bit floats | EXT_meshopt_compression |
//! | [`Compression::MeshoptKhr`] | QUATERNION filter, 4 to 16 bits | EXPONENTIAL filter | 32-bit floats | KHR_meshopt_compression |
//!
//! Times are 32-bit floats, as glTF requires, without further rounding. The bit rate of a joint depends on the distance
//! of its descendants, by the hierarchical error metric of the Animation Compression Library (Nicholas Frechette). The
//! filter formulas are in EXT_meshopt_compression, appendix B.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use mocap_scene::error::{Code, Diagnostic, Error};

/// The storage of animation keys.
///
/// [`GltfOptions`](crate::gltf::GltfOptions) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Compression {
    /// 32-bit floats, which every client reads.
    #[default]
    None,
    /// Rotations as 16-bit normalised integers, half the size. This is core glTF without an extension, but Assimp reads
    /// wrong values.
    Int16,
    /// Streams of `EXT_meshopt_compression`, which the file then requires. Needs the feature `meshopt`.
    Meshopt,
    /// Streams of `KHR_meshopt_compression` version 1, slightly smaller. The file then requires the extension. Needs
    /// the feature `meshopt`.
    MeshoptKhr,
}

impl Compression {
    /// All kinds of compression.
    pub const ALL: [Self; 4] = [Self::None, Self::Int16, Self::Meshopt, Self::MeshoptKhr];

    /// The name that users type.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Int16 => "int16",
            Self::Meshopt => "meshopt",
            Self::MeshoptKhr => "meshopt-khr",
        }
    }

    /// The extension that the file requires.
    pub(super) fn extension(self) -> Option<&'static str> {
        match self {
            Self::None | Self::Int16 => None,
            Self::Meshopt => Some(EXT),
            Self::MeshoptKhr => Some(KHR),
        }
    }
}

/// Parses the name of a compression.
impl FromStr for Compression {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let named = Self::ALL.into_iter().find(|kind| kind.as_str() == name);
        named.ok_or_else(|| {
            let found = format!("\"{name}\"");
            Diagnostic::new(Code::InvalidValue, format!("{found} is not the name of a compression"))
                .expected_found(Self::ALL.map(Self::as_str).join(", "), found)
                .into()
        })
    }
}

pub(super) const EXT: &str = "EXT_meshopt_compression";
pub(super) const KHR: &str = "KHR_meshopt_compression";
