//! The target to which a job retargets its motions.

use std::path::{Path, PathBuf};

use mocap_retarget::RetargetOptions;
use mocap_retarget::Scale;
use mocap_retarget::report::ClipReport;
use mocap_retarget::report::Verdict;
use mocap_retarget::robot::report::{Floor, TimeScale};
use mocap_scene::error::{Code, Diagnostic, Result, spelled};
use serde::{Deserialize, Serialize};

use super::is_default;
use super::source::BoneMap;
use super::text::Angle;

/// The target to which a job retargets its motions. Each kind has only its own options.
///
/// ```
/// use mocap::job::JobTarget;
///
/// let target: JobTarget = serde_json::from_str(r#"{"robot": {"file": "g1.urdf", "velocity-limits": true}}"#).unwrap();
/// assert!(matches!(target, JobTarget::Robot(robot) if robot.velocity_limits));
/// let wrong = r#"{"character": {"file": "hero.vrm", "velocity-limits": true}}"#;
/// assert!(serde_json::from_str::<JobTarget>(wrong).is_err());
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum JobTarget {
    /// A character. A glTF or VRM file keeps all its contents, and the motions are added.
    Character(CharacterTarget),
    /// Only the skeleton of a file, without its other contents.
    Skeleton(SkeletonTarget),
    /// A robot of URDF or MJCF.
    Robot(RobotTarget),
}

/// Defines a kind of target: the shared options, then its own. On a command line the map option has its own name. The
/// macro repeats the shared options, because serde's `flatten` would lose the path of a wrong value.
macro_rules! target {
    ($(#[$about:meta])* $name:ident, $map:tt, { $($own:tt)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
        #[cfg_attr(feature = "clap", derive(clap::Args))]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[non_exhaustive]
        pub struct $name {
            /// The file of the character or the skeleton; for a robot, URDF or MuJoCo's MJCF.
            #[cfg_attr(feature = "clap", arg(skip))]
            pub file: PathBuf,
            /// Read the bones of the target from this JSON file, as `mocap skeleton --json` prints it for the target.
            /// Bones that the file omits are searched for
            #[cfg_attr(
                feature = "clap",
                arg(
                    id = $map,
                    long = $map,
                    value_name = "FILE",
                    value_parser = |path: &str| BoneMap::parse_file(path).map(BoneMap::Bones)
                )
            )]
            #[serde(skip_serializing_if = "is_default")]
            pub map: Option<BoneMap>,
            /// Scale of the path over the ground: auto, in proportion to the leg length; none, as in the source; or a
            /// factor
            #[cfg_attr(feature = "clap", arg(long, value_name = "auto|none|FACTOR", default_value = "auto"))]
            #[serde(skip_serializing_if = "is_default")]
            pub scale: Scale,
            /// Feet in ground contact: lock holds a foot still while the source foot is in contact, free does not
            /// correct it. On a character, lock applies only if the foot would slide more than the source foot
            #[cfg_attr(feature = "clap", arg(long, value_name = "lock|free", default_value = "lock"))]
            #[serde(skip_serializing_if = "is_default")]
            pub feet: Feet,
            /// The names of the clips, in the order of the motions. Default: the names in the files.
            #[cfg_attr(feature = "clap", arg(skip))]
            #[serde(skip_serializing_if = "is_default")]
            pub names_of_clips: Vec<String>,
            $($own)*
        }

        impl $name {
            /// The target of a file, with the defaults.
            pub fn new(file: impl Into<PathBuf>) -> Self {
                Self {
                    file: file.into(),
                    ..Self::default()
                }
            }
        }
    };
}

target! {
    /// A character.
    ///
    /// ```
    /// use mocap::job::{CharacterTarget, Feet};
    ///
    /// let hero: CharacterTarget = serde_json::from_str(r#"{"file": "hero.vrm", "feet": "free"}"#).unwrap();
    /// assert_eq!(hero.feet, Feet::Free);
    /// ```
    CharacterTarget, "character-map", {
        /// Hands that touch the body, each other or the floor: keep moves a hand to the place that the source hand
        /// touches, free keeps the directions of the arms
        #[cfg_attr(feature = "clap", arg(long, value_name = "keep|free", default_value = "keep"))]
        #[serde(skip_serializing_if = "is_default")]
        pub hands: Hands,
        /// Drop the animations of the character. By default they are kept
        #[cfg_attr(feature = "clap", arg(long))]
        #[serde(skip_serializing_if = "is_default")]
        pub replace_animations: bool,
        /// Largest allowed angle in degrees; beyond it, the job fails after writing, with the exit code 1. Four angles
        /// count: the angle of a limb in any frame, and the mean angles of a limb's roll, of a line of the trunk and of
        /// a palm
        #[cfg_attr(feature = "clap", arg(long, value_name = "DEGREES"))]
        #[serde(skip_serializing_if = "is_default")]
        pub max_angle: Option<Angle>,
    }
}

target! {
    /// Only the skeleton of a file.
    ///
    /// [`CharacterTarget`] has an example.
    SkeletonTarget, "skeleton-map", {
        /// Hands that touch the body, each other or the floor: keep moves a hand to the place that the source hand
        /// touches, free keeps the directions of the arms
        #[cfg_attr(feature = "clap", arg(long, value_name = "keep|free", default_value = "keep"))]
        #[serde(skip_serializing_if = "is_default")]
        pub hands: Hands,
        /// Largest allowed angle in degrees, as for a character
        #[cfg_attr(feature = "clap", arg(long, value_name = "DEGREES"))]
        #[serde(skip_serializing_if = "is_default")]
        pub max_angle: Option<Angle>,
    }
}

target! {
    /// A robot.
    ///
    /// [`JobTarget`] has an example.
    RobotTarget, "robot-map", {
        /// Number of solver passes: 1 solves frame by frame, which is faster; 2 then solves all frames of a window
        /// together. The second pass moves joints smoothly and without jumps, within the velocity limits of the robot's
        /// file [default: 2]
        #[cfg_attr(
            feature = "clap",
            arg(long, value_name = "1|2", value_parser = parse_passes)
        )]
        #[serde(skip_serializing_if = "is_default")]
        #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 2)))]
        pub passes: Option<u8>,
        /// Keep joints within the velocity limits of the robot's file, also with one pass
        #[cfg_attr(feature = "clap", arg(long))]
        #[serde(skip_serializing_if = "is_default")]
        pub velocity_limits: bool,
        /// Height of the floor: auto, under the feet in contact; z=0, at height 0 of the motion's file; keep, at its
        /// mean height in the motion, without changing heights. auto also lowers a foot that is slightly above the
        /// floor
        #[cfg_attr(
            feature = "clap",
            arg(long, value_name = "FLOOR", default_value = "auto", hide_possible_values = true)
        )]
        #[serde(skip_serializing_if = "is_default")]
        pub floor: Floor,
        /// Playback speed: auto slows a motion down just as far as the robot's limits of velocity and effort need, and
        /// a factor sets the speed. The frame rate does not change
        #[cfg_attr(feature = "clap", arg(long, value_name = "auto|FACTOR", default_value = "1"))]
        #[serde(skip_serializing_if = "is_default")]
        pub time_scale: TimeScale,
        /// Fail after writing, with the exit code 1, if the verdict of a motion is worse than this. feasible refuses
        /// poor motions, and motions that the robot cannot perform with its masses and effort limits
        #[cfg_attr(feature = "clap", arg(long, value_name = "VERDICT"))]
        #[serde(skip_serializing_if = "is_default")]
        pub require: Option<RequiredVerdict>,
    }
}

/// Treatment of feet in contact.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Feet {
    /// A foot is held still while the source foot is in ground contact.
    #[default]
    Lock,
    /// Feet are not corrected.
    Free,
}

/// Treatment of hands in contact.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Hands {
    /// A hand touches the same place on the target as the source hand.
    #[default]
    Keep,
    /// Hands follow from the directions of the arms.
    Free,
}

/// The worst allowed verdict of a motion on a robot.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum RequiredVerdict {
    /// Only good motions.
    Good,
    /// Good and fair motions that the robot can perform with its masses and effort limits.
    Feasible,
    /// Good and fair motions.
    Fair,
}

impl RequiredVerdict {
    /// Why a motion is not good enough.
    fn problem(self, clip: &ClipReport) -> Option<String> {
        let verdict = clip.verdict();
        let is_allowed = match self {
            Self::Good => verdict == Verdict::Good,
            Self::Feasible | Self::Fair => verdict != Verdict::Poor,
        };
        match self {
            _ if !is_allowed => Some(format!("its verdict is {}", verdict.as_str())),
            Self::Feasible => clip.robot()?.why_infeasible(),
            _ => None,
        }
    }
}

/// The skeleton of the file of a character.
impl From<CharacterTarget> for SkeletonTarget {
    fn from(character: CharacterTarget) -> Self {
        Self {
            file: character.file,
            map: character.map,
            scale: character.scale,
            feet: character.feet,
            names_of_clips: character.names_of_clips,
            hands: character.hands,
            max_angle: character.max_angle,
        }
    }
}

/// A field that every kind of target has.
macro_rules! shared {
    ($target:expr, $kind:ident => $field:expr) => {
        match $target {
            JobTarget::Character($kind) => $field,
            JobTarget::Skeleton($kind) => $field,
            JobTarget::Robot($kind) => $field,
        }
    };
}

impl JobTarget {
    /// The file of the target.
    pub fn file(&self) -> &Path {
        shared!(self, kind => &kind.file)
    }

    /// The names of the clips, if they differ from the names in the files.
    pub(super) fn names_of_clips(&self) -> &[String] {
        shared!(self, kind => &kind.names_of_clips)
    }

    /// The files that are read.
    #[doc(hidden)]
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let (file, map) = shared!(self, kind => (&mut kind.file, &mut kind.map));
        let map = match map {
            Some(BoneMap::File(file)) => Some(file),
            _ => None,
        };
        std::iter::once(file).chain(map)
    }

    /// Removes options that only decide whether the job fails: no output depends on them.
    #[doc(hidden)]
    pub fn forget_verdict(&mut self) {
        match self {
            Self::Character(character) => character.max_angle = None,
            Self::Skeleton(skeleton) => skeleton.max_angle = None,
            Self::Robot(robot) => robot.require = None,
        }
    }

    /// The options for retargeting to this target.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for an invalid number of passes, and the errors of [`BoneMap::bones`].
    #[doc(hidden)]
    pub fn options(&self) -> Result<RetargetOptions> {
        let (map, scale, feet) = shared!(self, kind => (&kind.map, kind.scale, kind.feet));
        let bones = map.as_ref().map(BoneMap::bones).transpose()?;
        let options = RetargetOptions::new()
            .scale(scale)
            .lock_feet(feet == Feet::Lock)
            .target_bones(bones.unwrap_or_default());
        Ok(match self {
            Self::Character(character) => options
                .replace_animations(character.replace_animations)
                .keep_hands(character.hands == Hands::Keep),
            Self::Skeleton(skeleton) => options.keep_hands(skeleton.hands == Hands::Keep),
            Self::Robot(robot) => options
                .velocity_limits(robot.velocity_limits)
                .floor(robot.floor)
                .time_scale(robot.time_scale)
                .passes(robot.passes()?),
        })
    }

    /// Describes the motions that are worse than allowed.
    pub(super) fn problem(&self, clips: &[ClipReport]) -> Option<String> {
        let allowed = match self {
            Self::Robot(robot) => return robot.problem(clips),
            Self::Character(character) => character.max_angle?,
            Self::Skeleton(skeleton) => skeleton.max_angle?,
        };
        let clips = clips.iter().filter_map(ClipReport::body);
        let worst = clips.max_by(|a, b| a.worst_degrees().total_cmp(&b.worst_degrees()))?;
        worst.problem(allowed.0)
    }
}

/// Parses the number of solver passes on a command line.
#[cfg(feature = "clap")]
fn parse_passes(text: &str) -> Result<u8, String> {
    match text {
        "1" => Ok(1),
        "2" => Ok(2),
        _ => Err("it must be 1 or 2".to_owned()),
    }
}

impl RobotTarget {
    fn passes(&self) -> Result<u8> {
        match self.passes.unwrap_or(2) {
            passes @ 1..=2 => Ok(passes),
            passes => {
                let message = format!("passes must be 1 or 2, got {passes}");
                Err(Diagnostic::new(Code::InvalidValue, message).into())
            }
        }
    }

    fn problem(&self, clips: &[ClipReport]) -> Option<String> {
        let required = self.require?;
        let mut problems = clips
            .iter()
            .filter_map(|clip| Some((clip.name(), required.problem(clip)?)));
        let (name, why) = problems.next()?;
        let problem = format!("{name}: {{require}} refuses the motion: {why}");
        Some(spelled(&problem).into_owned())
    }
}
