//! The rest pose: a T-pose in which no joint has a rotation.

use glam::{Quat, Vec3};
use mocap_scene::math::median::median;
use mocap_scene::scene::{HumanoidBone as Bone, Side};

use super::points::Points;

/// The offsets of the joints from their parents in the T-pose.
#[derive(Debug)]
pub(super) struct Rest {
    pub(super) offsets: Vec<Vec3>,
}

/// The direction of a limb bone in the T-pose: arms sideways, legs down.
pub(super) fn limb_direction(bone: Bone) -> Option<Vec3> {
    let direction = match bone.on(Side::Left) {
        Bone::LeftUpperArm | Bone::LeftLowerArm | Bone::LeftHand => Vec3::X,
        Bone::LeftUpperLeg | Bone::LeftLowerLeg => Vec3::NEG_Y,
        _ => return None,
    };
    Some(if bone.side() == Some(Side::Right) && direction == Vec3::X {
        Vec3::NEG_X
    } else {
        direction
    })
}

/// The axis about which the joint at the end of a bone bends in the T-pose: a shin goes back, a forearm forward.
pub(super) fn bend_axis(bone: Bone) -> Option<Vec3> {
    match (bone.on(Side::Left), bone.side()) {
        (Bone::LeftUpperLeg | Bone::LeftLowerLeg, _) => Some(Vec3::X),
        (Bone::LeftUpperArm | Bone::LeftLowerArm, Some(Side::Left)) => Some(Vec3::NEG_Y),
        (Bone::LeftUpperArm | Bone::LeftLowerArm, _) => Some(Vec3::Y),
        _ => None,
    }
}

/// The median vector from a joint to another, in the coordinates of the rotations, with the median length.
pub(super) fn median_offset(points: &Points, from: usize, to: usize, frame_to_world: &[Quat]) -> Vec3 {
    let local = |frame: usize| frame_to_world[frame].inverse() * vector(points, from, to, frame);
    let median = |axis: usize| points.median(|frame| local(frame)[axis]);
    let offset = Vec3::new(median(0), median(1), median(2));
    offset.normalize_or_zero() * length(points, from, to)
}

/// The median distance between two joints.
pub(super) fn length(points: &Points, from: usize, to: usize) -> f32 {
    points.median(|frame| vector(points, from, to, frame).length())
}

pub(super) fn vector(points: &Points, from: usize, to: usize, frame: usize) -> Vec3 {
    points.tracks[to][frame] - points.tracks[from][frame]
}

/// The direction of a foot in the T-pose: forward, and so far down that the toes are on the ground.
pub(super) fn foot_direction(points: &Points, ankle: usize, toes: usize) -> Vec3 {
    /// The height of toes above their lowest position up to which they are on the ground, as a fraction of the foot
    /// length.
    const NEAR: f32 = 0.2;
    let mut heights: Vec<f32> = points.tracks[toes].iter().map(|position| position.y).collect();
    heights.sort_unstable_by(f32::total_cmp);
    let lowest = heights.get(heights.len() / 20).copied().unwrap_or(0.0);
    let length = length(points, ankle, toes).max(f32::MIN_POSITIVE);
    let on_ground = |frame: &usize| points.tracks[toes][*frame].y < lowest + NEAR * length;
    let mut sines: Vec<f32> = (0..points.frames)
        .filter(on_ground)
        .map(|frame| vector(points, ankle, toes, frame).normalize_or_zero().y)
        .collect();
    let sine = median(&mut sines).unwrap_or(0.0).clamp(-0.9, 0.0);
    Vec3::new(0.0, sine, (1.0 - sine * sine).sqrt())
}
