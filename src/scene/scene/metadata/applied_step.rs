//! The steps that changed a scene, as they are recorded in it.

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

/// A step that changed positions or times, with the values that are needed to undo it.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "step", rename_all = "snake_case")]
pub enum AppliedStep {
    /// `Importer::retime`: all frames are kept, and play at another rate.
    Retime {
        /// The ticks per second instead of the file's own.
        frames_per_second: f64,
    },
    /// `Importer::clips`: the other animations of the file were dropped.
    SelectClip {
        /// Its index among the file's animations, from 0.
        index: usize,
    },
    /// [`Scene::convert_units`](crate::Scene::convert_units).
    ConvertUnits {
        /// Metres per unit of length before.
        metres_per_unit: f64,
        /// The up axis before.
        up: UpAxis,
        /// Metres per unit of length after; 1 if absent.
        #[serde(default = "one_metre", skip_serializing_if = "is_one_metre")]
        out_metres_per_unit: f64,
        /// The up axis after; Y if absent.
        #[serde(default, skip_serializing_if = "UpAxis::is_y")]
        out_up: UpAxis,
    },
    /// [`Scene::trim`](crate::Scene::trim).
    Trim {
        /// The earlier tick that is now tick 0.
        first: f64,
        /// The earlier tick that is now the last.
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
    /// The frames of all joints were put along the axes of the world at rest, so that the rotations of the rest pose
    /// are zero: `RestPoseSource::TPose`.
    ZeroRestRotations,
    /// `figure::vrm_humanoid`: the bones of the humanoid alone.
    VrmHumanoid {
        /// The rotation about +Y that brought the figure to face +Z at rest, in degrees.
        heading: f64,
        /// How far it was raised, in metres, because its feet stood below the origin.
        lift: f64,
    },
    /// `retarget`: the motion is on the skeleton of another file.
    Retarget {
        /// Where the skeleton comes from, and what was done to it.
        onto: SecondMotion,
        /// How many times as long the steps over the ground are, both in metres.
        scale: f64,
        /// Whether the feet were to be held where the source's are.
        lock_feet: bool,
    },
    /// `figure::name_joints`: joints were given other names.
    NameJoints {
        /// Those whose name is another.
        joints: Vec<JointRename>,
    },
    /// A step of `edit`, which cannot be undone.
    Edit {
        /// The step with all its options.
        edit: StepRecord,
        /// The second motion, of a step that takes one.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        with: Option<SecondMotion>,
        /// Which joint is which bone, where the caller of the step said so: the name of the joint, or none for a bone
        /// that no joint is. Empty where the step found the bones.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        bones: BTreeMap<HumanoidBone, Option<String>>,
    },
}

impl AppliedStep {
    /// Whether it is a step of `edit` that moves something: another rest pose and other frames of joints do not.
    #[doc(hidden)]
    pub fn changes_motion(&self) -> bool {
        let Self::Edit { edit, .. } = self else { return false };
        !matches!(edit.step(), Some("bone-axis" | "rest"))
    }

    /// Whether the frames of joints are others at rest than those of the source.
    #[doc(hidden)]
    pub fn takes_new_axes(&self) -> bool {
        match self {
            Self::ZeroRestRotations => true,
            Self::Edit { edit, .. } => edit.step() == Some("bone-axis"),
            _ => false,
        }
    }
}

/// A step of `edit` as files record it. It is a JSON object with the name of the step in `step` and its options beside
/// it, or a text in files of earlier versions.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(transparent)]
pub struct StepRecord(#[doc(hidden)] pub serde_json::Value);

impl StepRecord {
    /// The name of the step; `None` where the record is a text.
    pub fn step(&self) -> Option<&str> {
        self.0.get("step")?.as_str()
    }
}

/// The JSON.
impl fmt::Display for StepRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A joint that was given another name.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointRename {
    /// Its name before.
    pub from: String,
    /// Its name after.
    pub to: String,
    /// How many nodes of the name before stand before it, in the order of nodes.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub earlier: usize,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// The second motion, or the skeleton, of a step: its origin, and its changes before.
///
/// The [module](crate::scene) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SecondMotion {
    /// The file that it was read from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<Origin>,
    /// How the root's OFFSET was used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub root_offset: Option<RootOffsetUsed>,
    /// The steps that changed it, in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<AppliedStep>,
}

impl SecondMotion {
    /// A motion that is at hand.
    #[doc(hidden)]
    pub fn of(scene: &Scene) -> Self {
        Self {
            source: scene.metadata.origin.clone(),
            root_offset: scene.metadata.root_offset.clone(),
            steps: scene.metadata.steps.clone(),
        }
    }
}
