//! The steps that changed a scene, as the scene records them.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Origin, RootOffsetUsed, UpAxis};
use crate::scene::{HumanoidBone, Scene};

fn one_metre() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_one_metre(metres: &f64) -> bool {
    *metres == 1.0
}

/// A step that changed positions or times, with the values to undo it.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "step", rename_all = "snake_case")]
pub enum AppliedStep {
    /// `Importer::retime`: keeps all frames, and plays them at another rate.
    Retime {
        /// The ticks per second that replace the file's own.
        frames_per_second: f64,
    },
    /// `Importer::clips`: drops the other animations of the file.
    SelectClip {
        /// The index of the animation in the file, from 0.
        index: usize,
    },
    /// [`Scene::convert_units`](crate::Scene::convert_units).
    ConvertUnits {
        /// Metres per unit of length before the step.
        metres_per_unit: f64,
        /// The up axis before the step.
        up: UpAxis,
        /// Metres per unit of length after the step; 1 if absent.
        #[serde(default = "one_metre", skip_serializing_if = "is_one_metre")]
        out_metres_per_unit: f64,
        /// The up axis after the step; Y if absent.
        #[serde(default, skip_serializing_if = "UpAxis::is_y")]
        out_up: UpAxis,
    },
    /// [`Scene::trim`](crate::Scene::trim).
    Trim {
        /// The old tick that becomes tick 0.
        first: f64,
        /// The old tick that becomes the last.
        last: f64,
    },
    /// [`Scene::resample`](crate::Scene::resample).
    Resample {
        /// The new ticks per second.
        frames_per_second: f64,
    },
    /// [`Scene::put_in_place`](crate::Scene::put_in_place).
    InPlace,
    /// [`Scene::extract_root_motion`](crate::Scene::extract_root_motion).
    RootMotion,
    /// Aligns the axes of all joints with the world axes in the rest pose, so that the rotations of the rest pose are
    /// zero: `RestPoseSource::TPose`.
    ZeroRestRotations,
    /// `figure::vrm_humanoid`: keeps only the bones of the humanoid.
    VrmHumanoid {
        /// The rotation about +Y, in degrees, that turns the figure to +Z at rest.
        heading: f64,
        /// The lift in metres. The figure was raised because its feet were below the origin.
        lift: f64,
    },
    /// `retarget`: moves the motion to the skeleton of another file.
    Retarget {
        /// The origin of the skeleton, and the steps that changed it.
        onto: SecondMotion,
        /// The ratio of step lengths over the ground, new to old, both in metres.
        scale: f64,
        /// Whether feet were held during the ground contacts of the source.
        lock_feet: bool,
    },
    /// `figure::name_joints`: renames joints.
    NameJoints {
        /// The renamed joints.
        joints: Vec<JointRename>,
    },
    /// A step of `edit`. It cannot be undone.
    Edit {
        /// The step with all its options.
        edit: StepRecord,
        /// The second motion, if the step takes one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        with: Option<SecondMotion>,
        /// The joint name of each bone, if the caller stated the bones. `None` for a bone without a joint. Empty if the
        /// step found the bones.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        bones: BTreeMap<HumanoidBone, Option<String>>,
    },
    /// Steps on one of several animations. The others keep their motion.
    OfClip {
        /// The index of the animation in the scene, from 0.
        index: usize,
        /// The steps, in order.
        steps: Vec<AppliedStep>,
    },
}

impl AppliedStep {
    /// Whether `verify` applies the step to the source: an `edit` step that changes the motion, or steps on one of
    /// several animations. Changes of the rest pose and of joint axes do not count.
    #[doc(hidden)]
    pub fn changes_motion(&self) -> bool {
        match self {
            Self::Edit { edit, .. } => !matches!(edit.step(), Some("bone-axis" | "rest")),
            Self::OfClip { .. } => true,
            _ => false,
        }
    }

    /// Whether the step changes the rest axes of joints.
    #[doc(hidden)]
    pub fn takes_new_axes(&self) -> bool {
        match self {
            Self::ZeroRestRotations => true,
            Self::Edit { edit, .. } => edit.step() == Some("bone-axis"),
            _ => false,
        }
    }
}

/// A step of `edit` as files record it. The record is a JSON object with the step's name in `step`, next to its
/// options. Earlier versions recorded a string.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct StepRecord(#[doc(hidden)] pub serde_json::Value);

impl StepRecord {
    /// The name of the step; `None` if the record is a string.
    pub fn step(&self) -> Option<&str> {
        self.0.get("step")?.as_str()
    }
}

/// Prints the JSON.
impl fmt::Display for StepRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A renamed joint.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointRename {
    /// The old name.
    pub from: String,
    /// The new name.
    pub to: String,
    /// The number of earlier nodes with the old name, in the order of nodes.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub earlier: usize,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// The second motion or the skeleton of a step: its origin, and the steps that changed it before this step.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SecondMotion {
    /// The file from which the second motion was read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<Origin>,
    /// How the root's OFFSET was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub root_offset: Option<RootOffsetUsed>,
    /// The steps that changed the second motion, in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<AppliedStep>,
}

impl SecondMotion {
    /// A record of a motion in memory.
    #[doc(hidden)]
    pub fn of(scene: &Scene) -> Self {
        Self {
            source: scene.metadata.origin.clone(),
            root_offset: scene.metadata.root_offset.clone(),
            steps: scene.metadata.steps.clone(),
        }
    }
}
