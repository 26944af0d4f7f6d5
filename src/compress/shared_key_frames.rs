//! Shared key frames: key frame reduction of the whole pose. A frame loses its keys only if no joint needs them.

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion::nlerp;
use mocap_scene::pose::forward_kinematics;

use super::error_bound::Bounds;
use super::key_frames::{self, KeyFrames};
use super::object_space::ObjectSpaceTrack;
use super::raw_clip::{RawClip, RawTrack};
use super::read_ahead::{self, FrameReader};

/// Removes key frames. In the poses interpolated between the remaining keys, the error of every joint is at most
/// `fraction` times its error bound. `raw` are the joints of the clip in object space.
pub(super) fn reduce(clip: &RawClip, raw: &[ObjectSpaceTrack], bounds: &Bounds, fraction: f32) -> KeyFrames {
    let square = |joint| (bounds.of(joint) as f32 * fraction).powi(2);
    let squared_tolerances: Vec<f32> = (0..clip.joints.len()).map(square).collect();
    let mut pose = vec![(Vec3::ZERO, Quat::IDENTITY); clip.joints.len()];
    let all: Vec<usize> = (0..clip.joints.len()).collect();
    // The joint that last exceeded its tolerance is the most likely to exceed it again. So check this joint and its
    // ancestors first.
    let mut suspects: Vec<usize> = Vec::new();
    let mut ahead = FrameReader::default();
    key_frames::reduce(clip.frames(), |from, to| {
        ahead.reach(to, clip.frames(), |frames| {
            for (joint, raw) in std::iter::zip(&clip.joints, raw) {
                read_ahead::read(joint.rotation.animated_values(), frames.clone(), |value| value.x);
                read_ahead::read(&raw.positions, frames.clone(), |value| value.x);
            }
        });
        let mut between = key_frames::between(&clip.ticks, from, to);
        between.all(|(frame, alpha)| {
            let interpolated = InterpolatedPose {
                clip,
                raw,
                squared_tolerances: &squared_tolerances,
                from,
                to,
                frame,
                alpha,
            };
            let above = |index: usize| index.checked_sub(1);
            if interpolated.first_off(&suspects, above, &mut pose).is_some() {
                return false;
            }
            let parent_of = |index| clip.parent_of(index);
            let Some(off) = interpolated.first_off(&all, parent_of, &mut pose) else {
                return true;
            };
            suspects = std::iter::successors(Some(off), |joint| clip.parent_of(*joint)).collect();
            suspects.reverse();
            false
        })
    })
}

/// The pose of a frame, interpolated between the poses of two other frames.
struct InterpolatedPose<'a> {
    clip: &'a RawClip<'a>,
    raw: &'a [ObjectSpaceTrack],
    /// The squared tolerance of every joint, in square metres.
    squared_tolerances: &'a [f32],
    from: usize,
    to: usize,
    frame: usize,
    alpha: f32,
}

impl InterpolatedPose<'_> {
    /// The first joint of a list that is farther from its position in the raw clip than its tolerance. `parent_of` maps
    /// the index of a joint in this list to the index of its parent.
    fn first_off(
        &self,
        joints: &[usize],
        parent_of: impl Fn(usize) -> Option<usize>,
        pose: &mut [(Vec3, Quat)],
    ) -> Option<usize> {
        let Self {
            clip,
            raw,
            squared_tolerances,
            from,
            to,
            frame,
            alpha,
        } = *self;
        let mut off = None;
        forward_kinematics(
            &mut pose[..joints.len()],
            parent_of,
            |index, parent, (position, rotation)| {
                if off.is_some() {
                    return;
                }
                let index = joints[index];
                let joint = &clip.joints[index];
                let translation = match &joint.translation {
                    RawTrack::Constant(value) => *value,
                    RawTrack::Animated(values) => values[from].lerp(values[to], alpha),
                };
                let local = match &joint.rotation {
                    RawTrack::Constant(value) => *value,
                    RawTrack::Animated(values) => nlerp(values[from], values[to], alpha),
                };
                let offset = translation * joint.parent_scale;
                (*position, *rotation) = match parent {
                    None => (offset, local),
                    Some(parent) => (parent.0 + parent.1 * offset, parent.1 * local),
                };
                let expected = match (raw[index].positions.get(frame), joint.parent) {
                    (Some(expected), _) => *expected,
                    // Static leaves have no stored positions.
                    (None, Some(parent)) => ObjectSpaceTrack::position(Some(&raw[parent]), frame, offset),
                    (None, None) => return,
                };
                let is_within = position.distance_squared(expected) <= squared_tolerances[index];
                off = (!is_within).then_some(index);
            },
        );
        off
    }
}
