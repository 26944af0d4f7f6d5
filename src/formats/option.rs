//! The options of writing a format, by the names that users type.

use std::fmt;

use mocap_scene::error::{Code, Diagnostic};

use super::FormatInfo;

/// A writing option. The row of a format lists the options that change its files.
///
/// ```
/// use mocap::{Format, FormatInfo, WriteOption};
///
/// let gltf = FormatInfo::of(Format::Gltf);
/// assert!(gltf.takes(WriteOption::MaxError) && !gltf.takes(WriteOption::Digits));
/// let refusal = gltf.refusal(WriteOption::Digits, "glb").unwrap();
/// assert_eq!(
///     refusal.message,
///     "`digits` has no effect on glTF: it applies to BVH; write .bvh, or omit it"
/// );
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum WriteOption {
    /// A mesh that shows the skeleton, for a file without meshes: `mesh`.
    Mesh,
    /// An output without the meshes and other contents of the input file: `skeleton-only`.
    SkeletonOnly,
    /// Channels for constant tracks: `keep-constant`.
    KeepConstant,
    /// The buffer within a `.gltf`: `embed`.
    Embed,
    /// The storage of keys: `compress`.
    Compress,
    /// The largest distance of a joint from its position: `max-error`.
    MaxError,
    /// The radius of a shell whose points also keep the largest error: `shell-distance`.
    ShellDistance,
    /// The order of rotation channels: `order`.
    Order,
    /// The number of decimals: `digits`.
    Digits,
    /// The joints with position channels: `channels`.
    Channels,
    /// A sidecar file that states how the output was made: `sidecar`.
    Sidecar,
    /// The version of an FBX file: `fbx-version`.
    FbxVersion,
    /// The place of rest rotations in FBX: `fbx-rest`.
    FbxRest,
    /// The program whose conventions the file follows: `target`.
    Target,
    /// The place of texture images: `textures`.
    Textures,
    /// The axis of joints that points along their bones: `bone-axis`.
    BoneAxis,
    /// The unit of length of the file, for a format without a unit: `out-unit`.
    OutUnit,
    /// The up axis of the file, for a format without an up axis: `out-up`.
    OutUp,
    /// The joint names: `names`.
    Names,
    /// The rest pose: `rest`.
    Rest,
    /// The root motion on a separate node: `root-motion`.
    RootMotion,
}

impl WriteOption {
    /// All options.
    pub const ALL: [Self; 21] = [
        Self::Mesh,
        Self::SkeletonOnly,
        Self::KeepConstant,
        Self::Embed,
        Self::Compress,
        Self::MaxError,
        Self::ShellDistance,
        Self::Order,
        Self::Digits,
        Self::Channels,
        Self::Sidecar,
        Self::FbxVersion,
        Self::FbxRest,
        Self::Target,
        Self::Textures,
        Self::BoneAxis,
        Self::OutUnit,
        Self::OutUp,
        Self::Names,
        Self::Rest,
        Self::RootMotion,
    ];

    /// The name that users type, without leading dashes.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Mesh => "mesh",
            Self::SkeletonOnly => "skeleton-only",
            Self::KeepConstant => "keep-constant",
            Self::Embed => "embed",
            Self::Compress => "compress",
            Self::MaxError => "max-error",
            Self::ShellDistance => "shell-distance",
            Self::Order => "order",
            Self::Digits => "digits",
            Self::Channels => "channels",
            Self::Sidecar => "sidecar",
            Self::FbxVersion => "fbx-version",
            Self::FbxRest => "fbx-rest",
            Self::Target => "target",
            Self::Textures => "textures",
            Self::BoneAxis => "bone-axis",
            Self::OutUnit => "out-unit",
            Self::OutUp => "out-up",
            Self::Names => "names",
            Self::Rest => "rest",
            Self::RootMotion => "root-motion",
        }
    }

    /// The only extension for which the option has an effect; `None` if it has an effect for every extension.
    fn extension(self) -> Option<&'static str> {
        match self {
            // A .glb contains its buffer.
            Self::Embed => Some("gltf"),
            _ => None,
        }
    }
}

impl fmt::Display for WriteOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl FormatInfo {
    /// Whether an option changes the files of this format.
    pub fn takes(&self, option: WriteOption) -> bool {
        self.options.contains(&option)
    }

    /// The reason why an option has no effect on a file of this format with this extension; `None` if it has an effect.
    pub fn refusal(&self, option: WriteOption, extension: &str) -> Option<Diagnostic> {
        let only = option.extension();
        if self.takes(option) && only.is_none_or(|only| only.eq_ignore_ascii_case(extension)) {
            return None;
        }
        let on = match self.takes(option) {
            true => format!(".{extension}"),
            false => self.name.to_owned(),
        };
        let taking: Vec<&FormatInfo> = FormatInfo::ALL.iter().filter(|row| row.takes(option)).collect();
        let extensions = taking.iter().flat_map(|row| row.extensions.iter().copied());
        let extensions: Vec<&str> = only.map_or_else(|| extensions.collect(), |only| vec![only]);
        let applies_to = match only {
            Some(only) => format!(".{only}"),
            None => words(taking.iter().map(|row| row.name.to_owned()), "and"),
        };
        let write = words(extensions.iter().map(|extension| format!(".{extension}")), "or");
        let message =
            format!("{{{option}}} has no effect on {on}: it applies to {applies_to}; write {write}, or omit it");
        Some(Diagnostic::new(Code::InvalidValue, message))
    }
}

/// Joins words: `.glb, .gltf or .bvh`.
#[doc(hidden)]
pub fn words(items: impl Iterator<Item = String>, last: &str) -> String {
    let items: Vec<String> = items.collect();
    match items.as_slice() {
        [before @ .., end] if !before.is_empty() => format!("{} {last} {end}", before.join(", ")),
        _ => items.concat(),
    }
}
