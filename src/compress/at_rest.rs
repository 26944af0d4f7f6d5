//! Whether what stays constant in a motion is as in the rest pose. Where it is, one transform is stored for both; where
//! it is not, both are, so that a figure at rest is the one that was written.

use glam::{Quat, Vec3};

/// The largest rotation between both, in radians: 0.03 degrees.
const ROTATED: f32 = 5e-4;

/// The largest distance between both, as a fraction of the distance from the parent.
const MOVED: f32 = 1e-3;

/// Whether a constant rotation equals the rest pose.
pub fn is_rotation_of_rest(constant: Quat, rest: Quat) -> bool {
    // Of small angles the cosine is too coarse.
    let between = constant * rest.conjugate();
    2.0 * Vec3::new(between.x, between.y, between.z).length() <= ROTATED
}

/// Whether a constant translation equals the rest pose.
pub fn is_translation_of_rest(constant: Vec3, rest: Vec3) -> bool {
    constant.distance(rest) <= MOVED * rest.length()
}
