//! The bones of a body, each with its confidence.

use std::collections::BTreeMap;

use mocap_scene::scene::{HumanoidBone, NodeId, Side};

use super::super::Confidence;
use super::HumanoidJoint;
use super::body::{Body, CLEAR_LEAD};
use super::fingers;
use super::limb::Kind;
use super::sides::Found;
use super::topology::Tree;
use crate::names::words::Part;

/// The smallest mean log-odds of lengths that fit: each length deviates by about one standard deviation of its table.
const LENGTHS_FIT: f32 = -0.45;

/// The smallest mean log-odds of lengths that may be the lengths of a body: each length deviates by about 1.6 standard
/// deviations of its table.
pub(super) const LENGTHS_MAY_FIT: f32 = -1.3;

/// The bones of a body.
pub(super) fn bones(tree: &Tree, body: &Body, sides: &Found) -> BTreeMap<HumanoidBone, HumanoidJoint> {
    let mut map = Map {
        tree,
        body,
        sides,
        bones: BTreeMap::new(),
    };
    map.trunk();
    map.limbs();
    map.fingers();
    map.face();
    map.bones
}

/// The map of bones while it is built.
struct Map<'a> {
    tree: &'a Tree,
    body: &'a Body,
    sides: &'a Found,
    bones: BTreeMap<HumanoidBone, HumanoidJoint>,
}

impl Map<'_> {
    /// Adds a bone. `lengths` is the mean score of the lengths around the bone.
    fn enter(&mut self, bone: HumanoidBone, node: Option<usize>, part: Part, lengths: f32) {
        let Some(node) = node else { return };
        let name = &self.tree.names[node];
        let fits = name.fits(part);
        let is_clear = self.body.lead > CLEAR_LEAD;
        let side_is_known = bone.side().is_none() || self.sides.is_named || self.sides.confidence != Confidence::Unsure;
        let (confidence, reason) = if fits >= 0.5 && name.says(part) || fits >= 0.6 {
            match lengths {
                lengths if lengths >= LENGTHS_FIT && is_clear => {
                    (Confidence::Sure, "its name means this bone, and the lengths fit")
                }
                lengths if lengths >= LENGTHS_MAY_FIT => (
                    Confidence::Sure,
                    "its name means this bone, and the lengths are plausible",
                ),
                _ => (
                    Confidence::Likely,
                    "its name means this bone, but the lengths are unusual",
                ),
            }
        } else if fits < -0.3 {
            (
                Confidence::Unsure,
                "its position and length fit, but its name means another part",
            )
        } else if !side_is_known {
            (
                Confidence::Unsure,
                "its position and length fit, but nothing shows left and right",
            )
        } else if lengths >= LENGTHS_FIT && is_clear {
            (
                Confidence::Likely,
                "its position and length fit; its name has no meaning",
            )
        } else {
            (
                Confidence::Unsure,
                "its position fits, but the lengths are unusual, and its name has no meaning",
            )
        };
        self.bones.insert(
            bone,
            HumanoidJoint {
                joint: NodeId::new(node),
                confidence,
                reason: reason.to_owned(),
            },
        );
    }

    fn trunk(&mut self) {
        let trunk = &self.body.trunk;
        let (lengths, legs) = (trunk.lengths, self.body.legs.lengths);
        self.enter(HumanoidBone::Hips, Some(trunk.hips), Part::Hips, legs);
        // If some joints have names of the spine, the other joints between them are helpers.
        let names = &self.tree.names;
        let is_named = trunk.spine.iter().any(|node| names[*node].says(Part::Spine));
        let says_nothing = |node: &usize| is_named && names[*node].meaning.is_empty();
        let is_other = |node: &usize| names[*node].is_helper || names[*node].says(Part::Hips) || says_nothing(node);
        let mut spine: Vec<usize> = trunk.spine.iter().copied().filter(|node| !is_other(node)).collect();
        if spine.is_empty() {
            spine.clone_from(&trunk.spine);
        }
        if let [first, others @ ..] = spine.as_slice() {
            self.enter(HumanoidBone::Spine, Some(*first), Part::Spine, lengths);
            match others {
                [] => {}
                [chest] => self.enter(HumanoidBone::Chest, Some(*chest), Part::Spine, lengths),
                [.., last] => {
                    let middle = spine[(spine.len() - 1) / 2];
                    self.enter(HumanoidBone::Chest, Some(middle), Part::Spine, lengths);
                    self.enter(HumanoidBone::UpperChest, Some(*last), Part::Spine, lengths);
                }
            }
        }
        self.enter(HumanoidBone::Neck, trunk.neck, Part::Neck, lengths);
        self.enter(HumanoidBone::Head, trunk.head, Part::Head, lengths);
    }

    fn limbs(&mut self) {
        use HumanoidBone::{
            LeftFoot, LeftHand, LeftLowerArm, LeftLowerLeg, LeftShoulder, LeftToes, LeftUpperArm, LeftUpperLeg,
        };
        let body = self.body;
        let legs = (
            Some(&body.legs),
            Kind::Leg,
            [LeftUpperLeg, LeftLowerLeg, LeftFoot, LeftToes],
            self.sides.legs,
        );
        let arms = (
            body.arms.as_ref(),
            Kind::Arm,
            [LeftShoulder, LeftUpperArm, LeftLowerArm, LeftHand],
            self.sides.arms,
        );
        for (fit, kind, bones, sides) in [legs, arms] {
            let Some(fit) = fit else { continue };
            for (joints, side) in fit.joints.iter().zip(sides) {
                for ((bone, joint), part) in bones.into_iter().zip(joints).zip(kind.parts()) {
                    self.enter(bone.on(side), *joint, part, fit.lengths);
                }
            }
        }
    }

    fn fingers(&mut self) {
        let Some(arms) = &self.body.arms else { return };
        for (joints, side) in arms.joints.iter().zip(self.sides.arms) {
            let [_, _, Some(lower), Some(hand)] = *joints else {
                continue;
            };
            let forearm = self.tree.between(lower, hand);
            for finger in fingers::find(self.tree, hand, forearm) {
                for (bone, joint) in finger.bones().into_iter().zip(finger.joints) {
                    let Some(joint) = joint else { continue };
                    let (confidence, reason) = if finger.is_named {
                        (
                            Confidence::Likely,
                            "its name means this finger, and its position on the finger fits",
                        )
                    } else {
                        (
                            Confidence::Unsure,
                            "its position on the hand fits; its name means no finger",
                        )
                    };
                    let found = HumanoidJoint {
                        joint: NodeId::new(joint),
                        confidence,
                        reason: reason.to_owned(),
                    };
                    self.bones.insert(bone.on(side), found);
                }
            }
        }
    }

    /// Adds eyes and jaw, by their names.
    fn face(&mut self) {
        let Some(head) = self.body.trunk.head else { return };
        let mut open = vec![head];
        let mut seen = 0;
        while let Some(node) = open.pop() {
            seen += 1;
            if seen > 1024 {
                break;
            }
            open.extend(self.tree.children[node].iter().rev());
            let name = &self.tree.names[node];
            let bone = match name.side {
                _ if !self.tree.is_joint[node] || name.is_helper => None,
                Some(Side::Left) if name.says(Part::Eye) => Some(HumanoidBone::LeftEye),
                Some(Side::Right) if name.says(Part::Eye) => Some(HumanoidBone::RightEye),
                None if name.says(Part::Jaw) => Some(HumanoidBone::Jaw),
                _ => None,
            };
            if let Some(bone) = bone {
                self.bones.entry(bone).or_insert(HumanoidJoint {
                    joint: NodeId::new(node),
                    confidence: Confidence::Sure,
                    reason: "its name means this bone, and it is below the head".to_owned(),
                });
            }
        }
    }
}
