//! Functions of rotations that glam does not have.

use glam::Quat;

/// `rotation` or its negative, which is the same rotation: the one that is nearer to `reference`.
pub(crate) fn in_hemisphere_of(reference: Quat, rotation: Quat) -> Quat {
    if rotation.dot(reference) < 0.0 {
        -rotation
    } else {
        rotation
    }
}

/// Normalized linear interpolation on the shorter arc. For rotations a few degrees apart it is within a hundredth of a
/// degree of slerp.
pub(crate) fn nlerp(from: Quat, to: Quat, alpha: f32) -> Quat {
    (from + (in_hemisphere_of(from, to) - from) * alpha).normalize()
}

/// The normalized sum of rotations that lie near to one another; `None` for no rotations.
pub(crate) fn mean(rotations: &[Quat]) -> Option<Quat> {
    let first = *rotations.first()?;
    let add = |sum: Quat, rotation: &Quat| sum + in_hemisphere_of(first, *rotation);
    Some(rotations.iter().fold(first * 0.0, add).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sign_of_a_quaternion_changes_neither_blend_nor_mean() {
        let (from, to) = (Quat::from_rotation_x(0.2), Quat::from_rotation_x(0.6));
        let half = Quat::from_rotation_x(0.4);
        assert!(nlerp(from, to, 0.5).abs_diff_eq(half, 1e-6));
        assert!(nlerp(from, -to, 0.5).abs_diff_eq(half, 1e-6));
        assert!(mean(&[from, -to]).unwrap().abs_diff_eq(half, 1e-6));
        assert_eq!(mean(&[]), None);
    }
}
