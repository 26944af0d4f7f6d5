//! Functions of rotations that glam does not have.

use glam::{Quat, Vec3};

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

/// The rotation vector, axis times angle, of a rotation on its shorter way: its logarithm. Exact for small angles, for
/// which glam's goes through an arc cosine.
#[inline]
pub(crate) fn log(rotation: Quat) -> Vec3 {
    let (v, w) = match rotation.w < 0.0 {
        true => (-rotation.xyz(), -rotation.w),
        false => (rotation.xyz(), rotation.w),
    };
    let square = v.length_squared();
    if square < 0.04 {
        // asin(s) / s by its series: the next term is 5e-8 at an angle of 23 degrees.
        let series =
            1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + square * (15.0 / 336.0 + square * (105.0 / 3456.0))));
        return v * (2.0 * series);
    }
    let sin = square.sqrt();
    v * (2.0 * sin.atan2(w) / sin)
}

/// The rotation of a rotation vector: the inverse of [`log`].
#[inline]
pub(crate) fn exp(vector: Vec3) -> Quat {
    let half = 0.5 * vector.length();
    let sinc = if half < 1e-4 {
        1.0 - half * half / 6.0
    } else {
        half.sin() / half
    };
    let v = vector * (0.5 * sinc);
    Quat::from_xyzw(v.x, v.y, v.z, half.cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rotation_is_the_exponential_of_its_logarithm() {
        for angle in [0.0, 1e-6, 1e-3, 0.1, 0.3999, 0.4001, 1.0, 2.0, 3.0, -3.1] {
            let vector = Vec3::new(0.6, 0.0, -0.8) * angle;
            let rotation = exp(vector);
            assert!(rotation.is_normalized());
            assert!(rotation.abs_diff_eq(Quat::from_axis_angle(Vec3::new(0.6, 0.0, -0.8), angle), 1e-6));
            for rotation in [rotation, -rotation] {
                assert!(log(rotation).abs_diff_eq(vector, 1e-6 * (1.0 + angle.abs())), "{angle}");
            }
        }
    }

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
