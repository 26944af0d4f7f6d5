//! A generic body for files with rotations but without bone lengths: 1.70 m tall, in a T-pose.
//!
//! Legs and arms are fractions of the height from Drillis and Contini, *Body Segment Parameters* (1966), as in Winter.
//! The fractions are thigh 0.245, shin 0.246, upper arm 0.186, forearm 0.146, ankle 0.039 above the ground. Trunk, head
//! and hands are round numbers. None of these numbers comes from a body model.

use glam::Vec3;

use mocap_scene::scene::{HumanoidBone as Bone, Side};

/// The height of the generic body in metres: an average adult.
pub(crate) const HEIGHT: f32 = 1.70;

/// The height of an ankle in metres (Drillis and Contini, in Winter, Biomechanics and Motor Control of Human Movement).
const ANKLE: f32 = 0.039 * HEIGHT;

/// The height of a knee in metres, from the source of `ANKLE`.
const KNEE: f32 = ANKLE + 0.246 * HEIGHT;

/// The height of a hip in metres, from the source of `ANKLE`.
const HIP: f32 = KNEE + 0.245 * HEIGHT;

/// The distance in metres from the middle of the body to the hip joint.
const HIP_X: f32 = 0.09;

/// The distance in metres from the middle of the body to the shoulder.
const SHOULDER_X: f32 = 0.18;

/// The distance in metres from the middle of the body to the elbow, in a T-pose, from the source of `ANKLE`.
const ELBOW_X: f32 = SHOULDER_X + 0.186 * HEIGHT;

/// The distance in metres from the middle of the body to the wrist, from the source of `ANKLE`.
const WRIST_X: f32 = ELBOW_X + 0.146 * HEIGHT;

/// The height of the shoulder in metres, from the source of `ANKLE`.
const ARM: f32 = 0.818 * HEIGHT;

/// The positions of bones on the left and in the middle, in metres: left is +X, up +Y, forward +Z.
#[rustfmt::skip]
const POSITIONS: &[(Bone, [f32; 3])] = &[
    (Bone::Hips, [0.0, HIP + 0.04, 0.0]),
    (Bone::Spine, [0.0, HIP + 0.13, 0.0]),
    (Bone::Chest, [0.0, HIP + 0.26, 0.0]),
    (Bone::UpperChest, [0.0, HIP + 0.33, 0.0]),
    (Bone::Neck, [0.0, ARM + 0.06, 0.0]),
    (Bone::Head, [0.0, ARM + 0.15, 0.01]),
    (Bone::Jaw, [0.0, ARM + 0.15, 0.03]),
    (Bone::LeftEye, [0.03, ARM + 0.22, 0.09]),
    (Bone::LeftUpperLeg, [HIP_X, HIP, 0.0]),
    (Bone::LeftLowerLeg, [HIP_X, KNEE, 0.0]),
    (Bone::LeftFoot, [HIP_X, ANKLE, 0.0]),
    (Bone::LeftToes, [HIP_X, 0.02, 0.12]),
    (Bone::LeftShoulder, [0.05, ARM, 0.0]),
    (Bone::LeftUpperArm, [SHOULDER_X, ARM, 0.0]),
    (Bone::LeftLowerArm, [ELBOW_X, ARM, 0.0]),
    (Bone::LeftHand, [WRIST_X, ARM, 0.0]),
    (Bone::LeftThumbMetacarpal, [WRIST_X + 0.03, ARM - 0.01, 0.03]),
    (Bone::LeftThumbProximal, [WRIST_X + 0.06, ARM - 0.01, 0.06]),
    (Bone::LeftThumbDistal, [WRIST_X + 0.085, ARM - 0.01, 0.08]),
    (Bone::LeftIndexProximal, [WRIST_X + 0.095, ARM, 0.025]),
    (Bone::LeftIndexIntermediate, [WRIST_X + 0.13, ARM, 0.025]),
    (Bone::LeftIndexDistal, [WRIST_X + 0.155, ARM, 0.025]),
    (Bone::LeftMiddleProximal, [WRIST_X + 0.10, ARM, 0.0]),
    (Bone::LeftMiddleIntermediate, [WRIST_X + 0.14, ARM, 0.0]),
    (Bone::LeftMiddleDistal, [WRIST_X + 0.165, ARM, 0.0]),
    (Bone::LeftRingProximal, [WRIST_X + 0.092, ARM, -0.02]),
    (Bone::LeftRingIntermediate, [WRIST_X + 0.13, ARM, -0.02]),
    (Bone::LeftRingDistal, [WRIST_X + 0.155, ARM, -0.02]),
    (Bone::LeftLittleProximal, [WRIST_X + 0.08, ARM, -0.04]),
    (Bone::LeftLittleIntermediate, [WRIST_X + 0.108, ARM, -0.04]),
    (Bone::LeftLittleDistal, [WRIST_X + 0.128, ARM, -0.04]),
];

/// The position of a bone in the T-pose.
pub(crate) fn position(bone: Bone) -> Vec3 {
    let found = POSITIONS.iter().find(|(own, _)| *own == bone.on(Side::Left));
    let position = Vec3::from(found.map_or([0.0; 3], |(_, position)| *position));
    match bone.side() {
        Some(Side::Right) => position * Vec3::new(-1.0, 1.0, 1.0),
        _ => position,
    }
}
