//! The options of the package, in JavaScript's names, as those of the library. What is left out has the library's
//! default.

use mocap::compress::ErrorBound;
use mocap::convert::RestPoseSource;
use mocap::convert::{FirstFrame, Moment, RootMotion};
use mocap::figure::{HumanoidMap, Unit};
use mocap::gltf::{Compression, GltfOptions};
use mocap::job::{Feet, JointNames};
use mocap::retarget::Scale;
use mocap::retargeting::RetargetingOptions;
use mocap::scene::{Format, RootOffset, RotationOrder, UpAxis};
use mocap::solve::Lengths;
use mocap::{
    Code, Conversion, Diagnostic, Error, Exporter, FormatInfo, Importer, Limits, SkeletonMesh, WriteOption, bvh,
};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::failure::Failure;

/// WebAssembly has 4 GiB of memory at most, in which the file, its scene and what is written of it stand beside each
/// other.
fn limits() -> Limits {
    Limits::new().max_bytes(512 << 20).max_values(1 << 26)
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase", deny_unknown_fields)]
pub(crate) struct ReadOptions {
    root_offset: Option<RootOffset>,
    retime: Option<f64>,
    all_rows: bool,
    collapse_keys: Option<bool>,
    strict: bool,
    hash: Option<bool>,
    format: Option<Format>,
    clip: Option<Clip>,
    /// The name of one of the files.
    body: Option<String>,
    joints: Option<String>,
    lengths: Option<Lengths>,
    markers: Option<String>,
    /// The name of one of the files.
    #[serde(rename = "static")]
    static_trial: Option<String>,
    pub(crate) skeleton_mesh: Option<MeshKind>,
    pub(crate) gltf_meshes: bool,
    morph_targets: bool,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a clip is a name, or a number from 0")]
enum Clip {
    Index(usize),
    Name(String),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum MeshKind {
    Skinned,
    Segmented,
    None,
}

impl ReadOptions {
    pub(crate) fn importer(&self) -> Importer {
        let mut importer = Importer::new()
            .threads(1)
            .limits(limits())
            .root_offset(self.root_offset.unwrap_or_default())
            .all_rows(self.all_rows)
            .strict(self.strict)
            .gltf_meshes(self.gltf_meshes)
            .morph_targets(self.morph_targets)
            .skeleton_mesh(match self.skeleton_mesh {
                None | Some(MeshKind::Skinned) => SkeletonMesh::Skinned,
                Some(MeshKind::Segmented) => SkeletonMesh::Segmented,
                Some(MeshKind::None) => SkeletonMesh::None,
            })
            .clips(match &self.clip {
                None => mocap::Clips::All,
                Some(Clip::Index(index)) => mocap::Clips::Index(*index),
                Some(Clip::Name(name)) => mocap::Clips::Name(name.clone()),
            });
        if let Some(rate) = self.retime {
            importer = importer.retime(rate);
        }
        if let Some(body) = &self.body {
            importer = importer.body(body);
        }
        if let Some(joints) = &self.joints {
            importer = importer.joints(joints);
        }
        if let Some(lengths) = self.lengths {
            importer = importer.lengths(lengths);
        }
        if let Some(markers) = &self.markers {
            importer = importer.markers(markers);
        }
        if let Some(trial) = &self.static_trial {
            importer = importer.static_trial(trial);
        }
        if let Some(collapse) = self.collapse_keys {
            importer = importer.collapse_keys(collapse);
        }
        if let Some(hash) = self.hash {
            importer = importer.hash(hash);
        }
        match self.format {
            Some(format) => importer.format(format),
            None => importer,
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase", deny_unknown_fields)]
pub(crate) struct ConvertOptions {
    unit: Option<Length>,
    up: Option<Axis>,
    out_unit: Option<Length>,
    out_up: Option<Axis>,
    keep_units: bool,
    pub(crate) bones: HumanoidMap,
    first: Option<Moment>,
    last: Option<Moment>,
    frame_rate: Option<f64>,
    first_frame: First,
    rest: Option<String>,
    t_pose_first: bool,
    /// What joints are called.
    names: Option<JointNames>,
    root: Root,
}

/// Metres in one unit of length, or its name.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a unit is m, dm, cm, mm, inch, cmu or a number of metres")]
enum Length {
    Metres(f64),
    Name(String),
}

#[derive(Clone, Copy, Deserialize)]
enum Axis {
    #[serde(rename = "y")]
    Y,
    #[serde(rename = "z")]
    Z,
    #[serde(rename = "-y")]
    NegY,
    #[serde(rename = "-z")]
    NegZ,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
enum First {
    #[default]
    Keep,
    Drop,
    Auto,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
enum Root {
    #[default]
    Keep,
    InPlace,
    Extract,
}

impl Length {
    fn metres(&self) -> Result<f64, Failure> {
        match self {
            Self::Metres(metres) => Ok(*metres),
            Self::Name(name) => Unit::named(name).map(Unit::metres).ok_or_else(|| {
                Failure::argument(format!(
                    "the unit must be m, dm, cm, mm, inch, cmu or a number of metres, got \"{name}\""
                ))
            }),
        }
    }
}

impl From<Axis> for UpAxis {
    fn from(axis: Axis) -> Self {
        match axis {
            Axis::Y => Self::Y,
            Axis::Z => Self::Z,
            Axis::NegY => Self::NegY,
            Axis::NegZ => Self::NegZ,
        }
    }
}

impl ConvertOptions {
    pub(crate) fn conversion(self) -> Result<Conversion, Failure> {
        let mut conversion = Conversion::new()
            .limits(limits())
            .keep_units(self.keep_units)
            .bones(self.bones)
            .trim(self.first, self.last)
            .t_pose_first(self.t_pose_first)
            .first_frame(match self.first_frame {
                First::Keep => FirstFrame::Keep,
                First::Drop => FirstFrame::Drop,
                First::Auto => FirstFrame::DropRestPose,
            })
            .root(match self.root {
                Root::Keep => RootMotion::Keep,
                Root::InPlace => RootMotion::InPlace,
                Root::Extract => RootMotion::Extract,
            });
        if let Some(unit) = self.unit {
            conversion = conversion.metres_per_unit(unit.metres()?);
        }
        if let Some(up) = self.up {
            conversion = conversion.up(up.into());
        }
        if let Some(unit) = self.out_unit {
            conversion = conversion.out_metres_per_unit(unit.metres()?);
        }
        if let Some(up) = self.out_up {
            conversion = conversion.out_up(up.into());
        }
        if let Some(rate) = self.frame_rate {
            conversion = conversion.frame_rate(rate);
        }
        if let Some(rest) = self.rest {
            let rest: RestPoseSource = rest
                .parse()
                .map_err(|error| Failure::argument(format!("rest: {error}, got \"{rest}\"")))?;
            conversion = conversion.rest(rest);
        }
        Ok(conversion)
    }

    /// The names that joints get, where they get others.
    pub(crate) fn names(&self) -> Result<Option<HumanoidMap>, Failure> {
        match &self.names {
            Some(JointNames::File(name)) => Err(Failure::argument(format!(
                "names must be vrm, mixamo, unreal, cmu or an object with the name of each bone, got {:?}",
                name.display().to_string()
            ))),
            names => Ok(names.as_ref().map(JointNames::names).transpose()?),
        }
    }
}

/// Options of all writers; each reads its own.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase", deny_unknown_fields)]
pub(crate) struct WriteOptions {
    keep_constant: bool,
    pub(crate) skeleton_only: bool,
    compress: Option<Compress>,
    max_error: Option<f64>,
    shell_distance: Option<f64>,
    order: Option<RotationOrder>,
    digits: Option<usize>,
    channels: Option<ChannelCount>,
    /// What a picture calls the clip.
    pub(crate) name: Option<String>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase")]
enum Compress {
    None,
    Int16,
}

#[derive(Clone, Copy, Deserialize)]
enum ChannelCount {
    #[serde(rename = "auto")]
    Auto,
    #[serde(rename = "3")]
    Three,
    #[serde(rename = "6")]
    Six,
}

impl WriteOptions {
    pub(crate) fn exporter(&self) -> Exporter {
        let mut exporter = Exporter::new().keep_constant(self.keep_constant).bvh(self.bvh());
        exporter = exporter.compression(match self.compress {
            None | Some(Compress::None) => Compression::None,
            Some(Compress::Int16) => Compression::Int16,
        });
        if let Some(metres) = self.max_error {
            exporter = exporter.max_error(metres);
        }
        if let Some(metres) = self.shell_distance {
            exporter = exporter.shell_distance(metres);
        }
        exporter
    }

    /// How the clip of a character is stored, whose file is passed through.
    pub(crate) fn gltf(&self) -> GltfOptions {
        let compression = match self.compress {
            None | Some(Compress::None) => Compression::None,
            Some(Compress::Int16) => Compression::Int16,
        };
        let has_bound = self.max_error.is_some() || compression != Compression::None;
        let bound = self.max_error.map_or_else(ErrorBound::default, ErrorBound::new);
        let bound = bound.shell_distance(self.shell_distance.unwrap_or_default());
        GltfOptions::new()
            .keep_constant(self.keep_constant)
            .compression(compression)
            .error_bound(has_bound.then_some(bound))
    }

    /// Whether the points of a shell are asked for where nothing is left out.
    pub(crate) fn is_shell_without_bound(&self) -> bool {
        let is_exact = matches!(self.compress, None | Some(Compress::None)) && self.max_error.is_none();
        self.shell_distance.is_some() && is_exact
    }

    /// Why an option that was given has no effect on a format.
    pub(crate) fn refusal(&self, row: &FormatInfo, extension: &str) -> Option<Diagnostic> {
        let given = [
            (WriteOption::KeepConstant, self.keep_constant),
            (WriteOption::SkeletonOnly, self.skeleton_only),
            (WriteOption::Compress, self.compress.is_some()),
            (WriteOption::MaxError, self.max_error.is_some()),
            (WriteOption::ShellDistance, self.shell_distance.is_some()),
            (WriteOption::Order, self.order.is_some()),
            (WriteOption::Digits, self.digits.is_some()),
            (WriteOption::Channels, self.channels.is_some()),
        ];
        let mut given = given.into_iter().filter(|(_, is_given)| *is_given);
        given.find_map(|(option, _)| row.refusal(option, extension))
    }

    fn bvh(&self) -> bvh::BvhOptions {
        bvh::BvhOptions::new()
            .order(self.order)
            .digits(self.digits)
            .channels(match self.channels {
                None | Some(ChannelCount::Auto) => bvh::Channels::Auto,
                Some(ChannelCount::Three) => bvh::Channels::Three,
                Some(ChannelCount::Six) => bvh::Channels::Six,
            })
    }
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase", deny_unknown_fields)]
pub(crate) struct RetargetOptions {
    scale: Option<ScaleOption>,
    feet: Feet,
    bones: HumanoidMap,
    character_bones: HumanoidMap,
    pub(crate) name: Option<String>,
    /// Whether to keep how far the limbs point from those of the motion, for the player.
    pub(crate) limb_angles: bool,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "scale is auto, none or a factor")]
enum ScaleOption {
    Factor(f64),
    Name(ScaleName),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "camelCase")]
enum ScaleName {
    Auto,
    None,
}

impl RetargetOptions {
    pub(crate) fn retargeting(&self) -> Result<RetargetingOptions, Failure> {
        Ok(RetargetingOptions::new()
            .scale(self.scale()?)
            .lock_feet(self.feet == Feet::Lock)
            .source_bones(self.bones.clone())
            .target_bones(self.character_bones.clone()))
    }

    fn scale(&self) -> Result<Scale, Failure> {
        match self.scale {
            None | Some(ScaleOption::Name(ScaleName::Auto)) => Ok(Scale::Auto),
            Some(ScaleOption::Name(ScaleName::None)) => Ok(Scale::None),
            Some(ScaleOption::Factor(factor)) if factor.is_finite() && factor > 0.0 => Ok(Scale::Factor(factor)),
            Some(ScaleOption::Factor(factor)) => Err(Failure::argument(format!(
                "scale must be finite and above 0, got {factor}"
            ))),
        }
    }
}

/// The options of a function of the package, or an error in its words.
pub(crate) fn options_of<T: DeserializeOwned + Default>(function: &str, given: Value) -> Result<T, Failure> {
    match given {
        // Left out.
        Value::Null => Ok(T::default()),
        given => serde_path_to_error::deserialize(given).map_err(|error| {
            let path = error.path().to_string();
            refused(function, &path, &error.into_inner().to_string())
        }),
    }
}

/// What serde says of an option, in the words of the package.
fn refused(function: &str, path: &str, said: &str) -> Failure {
    let listed = |names: &str| names.replace("one of ", "").replace('`', "");
    let parts = |rest: &str| {
        let (name, rest) = rest.split_once('`')?;
        let (_, names) = rest.split_once("expected ")?;
        Some((name.to_owned(), listed(names)))
    };
    if let Some((name, names)) = said.strip_prefix("unknown field `").and_then(parts) {
        let unknown = Diagnostic::new(Code::UnknownOption, format!("{name} is not an option of {function}"));
        return Failure::from(Error::from(unknown.help(format!("its options are {names}"))));
    }
    let message = match said.strip_prefix("unknown variant `").and_then(parts) {
        Some((name, names)) => format!("{path} of {function} must be one of {names}, and is {name}"),
        None => format!(
            "{path} of {function}: {}",
            said.replace("f64", "a number").replace("usize", "a whole number")
        ),
    };
    Failure::argument(message)
}

/// What an option of a job is called in the package: `max-error` is `maxError`.
pub(crate) fn spelling(key: &str) -> String {
    match key {
        "map" => return "bones".to_owned(),
        "from" => return "format".to_owned(),
        "fps" => return "frameRate".to_owned(),
        _ => {}
    }
    let mut words = key.split('-');
    let first = words.next().unwrap_or_default().to_owned();
    words.fold(first, |name, word| {
        let (initial, rest) = word.split_at(word.len().min(1));
        name + &initial.to_uppercase() + rest
    })
}
