//! Hands and forearms inside the trunk or the head. Capsules approximate trunk and head.

use glam::Vec3;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::{Findings, confidence};
use crate::survey::motion::{Body, Motion};
use crate::survey::spans;
use crate::survey::thresholds::DefectKind::SelfCollision;

/// The radius of the trunk in leg lengths: 12 cm for a leg of 85 cm. Half the depth of a human trunk is 11 cm to 13 cm.
const TRUNK: f32 = 0.14;

/// The radius of the head in leg lengths: 9 cm for a leg of 85 cm.
const HEAD: f32 = 0.105;
/// The least depth of a span, in metres.
const BEGINS: f32 = 0.02;

pub(super) fn find(motion: &Motion, body: &Body, findings: &mut Findings<'_>) {
    findings.look_for(&[SelfCollision]);
    for side in Side::ALL {
        let hand = Bone::LeftHand.on(side);
        let Some(node) = body.bones.get(&hand) else { continue };
        let depths: Vec<f32> = (0..motion.frames)
            .map(|frame| depth(motion, body, frame, side).unwrap_or(0.0))
            .collect();
        for [from, to] in spans(motion.frames, |frame| frame >= motion.starts && depths[frame] > BEGINS) {
            let deepest = 100.0 * depths[from..=to].iter().copied().fold(0.0, f32::max);
            findings.add(
                SelfCollision,
                [from, to],
                Some(&motion.names[*node]),
                deepest,
                confidence(deepest, 5.0),
            );
        }
    }
}

/// The depth of one side's hand and forearm inside the trunk or the head, in metres.
fn depth(motion: &Motion, body: &Body, frame: usize, side: Side) -> Option<f32> {
    let at = |bone| motion.bone(body, frame, bone);
    let (hand, elbow) = (at(Bone::LeftHand.on(side))?, at(Bone::LeftLowerArm.on(side))?);
    let neck = at(Bone::Neck).or_else(|| at(Bone::Head))?;
    let hips = motion.at(frame, body.hips());
    let depth = |point: Vec3| {
        let trunk = TRUNK * body.leg - distance(point, hips, neck);
        let head = at(Bone::Head).map_or(0.0, |head| HEAD * body.leg - point.distance(head));
        trunk.max(head)
    };
    // Test a point at a quarter of the forearm from the wrist, where clothes add little thickness.
    Some(depth(hand).max(depth(hand.lerp(elbow, 0.25))))
}

/// The distance of a point from a segment.
fn distance(point: Vec3, from: Vec3, to: Vec3) -> f32 {
    let along = to - from;
    let fraction = (point - from).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    point.distance(from + along * fraction.clamp(0.0, 1.0))
}
