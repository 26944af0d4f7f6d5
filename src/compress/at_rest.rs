//! Compares the constant tracks of a motion with the rest pose. If a track and the rest pose are equal, one transform
//! is stored for both. Otherwise both are stored, so that the rest pose is preserved.

use glam::{Quat, Vec3};

/// The largest angle between a constant rotation and the rotation of the rest pose for which the two count as equal. In
/// radians: 0.03 degrees.
const ROTATED: f32 = 5e-4;

/// The largest distance between a constant translation and the translation of the rest pose for which the two count as
/// equal. It is a fraction of the distance from the parent.
const MOVED: f32 = 1e-3;

/// Whether a constant rotation counts as equal to the rotation of the rest pose.
pub fn is_rotation_of_rest(constant: Quat, rest: Quat) -> bool {
    // The cosine would be too coarse for small angles.
    let between = constant * rest.conjugate();
    2.0 * Vec3::new(between.x, between.y, between.z).length() <= ROTATED
}

/// Whether a constant translation counts as equal to the translation of the rest pose.
pub fn is_translation_of_rest(constant: Vec3, rest: Vec3) -> bool {
    constant.distance(rest) <= MOVED * rest.length()
}
