//! The body that a job puts its motions on.

use std::path::PathBuf;

use mocap_retarget::retargeting::{Report, RetargetingOptions};
use mocap_retarget::robot::Floor;
use mocap_retarget::{Scale, Verdict};
use mocap_scene::error::{Code, Diagnostic, Result};
use serde::{Deserialize, Serialize};

use super::is_default;
use super::source::BoneMap;
use super::text::Angle;

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
    Robot(OntoBody),
}

/// A character, a skeleton or a robot. An option that the other kind of body has is refused.
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
    /// The file of the character or the skeleton; of the robot, URDF or MJCF of MuJoCo.
    pub file: PathBuf,
    /// Which of its joints, or links of the robot, are which bones, where the guess is wrong.
    #[serde(skip_serializing_if = "is_default")]
    pub map: Option<BoneMap>,
    /// Length of the steps: auto, in the proportion of the legs; none, as those of the source; or a factor.
    #[serde(skip_serializing_if = "is_default")]
    pub scale: Scale,
    /// Whether feet are held still while those of the source stand.
    #[serde(skip_serializing_if = "is_default")]
    pub feet: Feet,
    /// The names of the clips, in the order of the motions. Default: the names in the files.
    #[serde(skip_serializing_if = "is_default")]
    pub names_of_clips: Vec<String>,
    /// Of a character: whether the animations that it has are left out; by default they stay.
    #[serde(skip_serializing_if = "is_default")]
    pub replace_animations: bool,
    /// Of a character or a skeleton: the largest allowed angle between a limb of the motion and of the character
    /// in any frame, in degrees; above it the job fails after it has written.
    #[serde(skip_serializing_if = "is_default")]
    pub max_angle: Option<Angle>,
    /// Of a robot: whether joints keep within the velocities too that its file allows.
    #[serde(skip_serializing_if = "is_default")]
    pub velocity_limits: bool,
    /// Of a robot: how often a motion is solved. 1: frame by frame, which is faster. 2, by default: then all frames of
    /// a window together, so that joints move smoothly, within their velocities and without jumps.
    #[serde(skip_serializing_if = "is_default")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1, max = 2)))]
    pub passes: Option<u8>,
    /// Of a robot: where its floor is: auto, under the feet that stand; z=0, at height 0 of the motion's file; keep,
    /// where the motion has it in the mean, with no height changed.
    #[serde(skip_serializing_if = "is_default")]
    pub floor: Floor,
    /// Of a robot: the worst verdict that is allowed; below it the job fails after it has written.
    #[serde(skip_serializing_if = "is_default")]
    pub require: Option<RequiredVerdict>,
}

/// What happens to feet that stand.
///
/// The [module](crate) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Feet {
    /// They are held where the source's feet stand.
    #[default]
    Lock,
    /// They are left as they come.
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
    /// Good and fair ones.
    Fair,
}

impl OntoBody {
    /// The body of a file, with the defaults.
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
    /// The body, of whatever kind.
    pub fn body(&self) -> &OntoBody {
        match self {
            Self::Character(body) | Self::Skeleton(body) | Self::Robot(body) => body,
        }
    }

    /// The body, to be changed.
    pub fn body_mut(&mut self) -> &mut OntoBody {
        match self {
            Self::Character(body) | Self::Skeleton(body) | Self::Robot(body) => body,
        }
    }

    /// The options of a retargeting onto it.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] for an option that is for another kind of body, and as [`BoneMap::bones`].
    pub(super) fn options(&self) -> Result<RetargetingOptions> {
        self.check()?;
        let body = self.body();
        let bones = body.map.as_ref().map(BoneMap::bones).transpose()?;
        Ok(RetargetingOptions::new()
            .scale(body.scale)
            .lock_feet(body.feet == Feet::Lock)
            .target_bones(bones.unwrap_or_default())
            .replace_animations(body.replace_animations)
            .velocity_limits(body.velocity_limits)
            .floor(body.floor)
            .passes(body.passes.unwrap_or(2)))
    }

    fn check(&self) -> Result<()> {
        let body = self.body();
        if let Some(passes) = body.passes.filter(|passes| !(1..=2).contains(passes)) {
            let message = format!("passes must be 1 or 2, got {passes}");
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let (options, kind) = match self {
            Self::Character(_) | Self::Skeleton(_) => (
                vec![
                    ("velocity-limits", body.velocity_limits),
                    ("passes", body.passes.is_some()),
                    ("require", body.require.is_some()),
                    ("floor", body.floor != Floor::Auto),
                ],
                "a robot",
            ),
            Self::Robot(_) => (
                vec![
                    ("replace-animations", body.replace_animations),
                    ("max-angle", body.max_angle.is_some()),
                ],
                "a character",
            ),
        };
        match options.iter().find(|(_, is_stated)| *is_stated) {
            None => Ok(()),
            Some((option, _)) => {
                let message = format!("--{option} would do nothing: it is for {kind}; leave it out");
                Err(Diagnostic::new(Code::InvalidValue, message).into())
            }
        }
    }

    /// What of the motions is worse than is allowed.
    pub(super) fn problem(&self, clips: &[Report]) -> Option<String> {
        let body = self.body();
        match self {
            Self::Robot(_) => {
                let required = body.require?;
                let clip = clips.iter().find(|clip| !required.allows(clip.verdict()))?;
                let (name, verdict) = (clip.name(), clip.verdict().as_str());
                Some(format!("{name}: the motion is {verdict}, which --require refuses"))
            }
            Self::Character(_) | Self::Skeleton(_) => {
                let allowed = body.max_angle?.0;
                let clips = clips.iter().filter_map(Report::body);
                let worst = clips.max_by(|a, b| a.worst_degrees().total_cmp(&b.worst_degrees()))?;
                worst.problem(allowed)
            }
        }
    }
}
