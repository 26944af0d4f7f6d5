//! The options of the writer.

use serde::{Deserialize, Serialize};

use mocap_compress::ErrorBound;
use mocap_scene::options::setters;
use mocap_scene::scene::UpAxis;

/// The version of an FBX file.
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

/// Which property stores the rotations of the rest pose.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum FbxRest {
    /// `Lcl Rotation`, as Blender writes: curves have the complete rotation.
    #[default]
    Rotation,
    /// `PreRotation`, which Maya shows as joint orient: all rotations of the rest pose are zero. Assimp 5.2 applies the
    /// pre-rotation of animated joints twice.
    PreRotation,
}

/// The node above a root joint.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FbxRoot {
    /// A `Null` with this name, unless the scene has a group above the root joint.
    Null(String),
    /// No node. Groups above the root joint that do nothing are dropped.
    None,
}

impl Default for FbxRoot {
    /// A `Null` with Blender's name `Armature`.
    fn default() -> Self {
        Self::Null("Armature".to_owned())
    }
}

/// Where the images of textures are stored.
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
    /// In separate files beside the FBX file.
    Beside,
}

/// Options of the FBX writer.
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
    /// Which property stores the rotations of the rest pose.
    pub rest: FbxRest,
    /// The node above a root joint.
    pub root: FbxRoot,
    /// The unit of length of the file, in metres. Default: 0.01 (centimetres).
    pub metres_per_unit: f64,
    /// The axis that points up in the file. Default: +Y.
    pub up: UpAxis,
    /// Whether to round a frame rate that is almost a whole number, such as 29.9997. BVH files often have such rates.
    /// Default: `false`.
    pub whole_rate: bool,
    /// The largest error of a joint in any frame, in metres. It also applies to a shell around the joint, which
    /// represents the joint's skin. The writer drops keys from the curves as long as the error stays below this bound.
    /// Default: none, every key is written.
    ///
    /// The error limit applies to programs that evaluate the curves of angles, and to programs that interpolate
    /// rotations between keys. The distance of the shell is the distance that the bound states, but at least 3 cm.
    pub error_bound: Option<ErrorBound>,
    /// Where the images of textures are stored.
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

/// A program whose conventions the file follows. `docs/fbx.md` has the source of each convention.
///
/// [`FbxOptions`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum FbxTarget {
    /// Blender: centimetres with +Y up, and +Y of joints along their bones unless an option sets the bone axis.
    Blender,
    /// Unreal Engine: centimetres with +Z up, no node above the skeleton, a whole frame rate.
    Unreal,
    /// Unity: metres with +Y up.
    Unity,
    /// Maya: centimetres with +Y up, the rest pose as joint orient.
    Maya,
    /// MotionBuilder: centimetres with +Y up, a root named `Reference`, a whole frame rate.
    #[serde(rename = "motionbuilder")]
    #[cfg_attr(feature = "clap", value(name = "motionbuilder"))]
    MotionBuilder,
}

impl FbxOptions {
    /// Options with the conventions of a program.
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
