//! The body that a job puts its motions on.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::is_default;
use super::source::BoneMap;
use super::text::{Angle, StepLength};
use crate::error::Result;
use crate::figure::HumanoidMap;
use crate::retarget::Verdict;

/// The body that a job puts its motions on.
///
/// ```
/// use mocap::job::Onto;
///
/// let onto: Onto = serde_json::from_str(r#"{"robot": {"file": "g1.urdf", "velocity-limits": true}}"#).unwrap();
/// assert!(matches!(onto, Onto::Robot(robot) if robot.velocity_limits));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Onto {
    /// A character. A glTF or VRM file keeps everything that is in it, and the motions are added.
    Character(OntoBody),
    /// The skeleton of a file alone, without what else is in it.
    Skeleton(OntoBody),
    /// A robot of URDF or MJCF.
    Robot(OntoRobot),
}

/// A character, or a skeleton.
///
/// ```
/// use mocap::job::{Feet, OntoBody};
///
/// let body: OntoBody = serde_json::from_str(r#"{"file": "hero.vrm", "feet": "free"}"#).unwrap();
/// assert_eq!(body.feet, Feet::Free);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OntoBody {
    /// The file of the character or the skeleton.
    pub file: PathBuf,
    /// Which of its joints are which bones, where the guess is wrong.
    #[serde(skip_serializing_if = "is_default")]
    pub map: Option<BoneMap>,
    /// Length of the steps: auto, in the proportion of the legs; none, as those of the source; or a factor.
    #[serde(skip_serializing_if = "is_default")]
    pub scale: StepLength,
    /// Whether feet are held still while those of the source stand.
    #[serde(skip_serializing_if = "is_default")]
    pub feet: Feet,
    /// Whether the animations that the character has are left out; by default they stay.
    #[serde(skip_serializing_if = "is_default")]
    pub replace_animations: bool,
    /// The largest allowed angle between a limb of the motion and that of the character in any frame, in degrees; above
    /// it the job fails after it has written.
    #[serde(skip_serializing_if = "is_default")]
    pub max_angle: Option<Angle>,
}

/// A robot.
///
/// ```
/// use mocap::job::OntoRobot;
///
/// let robot: OntoRobot = serde_json::from_str(r#"{"file": "g1.urdf", "require": "fair"}"#).unwrap();
/// assert!(robot.require.is_some());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct OntoRobot {
    /// The file of the robot: URDF, or MJCF of MuJoCo.
    pub file: PathBuf,
    /// Which of its links are which bones, where the guess is wrong.
    #[serde(skip_serializing_if = "is_default")]
    pub map: Option<BoneMap>,
    /// Length of the steps: auto, in the proportion of the legs; none, as those of the source; or a factor.
    #[serde(skip_serializing_if = "is_default")]
    pub scale: StepLength,
    /// Whether feet stand where those of the source stand.
    #[serde(skip_serializing_if = "is_default")]
    pub feet: Feet,
    /// Whether joints keep within the velocities too that the file of the robot allows.
    #[serde(skip_serializing_if = "is_default")]
    pub velocity_limits: bool,
    /// The worst verdict that is allowed; below it the job fails after it has written.
    #[serde(skip_serializing_if = "is_default")]
    pub require: Option<RequiredVerdict>,
}

/// What happens to feet that stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Feet {
    /// They are held where those of the source stand.
    #[default]
    Lock,
    /// They are left as they come.
    Free,
}

/// The worst verdict that a motion on a robot may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum RequiredVerdict {
    /// Only good ones.
    Good,
    /// Good and fair ones.
    Fair,
}

impl OntoBody {
    /// The character or the skeleton of a file, with the defaults.
    pub fn new(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            ..Self::default()
        }
    }
}

impl OntoRobot {
    /// The robot of a file, with the defaults.
    pub fn new(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            ..Self::default()
        }
    }
}

impl RequiredVerdict {
    /// Whether a verdict is good enough.
    pub fn allows(self, verdict: Verdict) -> bool {
        match self {
            Self::Good => verdict == Verdict::Good,
            Self::Fair => verdict != Verdict::Poor,
        }
    }
}

impl Onto {
    /// The bones of the target that are stated.
    pub(super) fn bones(&self) -> Result<HumanoidMap> {
        let map = match self {
            Self::Character(body) | Self::Skeleton(body) => &body.map,
            Self::Robot(robot) => &robot.map,
        };
        map.as_ref().map_or_else(|| Ok(HumanoidMap::default()), BoneMap::bones)
    }

    /// The file of the target.
    pub fn file(&self) -> &PathBuf {
        match self {
            Self::Character(body) | Self::Skeleton(body) => &body.file,
            Self::Robot(robot) => &robot.file,
        }
    }

    pub(super) fn scale(&self) -> StepLength {
        match self {
            Self::Character(body) | Self::Skeleton(body) => body.scale,
            Self::Robot(robot) => robot.scale,
        }
    }

    pub(super) fn feet(&self) -> Feet {
        match self {
            Self::Character(body) | Self::Skeleton(body) => body.feet,
            Self::Robot(robot) => robot.feet,
        }
    }
}
