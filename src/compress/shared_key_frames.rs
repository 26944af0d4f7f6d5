//! Shared key frames: key frame reduction of the whole pose. A frame loses its keys only if no joint needs it.

use glam::{Quat, Vec3};

use super::key_frames::{self, KeyFrames};
use super::object_space::ObjectSpaceTrack;
use super::raw_clip::RawClip;
use crate::math::quaternion::nlerp;
use crate::pose::forward_kinematics;

/// The key frames that are left if no joint may be off by more than `tolerance` metres where the pose between two keys
/// is interpolated. `raw` are the joints of the clip in object space.
pub(super) fn reduce(clip: &RawClip, raw: &[ObjectSpaceTrack], tolerance: f32) -> KeyFrames {
    let mut pose = vec![(Vec3::ZERO, Quat::IDENTITY); clip.joints.len()];
    key_frames::reduce(clip.frames(), |from, to| {
        let mut between = key_frames::between(&clip.ticks, from, to);
        between.all(|(frame, alpha)| is_within(clip, raw, [from, to, frame], alpha, tolerance, &mut pose))
    })
}

/// Whether the pose interpolated between two frames is within `tolerance` of the raw one at the frame between them.
fn is_within(
    clip: &RawClip,
    raw: &[ObjectSpaceTrack],
    [from, to, frame]: [usize; 3],
    alpha: f32,
    tolerance: f32,
    pose: &mut [(Vec3, Quat)],
) -> bool {
    let mut is_within = true;
    forward_kinematics(
        pose,
        |index| clip.parent_of(index),
        |index, parent, (position, rotation)| {
            if !is_within {
                return;
            }
            let joint = &clip.joints[index];
            let translation = if joint.translation.is_animated() {
                joint.translation.at(from).lerp(joint.translation.at(to), alpha)
            } else {
                joint.translation.at(0)
            };
            let local = if joint.rotation.is_animated() {
                nlerp(joint.rotation.at(from), joint.rotation.at(to), alpha)
            } else {
                joint.rotation.at(0)
            };
            let offset = translation * joint.parent_scale;
            (*position, *rotation) = match parent {
                None => (offset, local),
                Some(parent) => (parent.0 + parent.1 * offset, parent.1 * local),
            };
            let expected = match (raw[index].positions.get(frame), joint.parent) {
                (Some(expected), _) => *expected,
                // Static leaves have no positions of their own.
                (None, Some(parent)) => ObjectSpaceTrack::position(Some(&raw[parent]), frame, offset),
                (None, None) => return,
            };
            is_within = position.distance_squared(expected) <= tolerance * tolerance;
        },
    );
    is_within
}
