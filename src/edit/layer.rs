//! Takes a part of the body from another motion.

use serde::{Deserialize, Serialize};

use super::body::{Body, and_below};
use super::concat::pair;
use crate::error::Result;
use crate::figure::HumanoidBone;
use crate::pose::Trs;
use crate::scene::{NodeId, Scene};

/// A part of the body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LayerPart {
    /// The spine and all above it.
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

    /// Its name.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Upper => "upper",
            Self::Legs => "legs",
            Self::Arms => "arms",
            Self::Head => "head",
        }
    }

    /// The bones where it begins: of each list the first that is there.
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
}

/// What [`layer()`] did.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LayerReport {
    /// The joints that move as in the other motion now.
    pub joints: usize,
    /// The frames that have it: all, or as many as the other motion has.
    pub frames: usize,
}

/// Gives the joints of `part` the rotations to their parents that they have in an animation of `other`, which has the
/// same joints, at the same time. Where the other motion ends, its last pose stays.
///
/// # Errors
/// As [`concat()`](crate::edit::concat()), and [`Code::NotHumanoid`](crate::Code::NotHumanoid).
pub fn layer(
    scene: &mut Scene,
    animation: usize,
    other: &Scene,
    other_animation: usize,
    part: LayerPart,
) -> Result<LayerReport> {
    let (mut frames, second) = pair(scene, animation, other, other_animation)?;
    let body = Body::new(scene, None)?;
    let top = |bones: &&[HumanoidBone]| bones.iter().find_map(|bone| body.humanoid.joint(*bone));
    let tops = part.tops().iter().filter_map(top);
    let mut nodes: Vec<NodeId> = tops.flat_map(|top| and_below(scene, top).collect::<Vec<_>>()).collect();
    nodes.retain(|node| frames.nodes().contains(node));
    let step = second.rate / frames.rate;
    let last = (second.len() - 1) as f64;
    for frame in 0..frames.len() {
        let row = second.row_at(frame as f64 * step);
        for node in &nodes {
            let column = second.nodes().iter().position(|other| other == node);
            if let (Some(own), Some(column)) = (frames.get(frame, *node), column) {
                let rotation = row[column].rotation;
                frames.set(frame, *node, Trs { rotation, ..own });
            }
        }
    }
    frames.write(scene, animation, &nodes, &[]);
    Ok(LayerReport {
        joints: nodes.len(),
        frames: frames.len().min((last / step) as usize + 1),
    })
}
