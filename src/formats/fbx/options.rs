//! The options of the writer.

use serde::{Deserialize, Serialize};

use mocap_compress::ErrorBound;
use mocap_scene::options::setters;
use mocap_scene::scene::UpAxis;

/// The version of a file.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum FbxVersion {
    /// 7.4, of FBX 2014 and 2015: files of at most 4 GiB.
    #[serde(rename = "7.4")]
    #[cfg_attr(feature = "clap", value(name = "7.4"))]
    V7400,
    /// 7.5, of FBX 2016 and newer.
    #[default]
    #[serde(rename = "7.5")]
    #[cfg_attr(feature = "clap", value(name = "7.5"))]
    V7500,
}

/// Where the rotations of the rest pose are.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum FbxRest {
    /// In `Lcl Rotation`, as Blender has them: the curves have all of a rotation.
    #[default]
    Rotation,
    /// In `PreRotation`, which Maya shows as joint orient: all rotations of the rest pose are zero. Assimp 5.2 turns
    /// animated joints by it twice.
    PreRotation,
}

/// What stands above a root joint.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FbxRoot {
    /// A `Null` of this name, unless the scene has a group there.
    Null(String),
    /// Nothing; groups above it that do nothing are left out.
    None,
}

impl Default for FbxRoot {
    /// `Armature`, as Blender calls it.
    fn default() -> Self {
        Self::Null("Armature".to_owned())
    }
}

/// Where the images of textures are.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum FbxTextures {
    /// In the file itself.
    #[default]
    Embedded,
    /// In files of their own beside it.
    Beside,
}

/// Options of the writer.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::fbx::{FbxOptions, FbxRest, FbxRoot, FbxTarget, FbxTextures, FbxVersion};
/// use mocap::{Exporter, Format};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let maya = FbxOptions::of_target(FbxTarget::Maya);
/// let options = maya.version(FbxVersion::V7400).rest(FbxRest::PreRotation).textures(FbxTextures::Embedded);
/// let written = Exporter::new().fbx(options.root(FbxRoot::None)).write(&scene, Format::Fbx)?;
/// assert!(written.into_bytes()?.starts_with(b"Kaydara FBX Binary"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FbxOptions {
    /// The version of the file.
    pub version: FbxVersion,
    /// Where the rotations of the rest pose are.
    pub rest: FbxRest,
    /// What stands above a root joint.
    pub root: FbxRoot,
    /// Metres in a unit of length of the file. Default: 0.01, centimetres.
    pub metres_per_unit: f64,
    /// The axis that points up in the file. Default: +Y.
    pub up: UpAxis,
    /// Whether a frame rate that is a whole number but for rounding, as that of BVH often is, becomes that number.
    /// Default: `false`.
    pub whole_rate: bool,
    /// The largest error in metres, in any frame, of a joint and of a shell that represents its skin. Within it keys
    /// are dropped from the curves. Default: none, every key is written.
    ///
    /// It holds for programs that evaluate curves of angles, and for those that interpolate the rotations at their
    /// keys. The distance of the shell is the bound's, and at least 3 cm.
    pub error_bound: Option<ErrorBound>,
    /// Where the images of textures are.
    pub textures: FbxTextures,
}

setters! {
    FbxOptions {
        version: FbxVersion,
        rest: FbxRest,
        root: FbxRoot,
        metres_per_unit: f64,
        up: UpAxis,
        whole_rate: bool,
        error_bound: Option<ErrorBound>,
        textures: FbxTextures,
    }
}

/// A program whose conventions a file is to have. `docs/fbx.md` has the source of each.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum FbxTarget {
    /// Blender: centimetres with +Y up, +Y of joints along their bones unless the bone axis is named.
    Blender,
    /// Unreal Engine: centimetres with +Z up, no root above the skeleton, a whole frame rate.
    Unreal,
    /// Unity: metres with +Y up.
    Unity,
    /// Maya: centimetres with +Y up, the rest pose as joint orient.
    Maya,
    /// MotionBuilder: centimetres with +Y up, a root called `Reference`, a whole frame rate.
    #[serde(rename = "motionbuilder")]
    #[cfg_attr(feature = "clap", value(name = "motionbuilder"))]
    MotionBuilder,
}

impl FbxOptions {
    /// The conventions of a program.
    ///
    /// ```
    /// use mocap::fbx::{FbxOptions, FbxRoot, FbxTarget};
    /// use mocap::scene::UpAxis;
    ///
    /// let options = FbxOptions::of_target(FbxTarget::Unreal);
    /// assert_eq!((options.root, options.up), (FbxRoot::None, UpAxis::Z));
    /// ```
    pub fn of_target(target: FbxTarget) -> Self {
        let usual = Self::default();
        match target {
            FbxTarget::Blender => usual,
            FbxTarget::Unreal => Self {
                root: FbxRoot::None,
                up: UpAxis::Z,
                whole_rate: true,
                ..usual
            },
            FbxTarget::Unity => Self {
                metres_per_unit: 1.0,
                ..usual
            },
            FbxTarget::Maya => Self {
                rest: FbxRest::PreRotation,
                ..usual
            },
            FbxTarget::MotionBuilder => Self {
                root: FbxRoot::Null("Reference".to_owned()),
                whole_rate: true,
                ..usual
            },
        }
    }
}

impl Default for FbxOptions {
    fn default() -> Self {
        Self {
            version: FbxVersion::default(),
            rest: FbxRest::default(),
            root: FbxRoot::default(),
            metres_per_unit: 0.01,
            up: UpAxis::Y,
            whole_rate: false,
            error_bound: None,
            textures: FbxTextures::default(),
        }
    }
}
