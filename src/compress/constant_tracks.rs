//! Constant tracks: replaces tracks that hardly move anything by one value.

use glam::{Quat, Vec3};
use mocap_scene::math::quaternion;

use super::error_bound::Bounds;
use super::error_metric::SHELL_DISTANCE;
use super::raw_clip::RawClip;

/// Makes a track constant if all its values are near their mean: no joint and no point of a shell may move by more than
/// `fraction` of its bound.
pub(super) fn compact(clip: &mut RawClip, bounds: &Bounds, fraction: f32) {
    // The length of each joint's lever arm, up to the next joints that rotate. These joints compensate for the error.
    let mut lever_arms = vec![SHELL_DISTANCE; clip.joints.len()];
    for index in (0..clip.joints.len()).rev() {
        let joint = &clip.joints[index];
        for &child in &joint.children {
            let below = &clip.joints[child];
            if !below.translates() {
                let bone = below.offset().length() * joint.scale;
                let arm = bone + if below.rotates() { 0.0 } else { lever_arms[child] };
                lever_arms[index] = lever_arms[index].max(arm);
            }
        }
        let tolerance = bounds.of_subtree(index) as f32 * fraction;
        let translations = joint.translation.animated_values();
        let mean = (!translations.is_empty())
            .then(|| translations.iter().sum::<Vec3>() / translations.len() as f32)
            .filter(|mean| {
                let is_near = |value: &Vec3| value.distance(*mean) * joint.parent_scale <= tolerance;
                translations.iter().all(is_near)
            });
        let tolerance = bounds.below(index) as f32 * fraction;
        let rotations = joint.rotation.animated_values();
        let mean_rotation = quaternion::mean(rotations).filter(|mean| {
            let angle = |value: &Quat| 2.0 * (mean.conjugate() * *value).xyz().length();
            rotations
                .iter()
                .all(|value| angle(value) * lever_arms[index] <= tolerance)
        });
        let joint = &mut clip.joints[index];
        (joint.constant_translation, joint.constant_rotation) = (mean, mean_rotation);
    }
}
