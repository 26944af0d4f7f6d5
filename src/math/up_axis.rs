//! The quarter turn about X between a space with +Z up and one with +Y up.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, Mat4, Vec3, Vec4};

use crate::scene::UpAxis;

/// -90 degrees about X, which takes +Z to +Y: (x, y, z) becomes (x, z, -y).
pub(crate) const Z_UP_TO_Y_UP: DQuat = DQuat::from_xyzw(-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);

/// A point of a space in which `up` points up, in one with +Y up.
pub(crate) fn to_y_up(point: Vec3, up: UpAxis) -> Vec3 {
    match up {
        UpAxis::Y => point,
        // A difference, because the negative of 0 would be -0.
        UpAxis::Z => Vec3::new(point.x, point.z, 0.0 - point.y),
    }
}

/// A point of a space in which `from` points up, in one in which `to` does.
pub(crate) fn turned(point: Vec3, from: UpAxis, to: UpAxis) -> Vec3 {
    match (from, to) {
        (UpAxis::Y, UpAxis::Z) => Vec3::new(point.x, 0.0 - point.z, point.y),
        (from, UpAxis::Y) => to_y_up(point, from),
        (UpAxis::Z, UpAxis::Z) => point,
    }
}

/// The space in which `from` points up to the one in which `to` does.
pub(crate) fn from_to(from: UpAxis, to: UpAxis) -> Mat4 {
    let to_y_up = |up| {
        let [x, y, z] = Vec3::AXES.map(|axis| to_y_up(axis, up).extend(0.0));
        Mat4::from_cols(x, y, z, Vec4::W)
    };
    // The inverse of a rotation is its transpose.
    match to {
        UpAxis::Y => to_y_up(from),
        UpAxis::Z if from == UpAxis::Z => Mat4::IDENTITY,
        UpAxis::Z => to_y_up(UpAxis::Z).transpose(),
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;

    #[test]
    fn what_points_up_still_does() {
        for (from, axis) in [(UpAxis::Y, Vec3::Y), (UpAxis::Z, Vec3::Z)] {
            assert_eq!(to_y_up(axis, from), Vec3::Y);
            assert_eq!(from_to(from, from), Mat4::IDENTITY);
        }
        let [y_to_z, z_to_y] = [from_to(UpAxis::Y, UpAxis::Z), from_to(UpAxis::Z, UpAxis::Y)];
        assert_eq!(y_to_z.transform_vector3(Vec3::Y), Vec3::Z);
        assert_eq!(z_to_y.transform_vector3(Vec3::Z), Vec3::Y);
        // X stays, so that left and right are not swapped.
        assert_eq!(z_to_y.transform_vector3(Vec3::X), Vec3::X);
        assert_eq!(z_to_y.determinant(), 1.0);
        assert_eq!(y_to_z * z_to_y, Mat4::IDENTITY);
        let point = Vec3::new(1.0, 2.0, 3.0);
        for (from, to) in [(UpAxis::Y, UpAxis::Z), (UpAxis::Z, UpAxis::Y), (UpAxis::Z, UpAxis::Z)] {
            assert_eq!(turned(point, from, to), from_to(from, to).transform_vector3(point));
        }
        let turned = Mat4::from_quat(Z_UP_TO_Y_UP.as_quat());
        assert!(turned.abs_diff_eq(z_to_y, 1e-6), "{turned}");
        assert_eq!(Z_UP_TO_Y_UP.as_quat(), Quat::from_rotation_arc(Vec3::Z, Vec3::Y));
    }
}
