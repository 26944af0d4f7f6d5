//! The rotations about X between spaces of which different axes point up.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, Mat4, Vec3, Vec4};

use crate::scene::UpAxis;

/// The rotation about X after which `up` is +Y.
pub const fn turn_to_y_up(up: UpAxis) -> DQuat {
    match up {
        UpAxis::Y => DQuat::IDENTITY,
        UpAxis::Z => DQuat::from_xyzw(-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2),
        UpAxis::NegY => DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        UpAxis::NegZ => DQuat::from_xyzw(FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2),
    }
}

/// A point of a space in which `up` points up, in one with +Y up.
pub fn to_y_up(point: Vec3, up: UpAxis) -> Vec3 {
    let Vec3 { x, y, z } = point;
    // Differences, because the negative of 0 would be -0.
    match up {
        UpAxis::Y => point,
        UpAxis::Z => Vec3::new(x, z, 0.0 - y),
        UpAxis::NegY => Vec3::new(x, 0.0 - y, 0.0 - z),
        UpAxis::NegZ => Vec3::new(x, 0.0 - z, y),
    }
}

/// A point of a space in which `from` points up, in one in which `to` does.
pub fn turned(point: Vec3, from: UpAxis, to: UpAxis) -> Vec3 {
    if from == to {
        return point;
    }
    // Back from +Y: the opposite rotation undoes one of 90 degrees, and one of 180 degrees undoes itself.
    let back = match to {
        UpAxis::Z => UpAxis::NegZ,
        UpAxis::NegZ => UpAxis::Z,
        UpAxis::Y | UpAxis::NegY => to,
    };
    to_y_up(to_y_up(point, from), back)
}

/// The space in which `from` points up to the one in which `to` does.
pub fn from_to(from: UpAxis, to: UpAxis) -> Mat4 {
    let [x, y, z] = Vec3::AXES.map(|axis| turned(axis, from, to).extend(0.0));
    Mat4::from_cols(x, y, z, Vec4::W)
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    #[test]
    fn what_points_up_still_does() {
        let axes = [Vec3::Y, Vec3::Z, Vec3::NEG_Y, Vec3::NEG_Z];
        let point = Vec3::new(1.0, 2.0, 3.0);
        for (from, axis) in std::iter::zip(UpAxis::ALL, axes) {
            assert_eq!(to_y_up(axis, from), Vec3::Y);
            let rotation = Mat4::from_quat(turn_to_y_up(from).as_quat());
            assert!(
                rotation.abs_diff_eq(from_to(from, UpAxis::Y), 1e-6),
                "{from:?}: {rotation}"
            );
            for (to, other) in std::iter::zip(UpAxis::ALL, axes) {
                assert_eq!(turned(axis, from, to), other, "{from:?} to {to:?}");
                assert_eq!(turned(point, from, to), from_to(from, to).transform_vector3(point));
                assert_eq!(from_to(from, to) * from_to(to, from), Mat4::IDENTITY);
                assert_eq!(from_to(from, to).determinant(), 1.0);
            }
        }
        let [y_to_z, z_to_y] = [from_to(UpAxis::Y, UpAxis::Z), from_to(UpAxis::Z, UpAxis::Y)];
        assert_eq!(y_to_z.transform_vector3(Vec3::Y), Vec3::Z);
        assert_eq!(z_to_y.transform_vector3(Vec3::Z), Vec3::Y);
        // X stays, so that left and right are not swapped.
        assert_eq!(z_to_y.transform_vector3(Vec3::X), Vec3::X);
        assert_eq!(
            turn_to_y_up(UpAxis::Z).as_quat(),
            Quat::from_rotation_arc(Vec3::Z, Vec3::Y)
        );
    }
}
