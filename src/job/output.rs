//! The output of a job, and its options.

use std::path::{Path, PathBuf};

use mocap_figure::convert::{AlongBone, Conversion};
use mocap_formats::WriteOption;
use mocap_formats::bvh::{BvhOptions, Channels};
use mocap_formats::fbx::{FbxOptions, FbxRest, FbxTarget, FbxTextures, FbxVersion};
use mocap_formats::gltf::{BufferPlace, GltfOptions};
use mocap_io::export::Exporter;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::{RotationOrder, UpAxis};
use serde::{Deserialize, Serialize};

use super::is_default;
use super::names::JointNames;
use super::size::SizeOptions;
use super::text::UnitChoice;

/// The output of a job, and its options. Options that the format does not support are refused.
///
/// ```
/// use mocap::job::OutputOptions;
///
/// let json = r#"{"output": "walk.glb", "smaller": {"max-error": "1mm"}}"#;
/// let writing: OutputOptions = serde_json::from_str(json).unwrap();
/// assert_eq!(writing.smaller.max_error.unwrap().to_metres(), 0.001);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Writing"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OutputOptions {
    /// The file to write; its extension names the format. - is standard output. If output is an existing folder or ends
    /// in /, `mocap run` writes one file for each motion.
    #[cfg_attr(feature = "clap", arg(skip))]
    pub output: PathBuf,
    /// The output format, as a file extension, if it differs from the extension of the output. Or the name of an array
    /// layout, such as amass, humanml3d, qpos or gmr.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "is_default")]
    pub to: Option<String>,
    /// Whether the output may replace a file that may be a source. An input is never replaced.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "is_default")]
    pub force: bool,
    /// The unit and the up axis of the output.
    // Before the options that have a heading in help.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(skip_serializing_if = "is_default")]
    pub space: OutSpace,
    /// How to draw the skeleton of a file without meshes [default: skinned; for .fbx none]
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND"))]
    #[serde(skip_serializing_if = "is_default")]
    pub mesh: Option<MeshStyle>,
    /// Rotate the axes of joints at rest so that this axis points along the bone, and another is the bending axis.
    /// Positions do not change. Blender draws bones along +Y [default: none; for the target blender y]
    #[cfg_attr(feature = "clap", arg(long, value_name = "AXIS"))]
    #[serde(skip_serializing_if = "is_default")]
    pub bone_axis: Option<OutBoneAxis>,
    /// Write only the skeleton and its motion, without the meshes, materials and other contents of the input
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub skeleton_only: bool,
    /// Keep constant tracks in the animation. By default they become part of the rest pose
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub keep_constant: bool,
    /// Names of joints in the output: vrm, mixamo, unreal, cmu, godot, unity, mhr, soma, or a JSON file. The file has
    /// {"bones": {"hips": "NAME", ...}}, as `mocap skeleton --json` prints [default: the names in the input]
    #[cfg_attr(feature = "clap", arg(long, value_name = "NAMES", value_parser = parse_names))]
    #[serde(skip_serializing_if = "is_default")]
    pub names: Option<JointNames>,
    /// Embed the buffer in a .gltf file, instead of writing a separate .bin file
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub embed: bool,
    /// Options of BVH.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(skip_serializing_if = "is_default")]
    pub bvh: BvhOutputOptions,
    /// Options of FBX.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(skip_serializing_if = "is_default")]
    pub fbx: FbxOutputOptions,
    /// Fewer keys and bits.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(skip_serializing_if = "is_default")]
    pub smaller: SizeOptions,
}

/// The one file of a survey or of a motion graph.
///
/// ```
/// use mocap::job::FileOutputOptions;
///
/// let writing: FileOutputOptions = serde_json::from_str(r#"{"output": "rows.csv"}"#).unwrap();
/// assert_eq!(writing.output(), Some("rows.csv".as_ref()));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FileOutputOptions {
    /// The file to write; its extension names the format. - is standard output. Default: nothing is written.
    #[serde(skip_serializing_if = "is_default")]
    pub output: PathBuf,
    /// The output format, as a file extension, if it differs from the extension of the output.
    #[serde(skip_serializing_if = "is_default")]
    pub to: Option<String>,
    /// Whether the output may replace a file that may be a source. An input is never replaced.
    #[serde(skip_serializing_if = "is_default")]
    pub force: bool,
}

/// The unit and the up axis of an output.
///
/// ```
/// use mocap::job::OutSpace;
///
/// let space: OutSpace = serde_json::from_str(r#"{"out-unit": "cm"}"#).unwrap();
/// assert_eq!(space.metres_per_unit(), Some(0.01));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Writing"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OutSpace {
    /// Unit of length of the output: m, dm, cm, mm, inch, cmu, or metres in one unit [default: the input's; glTF is in
    /// metres]
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT", value_parser = super::text::parse_unit))]
    #[serde(skip_serializing_if = "is_default")]
    pub out_unit: Option<UnitChoice>,
    /// Up axis of the output [default: the input's; glTF has +Y up]
    #[cfg_attr(feature = "clap", arg(long, value_name = "AXIS"))]
    #[serde(skip_serializing_if = "is_default")]
    pub out_up: Option<OutUp>,
}

/// The up axis of an output.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum OutUp {
    /// +Y.
    Y,
    /// +Z.
    Z,
}

/// The axis of a joint at rest that points along its bone.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum OutBoneAxis {
    /// +Y, as Blender draws bones; joints bend about +X.
    Y,
    /// +X, as in Unreal; joints bend about +Z.
    X,
    /// Joints keep the axes of the input.
    None,
}

/// How the skeleton of a file without meshes is drawn.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum MeshStyle {
    /// One mesh per node.
    Segmented,
    /// One mesh with bones.
    Skinned,
    /// No mesh.
    None,
}

impl From<MeshStyle> for SkeletonMesh {
    fn from(mesh: MeshStyle) -> Self {
        match mesh {
            MeshStyle::Segmented => Self::Segmented,
            MeshStyle::Skinned => Self::Skinned,
            MeshStyle::None => Self::None,
        }
    }
}

/// Options of BVH.
///
/// ```
/// use mocap::job::BvhOutputOptions;
///
/// let bvh: BvhOutputOptions = serde_json::from_str(r#"{"order": "XYZ", "digits": 4}"#).unwrap();
/// assert_eq!(bvh.options().digits, Some(4));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Writing BVH"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BvhOutputOptions {
    /// Order of the rotation channels [default: each joint's own, or else ZXY]
    #[cfg_attr(feature = "clap", arg(long, value_name = "ORDER", value_parser = parse_order))]
    #[serde(skip_serializing_if = "is_default")]
    pub order: Option<RotationOrder>,
    /// Decimals of every number [default: enough to read back the same motion]
    #[cfg_attr(feature = "clap", arg(long, value_name = "N"))]
    #[serde(skip_serializing_if = "is_default")]
    pub digits: Option<usize>,
    /// Which joints have position channels
    #[cfg_attr(feature = "clap", arg(long, value_name = "KIND", default_value = "auto"))]
    #[serde(skip_serializing_if = "is_default")]
    pub channels: Channels,
    /// For a .bvh OUTPUT, also write OUTPUT.json with its provenance. Every command reads this file, including verify
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub sidecar: bool,
}

/// Options of FBX.
///
/// ```
/// use mocap::fbx::FbxRoot;
/// use mocap::job::FbxOutputOptions;
///
/// let fbx: FbxOutputOptions = serde_json::from_str(r#"{"target": "unreal"}"#).unwrap();
/// assert_eq!(fbx.options().root, FbxRoot::None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Writing FBX"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FbxOutputOptions {
    /// Version of the file
    #[cfg_attr(feature = "clap", arg(long, value_name = "VERSION", default_value = "7.5"))]
    #[serde(skip_serializing_if = "is_default")]
    pub fbx_version: FbxVersion,
    /// Where to store the rotations of the rest pose [default: rotation; for the target maya pre-rotation]
    #[cfg_attr(feature = "clap", arg(long, value_name = "WHERE"))]
    #[serde(skip_serializing_if = "is_default")]
    pub fbx_rest: Option<FbxRest>,
    /// The program whose conventions the file follows: unit, axes, root, frame rate
    #[cfg_attr(feature = "clap", arg(long, value_name = "PROGRAM"))]
    #[serde(skip_serializing_if = "is_default")]
    pub target: Option<FbxTarget>,
    /// Where to store the images of textures
    #[cfg_attr(feature = "clap", arg(long, value_name = "WHERE", default_value = "embedded"))]
    #[serde(skip_serializing_if = "is_default")]
    pub textures: FbxTextures,
}

impl FileOutputOptions {
    /// The file to write, if any.
    pub fn output(&self) -> Option<&Path> {
        Some(self.output.as_path()).filter(|output| !output.as_os_str().is_empty())
    }

    /// The extension that names the format, in lower case.
    pub(super) fn extension(&self) -> String {
        extension(&self.output, self.to.as_deref())
    }
}

fn extension(output: &Path, to: Option<&str>) -> String {
    let extension = output.extension().and_then(|extension| extension.to_str());
    to.or(extension).unwrap_or_default().to_ascii_lowercase()
}

impl OutSpace {
    /// A conversion to the stated unit and axis.
    pub(super) fn of(&self, mut conversion: Conversion) -> Conversion {
        if let Some(metres) = self.metres_per_unit() {
            conversion = conversion.out_metres_per_unit(metres);
        }
        match self.up() {
            Some(up) => conversion.out_up(up),
            None => conversion,
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        is_default(self)
    }

    /// Metres per unit of the output, if stated.
    pub fn metres_per_unit(&self) -> Option<f64> {
        self.out_unit.and_then(UnitChoice::metres)
    }

    /// The up axis of the output, if stated.
    pub fn up(&self) -> Option<UpAxis> {
        self.out_up.map(|up| match up {
            OutUp::Y => UpAxis::Y,
            OutUp::Z => UpAxis::Z,
        })
    }
}

impl BvhOutputOptions {
    /// The options of the writer.
    pub fn options(&self) -> BvhOptions {
        BvhOptions::new()
            .order(self.order)
            .digits(self.digits)
            .channels(self.channels)
            .sidecar(self.sidecar)
    }
}

impl FbxOutputOptions {
    /// The options of the writer.
    pub fn options(&self) -> FbxOptions {
        let options = self.target.map(FbxOptions::of_target).unwrap_or_default();
        let rest = self.fbx_rest.unwrap_or(options.rest);
        options.version(self.fbx_version).rest(rest).textures(self.textures)
    }
}

impl OutputOptions {
    /// The stated options that only some formats support.
    pub(super) fn stated(&self) -> Vec<WriteOption> {
        let Self {
            smaller,
            bvh,
            fbx,
            space,
            ..
        } = self;
        let all = [
            (WriteOption::BoneAxis, self.bone_axis.is_some()),
            (WriteOption::Mesh, self.mesh.is_some()),
            (WriteOption::SkeletonOnly, self.skeleton_only),
            (WriteOption::KeepConstant, self.keep_constant),
            (WriteOption::Embed, self.embed),
            (WriteOption::OutUnit, space.out_unit.is_some()),
            (WriteOption::OutUp, space.out_up.is_some()),
            (WriteOption::MaxError, smaller.max_error.is_some()),
            (WriteOption::ShellDistance, smaller.shell_distance.is_some()),
            (WriteOption::Compress, smaller.compress.is_some()),
            (WriteOption::Names, self.names.is_some()),
            (WriteOption::Order, bvh.order.is_some()),
            (WriteOption::Digits, bvh.digits.is_some()),
            (WriteOption::Channels, bvh.channels != Channels::default()),
            (WriteOption::Sidecar, bvh.sidecar),
            (WriteOption::FbxVersion, fbx.fbx_version != FbxVersion::default()),
            (WriteOption::FbxRest, fbx.fbx_rest.is_some()),
            (WriteOption::Target, fbx.target.is_some()),
            (WriteOption::Textures, fbx.textures != FbxTextures::default()),
        ];
        let stated = all.into_iter().filter(|(_, is_stated)| *is_stated);
        stated.map(|(option, _)| option).collect()
    }

    /// The axis of a joint that points along its bone; `None` if joints keep the axes of the file.
    ///
    /// Default: depends on the target program of an FBX file. Clips for Unreal, Unity, Maya and MotionBuilder are for
    /// existing skeletons, and must keep their axes.
    pub fn along_bone(&self) -> Option<AlongBone> {
        match (self.bone_axis, self.fbx.target) {
            (Some(OutBoneAxis::Y), _) | (None, Some(FbxTarget::Blender)) => Some(AlongBone::Y),
            (Some(OutBoneAxis::X), _) => Some(AlongBone::X),
            (Some(OutBoneAxis::None) | None, _) => None,
        }
    }

    /// The extension that names the format, in lower case.
    pub(super) fn extension(&self) -> String {
        extension(&self.output, self.to.as_deref())
    }

    /// The name of an output's files at `path`, with the extension of the format.
    pub(super) fn name_of(&self, path: &Path) -> PathBuf {
        let extension = self.extension();
        match path.extension() {
            _ if path == Path::new("-") => Path::new("scene").with_extension(extension),
            Some(own) if own.eq_ignore_ascii_case(&extension) => path.to_owned(),
            _ => path.with_extension(extension),
        }
    }

    /// An exporter with the options of the output, but without its format.
    pub fn exporter(&self) -> Exporter {
        let mut exporter = Exporter::new()
            .keep_constant(self.keep_constant)
            .bvh(self.bvh.options())
            .fbx(self.fbx.options());
        if let Some(length) = self.smaller.max_error {
            exporter = exporter.max_error(length.to_metres());
        }
        if let Some(length) = self.smaller.shell_distance {
            exporter = exporter.shell_distance(length.to_metres());
        }
        if let Some(kind) = self.smaller.compress {
            exporter = exporter.compression(kind);
        }
        exporter.buffer(self.buffer())
    }

    /// The storage options for the clips of a character whose file is passed through.
    #[doc(hidden)]
    pub fn gltf(&self) -> GltfOptions {
        self.smaller.gltf().buffer(self.buffer())
    }

    fn buffer(&self) -> BufferPlace {
        match self.embed || self.is_stream() {
            true => BufferPlace::Embedded,
            false => BufferPlace::Beside,
        }
    }

    /// Whether the output is standard output, which can hold only one file.
    pub fn is_stream(&self) -> bool {
        self.output == Path::new("-")
    }

    /// Whether the output is a folder with one file for each motion: an existing folder, or a name that ends in a
    /// separator.
    pub fn is_folder(&self) -> bool {
        self.output.is_dir() || self.output.to_string_lossy().ends_with(std::path::is_separator)
    }
}

#[cfg(feature = "clap")]
fn parse_names(names: &str) -> Result<JointNames, String> {
    JointNames::parse(names).map_err(|error| error.diagnostic().message.clone())
}

#[cfg(feature = "clap")]
fn parse_order(text: &str) -> Result<RotationOrder, String> {
    let named = |order: &RotationOrder| format!("{order:?}").eq_ignore_ascii_case(text);
    RotationOrder::ALL
        .into_iter()
        .find(named)
        .ok_or_else(|| "none of XYZ, XZY, YXZ, YZX, ZXY, ZYX".to_owned())
}
