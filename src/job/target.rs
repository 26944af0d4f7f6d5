//! What a job retargets its motions to.

use std::path::{Path, PathBuf};

use mocap_retarget::RetargetOptions;
use mocap_retarget::Scale;
use mocap_retarget::report::ClipReport;
use mocap_retarget::report::Verdict;
use mocap_retarget::robot::report::Floor;
use mocap_scene::error::{Code, Diagnostic, Result, spelled};
use serde::{Deserialize, Serialize};

use super::is_default;
use super::source::BoneMap;
use super::text::Angle;

/// What a job retargets its motions to. Each kind has only its own options.
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
    /// A character. A glTF or VRM file keeps everything that is in it, and the motions are added.
    Character(CharacterTarget),
    /// The skeleton of a file alone, without what else is in it.
    Skeleton(SkeletonTarget),
    /// A robot of URDF or MJCF.
    Robot(RobotTarget),
}

/// A kind of target: the options that all kinds have, and its own. On a command line its map has its own name. A struct
/// of the shared options in each would lose the path of a wrong value (serde's `flatten`).
macro_rules! target {
    ($(#[$about:meta])* $name:ident, $map:tt, { $($own:tt)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
        #[cfg_attr(feature = "clap", derive(clap::Args))]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[non_exhaustive]
        pub struct $name {
            /// The file of the character or the skeleton; of the robot, URDF or MJCF of MuJoCo.
            #[cfg_attr(feature = "clap", arg(skip))]
            pub file: PathBuf,
            /// Take the bones of the target from this JSON file, as `mocap skeleton --json` prints it for the target;
            /// those that it does not name are searched for
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
            /// Length of the steps: auto, in the proportion of the legs; none, as in the source; or a factor
            #[cfg_attr(feature = "clap", arg(long, value_name = "auto|none|FACTOR", default_value = "auto"))]
            #[serde(skip_serializing_if = "is_default")]
            pub scale: Scale,
            /// Feet in ground contact: lock holds a foot still while the source foot is in contact, free does not
            /// correct it. On a character, lock applies only where the foot would slide more than the source foot
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
        /// Hands that touch the body, each other or the floor. keep brings them to the place that the hands of the
        /// source touch, free to the place that the directions of the arms give
        #[cfg_attr(feature = "clap", arg(long, value_name = "keep|free", default_value = "keep"))]
        #[serde(skip_serializing_if = "is_default")]
        pub hands: Hands,
        /// Drop the animations of the character; by default they stay
        #[cfg_attr(feature = "clap", arg(long))]
        #[serde(skip_serializing_if = "is_default")]
        pub replace_animations: bool,
        /// Largest allowed angle in degrees; above it the job fails after it has written, with the exit code 1. It is
        /// the worst of these angles: of a limb in any frame, and in the mean of a roll of a limb, a line of the trunk,
        /// a palm
        #[cfg_attr(feature = "clap", arg(long, value_name = "DEGREES"))]
        #[serde(skip_serializing_if = "is_default")]
        pub max_angle: Option<Angle>,
    }
}

target! {
    /// The skeleton of a file alone.
    ///
    /// [`CharacterTarget`] has an example.
    SkeletonTarget, "skeleton-map", {
        /// Hands that touch the body, each other or the floor. keep brings them to the place that the hands of the
        /// source touch, free to the place that the directions of the arms give
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
        /// How often a motion is solved: 1, frame by frame, which is faster; 2, then all frames of a window together.
        /// The second pass moves joints smoothly, within the velocities of the robot's file and without jumps [default:
        /// 2]
        #[cfg_attr(
            feature = "clap",
            arg(long, value_name = "1|2", value_parser = clap::value_parser!(u8).range(1..=2))
        )]
        #[serde(skip_serializing_if = "is_default")]
        #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 2)))]
        pub passes: Option<u8>,
        /// Keep joints within the velocities of the robot's file with one pass, too
        #[cfg_attr(feature = "clap", arg(long))]
        #[serde(skip_serializing_if = "is_default")]
        pub velocity_limits: bool,
        /// Where the floor is: auto, under the feet in contact; z=0, at height 0 of the motion's file; keep, at its
        /// mean height in the motion, with no height changed. auto also lowers a foot that stands a little too high
        #[cfg_attr(
            feature = "clap",
            arg(long, value_name = "FLOOR", default_value = "auto", hide_possible_values = true)
        )]
        #[serde(skip_serializing_if = "is_default")]
        pub floor: Floor,
        /// Fail after writing, with the exit code 1, if the verdict of a motion is worse than this. feasible refuses
        /// poor motions, and those that the robot cannot perform by its masses and efforts
        #[cfg_attr(feature = "clap", arg(long, value_name = "VERDICT"))]
        #[serde(skip_serializing_if = "is_default")]
        pub require: Option<RequiredVerdict>,
    }
}

/// What happens to feet in contact.
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

/// What happens to hands that touch something.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Hands {
    /// They touch on the target what those of the source touch.
    #[default]
    Keep,
    /// They are where the directions of the arms put them.
    Free,
}

/// The worst verdict that a motion on a robot may have.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum RequiredVerdict {
    /// Only good ones.
    Good,
    /// Good and fair ones that the robot can perform, by its masses and efforts.
    Feasible,
    /// Good and fair ones.
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
            _ if !is_allowed => Some(verdict.as_str().to_owned()),
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

    /// The names of the clips, if they differ from those of the files.
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

    /// Leaves out what decides only whether the job fails: no output depends on it.
    #[doc(hidden)]
    pub fn forget_verdict(&mut self) {
        match self {
            Self::Character(character) => character.max_angle = None,
            Self::Skeleton(skeleton) => skeleton.max_angle = None,
            Self::Robot(robot) => robot.require = None,
        }
    }

    /// The options of a retargeting to it.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for passes that there are not, and as [`BoneMap::bones`].
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
                .passes(robot.passes()?),
        })
    }

    /// What of the motions is worse than is allowed.
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
        let problem = format!("{name}: the motion is {why}, which {{require}} refuses");
        Some(spelled(&problem).into_owned())
    }
}
