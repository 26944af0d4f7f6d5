//! Defines the directions of bones in a T-pose, and finds the nodes that show these directions.

use std::collections::BTreeMap;

use glam::Vec3;
use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Side};

use crate::hierarchy::Hierarchy;
use crate::knuckles::Knuckles;

/// The direction of a bone in the T-pose, in its coordinate frame; `None` for a bone that keeps its direction.
pub fn direction(bone: Bone) -> Option<Vec3> {
    let outwards = if bone.side() == Some(Side::Right) {
        Vec3::NEG_X
    } else {
        Vec3::X
    };
    match bone.on(Side::Left) {
        Bone::LeftUpperLeg | Bone::LeftLowerLeg => Some(Vec3::NEG_Y),
        Bone::LeftUpperArm | Bone::LeftLowerArm | Bone::LeftHand => Some(outwards),
        Bone::LeftThumbMetacarpal | Bone::LeftThumbProximal | Bone::LeftThumbDistal => {
            Some((outwards + Vec3::Z).normalize())
        }
        finger if finger.is_finger() => Some(outwards),
        _ => None,
    }
}

/// The knuckles towards which a hand points. The first known knuckle is used.
pub(super) const POINTING_KNUCKLES: [Bone; 4] = [
    Bone::LeftMiddleProximal,
    Bone::LeftIndexProximal,
    Bone::LeftRingProximal,
    Bone::LeftLittleProximal,
];

/// The node towards which a bone points: the joint of the next bone, or otherwise the only child of the bone's joint.
pub(crate) fn next(
    hierarchy: &Hierarchy,
    bones: &BTreeMap<Bone, NodeId>,
    knuckles: &Knuckles,
    bone: Bone,
    joint: NodeId,
) -> Option<NodeId> {
    let side = bone.side().unwrap_or(Side::Left);
    let of_hand: &[Bone] = match bone.on(Side::Left) {
        Bone::LeftHand => &POINTING_KNUCKLES,
        _ => &[],
    };
    let of_hand = of_hand.iter().filter_map(|knuckle| knuckles.of(knuckle.on(side)));
    let next = limb_end(bone).or_else(|| next_of_finger(bone));
    let mut named = of_hand.chain(next.and_then(|next| bones.get(&next).copied()));
    named
        .find(|next| hierarchy.is_below(*next, joint))
        .or_else(|| hierarchy.only_child(joint))
}

/// The bone at which a bone of a limb ends.
pub fn limb_end(bone: Bone) -> Option<Bone> {
    let next = match bone.on(Side::Left) {
        Bone::LeftUpperLeg => Bone::LeftLowerLeg,
        Bone::LeftLowerLeg => Bone::LeftFoot,
        Bone::LeftUpperArm => Bone::LeftLowerArm,
        Bone::LeftLowerArm => Bone::LeftHand,
        _ => return None,
    };
    Some(next.on(bone.side()?))
}

/// The next bone of a finger.
fn next_of_finger(bone: Bone) -> Option<Bone> {
    let mut bones = Bone::ALL.iter().copied();
    bones.find(|next| next.is_finger() && bone.is_finger() && next.parent() == Some(bone))
}
