//! Finds the nodes at which the fingers of a hand begin. Such a node may be an end site or a fingertip with the name of
//! a finger, which is not a bone.

use std::collections::BTreeMap;

use mocap_scene::scene::{HumanoidBone as Bone, NodeId, Scene, Side};

use super::hierarchy::Hierarchy;
use super::names::Name;
use super::names::words::FingerKind;

/// The first node of each finger, by the proximal bone of the finger.
#[derive(Clone, Debug, Default)]
pub(crate) struct Knuckles(BTreeMap<Bone, NodeId>);

/// The kinds of fingers, each with the bones that may be its first known bone.
const FINGERS: [(&[Bone], FingerKind); 5] = [
    (&[Bone::LeftThumbProximal, Bone::LeftThumbDistal], FingerKind::Thumb),
    (&[Bone::LeftIndexProximal], FingerKind::Index),
    (&[Bone::LeftMiddleProximal], FingerKind::Middle),
    (&[Bone::LeftRingProximal], FingerKind::Ring),
    (&[Bone::LeftLittleProximal], FingerKind::Little),
];

impl Knuckles {
    pub(crate) fn new(scene: &Scene, hierarchy: &Hierarchy, bones: &BTreeMap<Bone, NodeId>) -> Self {
        let mut knuckles = BTreeMap::new();
        for side in [Side::Left, Side::Right] {
            let Some(&hand) = bones.get(&Bone::LeftHand.on(side)) else {
                continue;
            };
            let children: Vec<_> = hierarchy
                .children(hand)
                .map(|child| (Name::read(&scene.nodes[child.index()].name).finger, child))
                .collect();
            for (of_finger, kind) in FINGERS {
                let known = of_finger.iter().find_map(|bone| bones.get(&bone.on(side)));
                let named = || children.iter().find(|(finger, _)| *finger == Some(kind));
                if let Some(node) = known.copied().or_else(|| named().map(|(_, node)| *node)) {
                    knuckles.insert(of_finger[0].on(side), node);
                }
            }
        }
        Self(knuckles)
    }

    /// The first nodes of all fingers, each with the joint of its hand.
    pub(crate) fn with_hands(&self, bones: &BTreeMap<Bone, NodeId>) -> impl Iterator<Item = (NodeId, NodeId)> {
        let with_hand = |(finger, node): (&Bone, &NodeId)| {
            let hand = Bone::LeftHand.on(finger.side()?);
            Some((*node, *bones.get(&hand)?))
        };
        self.0.iter().filter_map(with_hand)
    }

    /// The first node of the finger with this proximal bone.
    pub(crate) fn of(&self, proximal: Bone) -> Option<NodeId> {
        self.0.get(&proximal).copied()
    }
}
