//! Names parts of the body, and finds their joints.

use mocap_figure::{Humanoid, HumanoidBone};
use mocap_scene::scene::{NodeId, Scene};
use serde::{Deserialize, Serialize};

use super::body::and_below;

/// A part of the body.
///
/// [`Layer`](crate::Layer) has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum LayerPart {
    /// The spine and all joints above it, with the arms.
    #[default]
    Upper,
    /// Both legs.
    Legs,
    /// Both arms, from the shoulders.
    Arms,
    /// The neck and the head.
    Head,
}

impl LayerPart {
    /// Every part.
    pub const ALL: [Self; 4] = [Self::Upper, Self::Legs, Self::Arms, Self::Head];

    /// The names of all parts.
    pub(super) const NAMES: &'static [&'static str] = &["upper", "legs", "arms", "head"];

    /// The name of the part.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Upper => "upper",
            Self::Legs => "legs",
            Self::Arms => "arms",
            Self::Head => "head",
        }
    }

    /// The topmost bones of the part. Each list has alternatives: the first bone that the figure has counts.
    const fn tops(self) -> &'static [&'static [HumanoidBone]] {
        use HumanoidBone as Bone;
        match self {
            Self::Upper => &[&[Bone::Spine]],
            Self::Legs => &[&[Bone::LeftUpperLeg], &[Bone::RightUpperLeg]],
            Self::Arms => &[
                &[Bone::LeftShoulder, Bone::LeftUpperArm],
                &[Bone::RightShoulder, Bone::RightUpperArm],
            ],
            Self::Head => &[&[Bone::Neck, Bone::Head]],
        }
    }

    /// The joints of the part: the topmost joints and all joints below them.
    pub(super) fn joints(self, scene: &Scene, humanoid: &Humanoid) -> Vec<NodeId> {
        let top = |bones: &&[HumanoidBone]| bones.iter().find_map(|bone| humanoid.joint(*bone));
        let tops = self.tops().iter().filter_map(top);
        tops.flat_map(|top| and_below(scene, top).collect::<Vec<_>>()).collect()
    }
}
