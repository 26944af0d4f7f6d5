//! The inputs of a job, and the caller's statements that the files lack.

use std::collections::BTreeMap;
use std::path::PathBuf;

use mocap_figure::convert::RestPoseSource;
use mocap_figure::convert::{Conversion, FirstFrame, RootMotion, Space, TimeRange};
use mocap_figure::{HumanoidBone, HumanoidMap};
use mocap_io::import::read_text;
use mocap_scene::error::{Code, Diagnostic, Result, nearest};
use mocap_scene::scene::{Scene, UpAxis};
use serde::{Deserialize, Serialize};

#[cfg(feature = "clap")]
use super::input::InputOptions;
use super::is_default;
use super::text::{UnitChoice, UpChoice};

/// The inputs of a job.
///
/// ```
/// use mocap::job::Sources;
///
/// let source: Sources = serde_json::from_str(r#"{"inputs": ["walk.bvh"], "space": {"unit": "cm"}}"#).unwrap();
/// assert_eq!(source.space.unit.metres(), Some(0.01));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Sources {
    /// The motion files.
    pub inputs: Vec<PathBuf>,
    /// The second motions, which steps join, blend or layer with the first; a step counts them from 2.
    #[serde(skip_serializing_if = "is_default")]
    pub with: Vec<PathBuf>,
    /// The unit and the up axis of the inputs.
    #[serde(skip_serializing_if = "is_default")]
    pub space: SourceSpace,
    /// The joint of each bone, if the guess is wrong: a JSON file, or the names here.
    #[serde(skip_serializing_if = "is_default")]
    pub map: SourceMap,
    /// The frames to use from the inputs.
    #[serde(skip_serializing_if = "is_default")]
    pub frames: SourceFrames,
}

/// The unit and the up axis of the inputs.
///
/// ```
/// use mocap::job::SourceSpace;
///
/// let space: SourceSpace = serde_json::from_str(r#"{"up": "z"}"#).unwrap();
/// assert_eq!((space.unit.metres(), space.up.axis()), (None, Some(mocap::scene::UpAxis::Z)));
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Reading"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SourceSpace {
    /// Unit of length of the input: auto, m, dm, cm, mm, inch, cmu (5.6444 cm), or metres in one unit
    #[cfg_attr(feature = "clap", arg(long, value_name = "UNIT", default_value = "auto"))]
    #[serde(skip_serializing_if = "is_default")]
    pub unit: UnitChoice,
    /// The up axis of the input; auto: from the feet to the head.
    #[cfg_attr(feature = "clap", command(flatten))]
    #[serde(skip_serializing_if = "is_default")]
    pub up: SourceUp,
}

/// The up axis of the inputs.
///
/// ```
/// use mocap::job::SourceUp;
///
/// let up: SourceUp = serde_json::from_str("\"-y\"").unwrap();
/// assert_eq!(up.axis(), Some(mocap::scene::UpAxis::NegY));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Reading"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SourceUp {
    /// Up axis of the input: auto (from the feet to the head), y, z, -y or -z
    #[cfg_attr(
        feature = "clap",
        arg(long, value_name = "AXIS", default_value = "auto", allow_hyphen_values = true)
    )]
    pub up: UpChoice,
}

/// The bones of the inputs, if the guess is wrong or not wanted.
///
/// ```
/// use mocap::job::SourceMap;
///
/// let map: SourceMap = serde_json::from_str(r#"{"hips": "Pelvis"}"#).unwrap();
/// assert_eq!(map.bones()?.len(), 1);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Reading"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SourceMap {
    /// Read the bones from this JSON file, as `mocap skeleton --json` prints it. Bones that the file omits are searched
    /// for
    #[cfg_attr(feature = "clap", arg(long, value_name = "FILE", value_parser = |path: &str| BoneMap::parse_file(path).map(BoneMap::Bones)))]
    pub map: Option<BoneMap>,
}

/// The joint of each bone, in a file or here.
///
/// A file holds `{"bones": {"hips": "NAME", ...}}`, or the output of `mocap skeleton --json`. `"follow": {"FootIK.L":
/// "leftFoot"}` lets a joint follow a bone or another joint instead of its parent. In a file, `follow` is next to
/// `bones`; here it is among the bones.
///
/// ```
/// use mocap::job::BoneMap;
///
/// let map: BoneMap = serde_json::from_str(r#"{"hips": "Pelvis", "jaw": null}"#).unwrap();
/// assert_eq!(map.bones()?.len(), 2); // the jaw is not searched for
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "the name of a file, or an object with the joint of each bone")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum BoneMap {
    /// A JSON file.
    File(PathBuf),
    /// The name of the joint of each bone; `null` to not search for a bone. `follow` has joints that follow a bone, or
    /// another joint, instead of their parents.
    Bones(#[cfg_attr(feature = "schema", schemars(with = "BTreeMap<String, MapEntry>"))] HumanoidMap),
}

/// The bones of a map in a job.
#[cfg(feature = "schema")]
#[derive(schemars::JsonSchema)]
#[schemars(untagged, inline)]
#[allow(dead_code, reason = "only its schema is used")]
enum MapEntry {
    Joint(Option<String>),
    Follow(BTreeMap<String, String>),
}

impl BoneMap {
    /// The bones.
    ///
    /// # Errors
    /// [`Code::Io`] if the file cannot be read, and [`Code::InvalidValue`] if the file has no bones.
    pub fn bones(&self) -> Result<HumanoidMap> {
        match self {
            Self::Bones(bones) => Ok(bones.clone()),
            Self::File(path) => {
                let text = read_text(path)?;
                bones_of(&text).map_err(|message| {
                    let error = mocap_scene::error::Error::from(Diagnostic::new(Code::InvalidValue, message));
                    error.with_path(path)
                })
            }
        }
    }

    /// Parses the file of an option. The file is read at once, so that a bad file is refused before the work begins.
    #[cfg(feature = "clap")]
    pub fn parse_file(path: &str) -> Result<HumanoidMap, String> {
        let bones = Self::File(PathBuf::from(path)).bones();
        bones.map_err(|error| error.diagnostic().message.clone())
    }
}

/// The output of `mocap skeleton --json`, or its part `humanoid`.
#[derive(Deserialize)]
struct MapFile {
    humanoid: Option<Box<MapFile>>,
    bones: Option<BTreeMap<StatedBone, Option<MapBone>>>,
    #[serde(default)]
    follow: BTreeMap<String, String>,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "each bone must have the name of a joint in quotes, null, or an object with \"joint\""
)]
enum MapBone {
    Name(String),
    Bone { joint: String },
}

/// The name of a bone in a file.
#[derive(PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "String")]
struct StatedBone(HumanoidBone);

impl TryFrom<String> for StatedBone {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let bone = HumanoidBone::from_name(&name).map(Self);
        bone.ok_or_else(|| {
            let names = HumanoidBone::ALL.iter().map(|bone| bone.as_str());
            let near = nearest(&name, names).map(|near| format!("; did you mean {near:?}?"));
            let near = near.unwrap_or_else(|| ": bones have the names of VRM, such as \"leftUpperLeg\"".to_owned());
            format!("unknown bone {name:?}{near}")
        })
    }
}

fn bones_of(text: &str) -> Result<HumanoidMap, String> {
    let file: MapFile = serde_json::from_str(text).map_err(|error| error.to_string())?;
    let MapFile {
        humanoid,
        bones,
        follow,
    } = file;
    let within = humanoid.map_or((None, BTreeMap::new()), |humanoid| (humanoid.bones, humanoid.follow));
    let bones = match within.0.or(bones) {
        None if follow.is_empty() => {
            return Err("there is no object \"bones\": write {\"bones\": {\"hips\": \"NAME\", ...}}".to_owned());
        }
        bones => bones.unwrap_or_default(),
    };
    let mut map = HumanoidMap::new();
    for (StatedBone(bone), joint) in bones {
        let joint = joint.map(|joint| match joint {
            MapBone::Name(joint) | MapBone::Bone { joint } => joint,
        });
        map.insert(bone, joint);
    }
    map.follow = within.1.into_iter().chain(follow).collect();
    Ok(map)
}

/// The frames to use from the inputs. They are selected before the unit and the axes are converted.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::job::SourceFrames;
///
/// let frames: SourceFrames = serde_json::from_str(r#"{"trim": "0..1.5", "fps": 30}"#).unwrap();
/// let mut scene = mocap::import("fixtures/real/cmu_short.bvh")?;
/// frames.conversion().apply(&mut scene)?;
/// assert_eq!(scene.animations[0].ticks_per_second, 30.0);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "clap", derive(clap::Args), command(next_help_heading = "Changing"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct SourceFrames {
    /// Part to keep, both ends included: A..B in seconds, or Af..Bf in frames; either end is optional
    #[cfg_attr(feature = "clap", arg(long, value_name = "A..B", allow_hyphen_values = true))]
    #[serde(skip_serializing_if = "is_default")]
    pub trim: Option<TimeRange>,
    /// Resample to this number of frames per second, at the same playback speed. For an input without a valid rate, set
    /// its rate
    #[cfg_attr(feature = "clap", arg(long, value_name = "RATE", value_parser = InputOptions::parse_rate))]
    #[serde(skip_serializing_if = "is_default")]
    pub fps: Option<f64>,
    /// Whether to drop the first frame; auto: drop it if it is a rest pose and the motion jumps after it
    #[cfg_attr(feature = "clap", arg(long, value_name = "WHEN", default_value = "no"))]
    #[serde(skip_serializing_if = "is_default")]
    pub drop_first_frame: FirstFrame,
    /// Rest pose: zero (as in the file; in BVH all rotations are 0), t-pose, a-pose (arms 45 degrees down), or frame:N
    #[cfg_attr(feature = "clap", arg(long, value_name = "POSE", default_value = "zero"))]
    #[serde(skip_serializing_if = "is_default")]
    pub rest: RestPoseSource,
    /// Insert the T-pose before the first frame, on the floor
    #[cfg_attr(feature = "clap", arg(long))]
    #[serde(skip_serializing_if = "is_default")]
    pub t_pose_first: bool,
    /// The root motion: kept, removed, or moved to a joint above the root.
    // Not an argument: a command line has two switches for it.
    #[cfg_attr(feature = "clap", arg(skip))]
    #[serde(skip_serializing_if = "is_default")]
    pub root: RootMotion,
}

impl SourceSpace {
    /// Metres per unit of the input, if known.
    pub fn metres_per_unit(&self) -> Option<f64> {
        self.unit.metres()
    }

    /// The up axis of the input, if known.
    pub fn up(&self) -> Option<UpAxis> {
        self.up.axis()
    }

    /// Sets the stated unit and up axis in the scene. A value that contradicts the file gives a warning.
    pub fn state(&self, scene: &mut Scene) {
        self.space().state(scene);
    }

    /// A warning for each stated unit or up axis that contradicts the scene's file.
    pub fn contradictions(&self, scene: &Scene) -> Vec<Diagnostic> {
        self.space().contradictions(&scene.metadata)
    }

    fn space(&self) -> Space {
        Space {
            metres_per_unit: self.unit.metres(),
            up: self.up.axis(),
        }
    }
}

impl SourceUp {
    /// The axis, if known.
    pub fn axis(self) -> Option<UpAxis> {
        self.up.axis()
    }

    /// Sets the stated axis in the scene. A file that states another axis gives a warning.
    pub fn state(self, scene: &mut Scene) {
        let space = Space {
            metres_per_unit: None,
            up: self.axis(),
        };
        space.state(scene);
    }
}

impl SourceMap {
    /// The bones that are stated here; none if the map is in a file.
    pub fn bones_here(&self) -> HumanoidMap {
        match &self.map {
            Some(BoneMap::Bones(bones)) => bones.clone(),
            _ => HumanoidMap::default(),
        }
    }

    /// The bones; none without a map.
    ///
    /// # Errors
    /// As [`BoneMap::bones`].
    pub fn bones(&self) -> Result<HumanoidMap> {
        self.map
            .as_ref()
            .map_or_else(|| Ok(HumanoidMap::default()), BoneMap::bones)
    }
}

impl SourceFrames {
    /// A conversion with these frames.
    pub fn conversion(&self) -> Conversion {
        let TimeRange { first, last } = self.trim.unwrap_or_default();
        let conversion = Conversion::new()
            .first_frame(self.drop_first_frame)
            .rest(self.rest)
            .root(self.root)
            .t_pose_first(self.t_pose_first)
            .trim(first, last);
        match self.fps {
            Some(rate) => conversion.frame_rate(rate),
            None => conversion,
        }
    }
}
