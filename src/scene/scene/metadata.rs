//! The origin of a scene, the decisions about the scene, and the steps that changed the scene.

mod applied_step;
mod file_space;

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

pub use self::applied_step::{AppliedStep, JointRename, SecondMotion, StepRecord};
pub use self::file_space::FileSpace;
use super::attribution::Attribution;
use super::clip_extras::ClipExtras;
use super::ledger::DataLoss;
use super::{Animation, FbxOriginal, MarkerSolution, MmdModel, Recording};
use crate::error::{Code, Diagnostic, Error};

/// The origin of a scene, the assumptions of the reader, and the steps that changed the scene.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Metadata {
    /// The file from which the scene was read.
    pub origin: Option<Origin>,
    /// The format of the file. Absent for a scene without a file.
    #[serde(with = "format_name")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<Format>"))]
    pub format: Option<Format>,
    /// Metres per unit of length, if the file or the caller states it, or if the scene was converted. BVH does not
    /// state it.
    pub metres_per_unit: Option<f64>,
    /// The up axis, if the format, the file or the caller states it, or if the scene was converted. BVH and Acclaim
    /// files do not state it.
    pub up: Option<UpAxis>,
    /// How the root's OFFSET was used, and why. Absent for formats without an OFFSET.
    pub root_offset: Option<RootOffsetUsed>,
    /// All other decisions about values that the file does not state.
    pub assumptions: Vec<Assumption>,
    /// The steps that changed positions or times after reading, in order.
    pub steps: Vec<AppliedStep>,
    /// The origin and licence of the motion.
    #[serde(default, skip_serializing_if = "Attribution::is_empty")]
    pub attribution: Attribution,
    /// Events, analog channels and force plates of the file.
    #[serde(skip)]
    pub recorded: Option<Arc<Recording>>,
    /// The fit of a skeleton that was solved from markers.
    #[serde(skip)]
    pub solved: Option<Arc<MarkerSolution>>,
    /// The extras of the file's clips.
    #[serde(skip)]
    #[doc(hidden)]
    pub clip_extras: ClipExtras,
    /// The FBX file that the scene was read from.
    #[serde(skip)]
    #[doc(hidden)]
    pub fbx: Option<FbxOriginal>,
    /// Data that the file has and the scene lacks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[doc(hidden)]
    pub lost: Vec<DataLoss>,
    /// Whether the caller keeps an unknown unit, so that no writer infers it.
    #[serde(skip)]
    #[doc(hidden)]
    pub keeps_unknown_unit: bool,
    /// The unit and the up axis of the numbers in the file, if the reader converted them.
    #[serde(skip)]
    #[doc(hidden)]
    pub file_space: FileSpace,
    /// The MikuMikuDance model that the skeleton belongs to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[doc(hidden)]
    pub mmd: Option<Box<MmdModel>>,
}

/// Declares [`Format`] from one line for each format: its documentation, its variant, its name for users, and its file
/// extensions in lower case.
macro_rules! formats {
    ($(#[$about:meta] $variant:ident $name:literal [$($extension:literal),+])*) => {
        /// A file format, by the name that users type.
        ///
        /// ```
        /// use mocap::Format;
        ///
        /// assert_eq!("asf-amc".parse::<Format>()?, Format::AsfAmc);
        /// assert_eq!(Format::Gltf.to_string(), "gltf");
        /// # Ok::<(), mocap::Error>(())
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[non_exhaustive]
        pub enum Format {
            $(#[$about] #[doc = concat!("`", $name, "`.")] $variant,)*
        }

        impl Format {
            /// All formats.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// A list of all names. The constants are joined at compile time: joining them at run time would be
            /// unrolled at optimisation level 3, and would take the compiler minutes.
            #[doc(hidden)]
            pub const NAMES: &'static str = concat!($(", ", $name),*).split_at(", ".len()).1;

            /// The name that users type.
            pub const fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $name,)* }
            }

            /// The file extensions in lower case, without the dot.
            #[doc(hidden)]
            pub const fn extensions(self) -> &'static [&'static str] {
                match self { $(Self::$variant => &[$($extension),+],)* }
            }
        }
    };
}

formats! {
    /// Biovision Hierarchy:
    Bvh "bvh" ["bvh"]
    /// glTF 2.0, `.glb` and `.gltf`:
    Gltf "gltf" ["glb", "gltf"]
    /// VRM animation:
    Vrma "vrma" ["vrma"]
    /// Acclaim skeleton and motion:
    AsfAmc "asf-amc" ["amc", "asf"]
    /// C3D, markers over time:
    C3d "c3d" ["c3d"]
    /// TRC, markers over time in text:
    Trc "trc" ["trc"]
    /// Autodesk FBX:
    Fbx "fbx" ["fbx"]
    /// Universal Scene Description:
    Usd "usd" ["usda", "usdz"]
    /// MikuMikuDance motion:
    Vmd "vmd" ["vmd"]
    /// MikuMikuDance model:
    Pmx "pmx" ["pmx"]
    /// Biped of 3ds Max:
    Bip "bip" ["bip"]
    /// Unified Robot Description Format:
    Urdf "urdf" ["urdf"]
    /// Robot model for MuJoCo:
    Mjcf "mjcf" ["mjcf"]
    /// Packed clip of this crate:
    Mclip "mclip" ["mclip"]
    /// NumPy arrays:
    Npz "npz" ["npz"]
    /// One NumPy array:
    Npy "npy" ["npy"]
    /// PyTorch tensors:
    Torch "torch" ["pt", "pth"]
    /// Arrays in a Python pickle:
    Pickle "pickle" ["pkl", "pickle"]
    /// Text tables:
    Csv "csv" ["csv"]
    /// Column tables:
    Parquet "parquet" ["parquet"]
    /// OpenSim joint angles:
    Mot "mot" ["mot", "sto"]
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Parses the name, in any case.
impl FromStr for Format {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        let format = Self::ALL
            .into_iter()
            .find(|format| format.as_str().eq_ignore_ascii_case(name));
        format.ok_or_else(|| {
            let found = format!("\"{name}\"");
            Diagnostic::new(Code::UnknownFormat, format!("{found} is not the name of a format"))
                .expected_found(Self::NAMES, found)
                .into()
        })
    }
}

/// A format in JSON: its name, or an empty text for an unknown format.
#[doc(hidden)]
pub mod format_name {
    use serde::{Deserialize, Deserializer, Serializer};

    use super::Format;

    #[doc(hidden)]
    pub fn serialize<S: Serializer>(format: &Option<Format>, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(format.map_or("", Format::as_str))
    }

    #[doc(hidden)]
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Format>, D::Error> {
        let name = String::deserialize(deserializer)?;
        Ok(name.parse().ok())
    }
}

/// An input file.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Origin {
    /// The file name, without folders.
    pub name: String,
    /// The SHA-256 of the bytes, as `sha256sum` prints it. Empty if it was not requested.
    pub sha256: String,
    /// The number of frames that were read.
    pub frames: u64,
    /// The time between two frames in seconds, as read.
    pub frame_time: f64,
}

/// The name that readers give to a motion if its format has none.
#[doc(hidden)]
pub const UNNAMED_MOTION: &str = "Motion";

impl Metadata {
    /// The name of a clip in an output: its own name, or else the name of its source file.
    #[doc(hidden)]
    pub fn clip_name<'a>(&'a self, animation: &'a Animation) -> &'a str {
        let own = animation.name.as_str();
        let of_file = self.origin.as_ref().map(Origin::stem);
        match own.trim().is_empty() || own == UNNAMED_MOTION {
            false => own,
            true => of_file.filter(|stem| !stem.is_empty()).unwrap_or(UNNAMED_MOTION),
        }
    }
}

impl Origin {
    /// The file name without its extension.
    pub fn stem(&self) -> &str {
        self.name.rsplit_once('.').map_or(self.name.as_str(), |(stem, _)| stem)
    }
}

/// The axis that points up.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum UpAxis {
    /// +Y, as in glTF and most BVH files.
    #[default]
    Y,
    /// +Z, as in Blender, Vicon and 3ds Max.
    Z,
    /// -Y, as in images, whose rows are counted from the top.
    #[serde(rename = "-y")]
    NegY,
    /// -Z.
    #[serde(rename = "-z")]
    NegZ,
}

impl UpAxis {
    /// All up axes.
    pub const ALL: [Self; 4] = [Self::Y, Self::Z, Self::NegY, Self::NegZ];

    /// The name in JSON: `y`, `z`, `-y` or `-z`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
            Self::NegY => "-y",
            Self::NegZ => "-z",
        }
    }
}

impl UpAxis {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
    pub(super) fn is_y(&self) -> bool {
        *self == Self::Y
    }
}

/// How a root's OFFSET and its position channels combine.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum RootOffset {
    /// Adds in two cases. The root's position is near zero in the first frame or in the median of all frames, but the
    /// OFFSET is not zero. Or the position stays near zero along an OFFSET that puts the feet on the floor. Otherwise,
    /// replaces.
    #[default]
    Auto,
    /// The position channels replace the OFFSET, as in Assimp and Blender.
    Replace,
    /// The position channels are added to the OFFSET.
    Add,
}

/// How a root's OFFSET was used.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RootOffsetUsed {
    /// [`RootOffset::Replace`] or [`RootOffset::Add`].
    pub policy: RootOffset,
    /// The reason, as one phrase. Empty if a compressed file omitted it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// The confidence.
    #[serde(default)]
    pub confidence: Confidence,
}

/// The confidence in a guess.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Confidence {
    /// All evidence agrees.
    Sure,
    /// The most likely answer, but others are possible.
    #[default]
    Likely,
    /// There is little evidence.
    Unsure,
}

impl Confidence {
    /// The name in JSON.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Sure => "sure",
            Self::Likely => "likely",
            Self::Unsure => "unsure",
        }
    }
}

/// A decision about a value that the file does not state.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Assumption {
    /// The topic.
    pub topic: Topic,
    /// The decision.
    pub choice: String,
    /// The reason, as one phrase. Empty if a compressed file omitted it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// The confidence, if the decision is a guess.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<Confidence>,
}

/// The topic of an [`Assumption`].
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Topic {
    /// The unit of length.
    Unit,
    /// The axis that points up.
    Up,
    /// The frames per second.
    FrameRate,
    /// Whether the first frame belongs to the motion.
    FirstFrame,
    /// How a root's OFFSET was used.
    RootOffset,
    /// The meaning of position channels on joints other than the root.
    JointPositions,
    /// The facing direction of the rest pose.
    Facing,
    /// The kind of rest pose.
    RestPose,
    /// Whether the joint names have the correct sides.
    Sides,
    /// Whether the skeleton is a humanoid.
    Humanoid,
    /// Axes that the reader converted.
    UpAxis,
    /// Meshes that were skipped.
    Meshes,
    /// Analog samples that were skipped.
    Analog,
    /// Events that were skipped.
    Events,
    /// Curves between keys that were sampled.
    Interpolation,
    /// The layout of an array without names.
    Layout,
    /// The bone lengths of a body, if a file has only rotations.
    Body,
    /// The pose to which finger rotations are relative.
    Hands,
    /// The fit of a skeleton to the markers that it was solved from.
    Markers,
    /// A topic from another version of this crate.
    #[serde(other)]
    Other,
}

impl Topic {
    /// The name in kebab case. The name does not change between versions.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Unit => "unit",
            Self::Up => "up",
            Self::FrameRate => "frame-rate",
            Self::FirstFrame => "first-frame",
            Self::RootOffset => "root-offset",
            Self::JointPositions => "joint-positions",
            Self::Facing => "facing",
            Self::RestPose => "rest-pose",
            Self::Sides => "sides",
            Self::Humanoid => "humanoid",
            Self::UpAxis => "up-axis",
            Self::Meshes => "meshes",
            Self::Analog => "analog",
            Self::Events => "events",
            Self::Interpolation => "interpolation",
            Self::Layout => "layout",
            Self::Body => "body",
            Self::Hands => "hands",
            Self::Markers => "markers",
            Self::Other => "other",
        }
    }
}

impl fmt::Display for Topic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// Example: `unit: cm, because the skeleton measures 170 units`.
impl fmt::Display for Assumption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { topic, choice, .. } = self;
        write!(f, "{topic}: {choice}, because {}", self.explanation())
    }
}

impl Assumption {
    /// A decision without a reason.
    pub fn new(topic: Topic, choice: impl Into<String>) -> Self {
        Self {
            topic,
            choice: choice.into(),
            reason: String::new(),
            confidence: None,
        }
    }

    /// The reason, and the confidence in brackets.
    pub fn explanation(&self) -> String {
        match self.confidence {
            Some(confidence) if self.reason.is_empty() => format!("({})", confidence.as_str()),
            Some(confidence) => format!("{} ({})", self.reason, confidence.as_str()),
            None => self.reason.clone(),
        }
    }
}
