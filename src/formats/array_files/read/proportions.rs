//! The generic body of `proportions.rs` for arrays, with positions for joints that are not bones.

use glam::Vec3;
use mocap_scene::scene::joint_tables::Joint;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

pub(super) use crate::proportions::HEIGHT;
use crate::proportions::position;

/// The height in metres of the SMPL template's origin above the root, which is the pelvis.
const TEMPLATE_ABOVE_PELVIS: f32 = 0.25;

/// The vector from a bone's joint to a child joint that is not a bone: an end, or a part of the palm.
fn beyond(above: Bone, name: &str) -> Vec3 {
    let side = if above.side() == Some(Side::Right) { -1.0 } else { 1.0 };
    let finger = |across: f32| Vec3::new(0.03, 0.0, across);
    let step = match above.on(Side::Left) {
        Bone::Head => Vec3::new(0.0, 0.15, 0.0),
        Bone::Neck => Vec3::new(0.0, 0.05, 0.005),
        Bone::LeftToes => Vec3::new(0.0, -0.015, 0.06),
        Bone::LeftHand if name.contains("Index") => finger(0.02),
        Bone::LeftHand if name.contains("Ring") => finger(-0.01),
        Bone::LeftHand if name.contains("Pinky") => finger(-0.025),
        Bone::LeftHand if name.contains("End") => Vec3::new(0.17, 0.0, if name.contains("Thumb") { 0.08 } else { 0.0 }),
        Bone::LeftHand if name.ends_with("_hand") => Vec3::new(0.09, 0.0, 0.0),
        Bone::LeftHand => finger(0.0),
        _ => Vec3::new(0.02, 0.0, 0.0),
    };
    step * Vec3::new(side, 1.0, 1.0)
}

/// The positions of `joints` in the T-pose, in metres above the ground.
pub(super) fn rest(joints: &[Joint]) -> Vec<Vec3> {
    let mut joint_positions: Vec<Vec3> = Vec::with_capacity(joints.len());
    let mut above: Vec<Option<Bone>> = Vec::with_capacity(joints.len());
    for joint in joints {
        let parent_bone = joint.parent.and_then(|parent| above[parent]);
        let at = joint.parent.map_or(Vec3::ZERO, |parent| joint_positions[parent]);
        joint_positions.push(match (joint.bone, parent_bone) {
            (Some(bone), _) => position(bone),
            (None, Some(parent_bone)) => at + beyond(parent_bone, &joint.name),
            (None, None) => at,
        });
        above.push(joint.bone.or(parent_bone));
    }
    joint_positions
}

/// The root position of the SMPL template, relative to the template's origin. The root position of a frame is this
/// position plus `trans`.
#[doc(hidden)]
pub const SMPL_ROOT: Vec3 = Vec3::new(0.0, -TEMPLATE_ABOVE_PELVIS, 0.0);
