//! The rotations about X between spaces with different up axes.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::{DQuat, Mat4, Vec3, Vec4};

use crate::scene::UpAxis;

/// The rotation about X that turns `up` to +Y.
pub const fn turn_to_y_up(up: UpAxis) -> DQuat {
    match up {
        UpAxis::Y => DQuat::IDENTITY,
        UpAxis::Z => DQuat::from_xyzw(-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2),
        UpAxis::NegY => DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        UpAxis::NegZ => DQuat::from_xyzw(FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2),
    }
}

/// Converts a point from a space with the up axis `up` to a space with +Y up.
pub fn to_y_up(point: Vec3, up: UpAxis) -> Vec3 {
    let Vec3 { x, y, z } = point;
    // Subtract from 0, because the negative of 0 would be -0.
    match up {
        UpAxis::Y => point,
        UpAxis::Z => Vec3::new(x, z, 0.0 - y),
        UpAxis::NegY => Vec3::new(x, 0.0 - y, 0.0 - z),
        UpAxis::NegZ => Vec3::new(x, 0.0 - z, y),
    }
}

/// Converts a point from a space with the up axis `from` to a space with the up axis `to`.
pub fn turned(point: Vec3, from: UpAxis, to: UpAxis) -> Vec3 {
    if from == to {
        return point;
    }
    // From +Y to `to`: the inverse of the rotation from `to` to +Y. The inverse of a rotation by 90 degrees is the
    // opposite rotation; a rotation by 180 degrees is its own inverse.
    let back = match to {
        UpAxis::Z => UpAxis::NegZ,
        UpAxis::NegZ => UpAxis::Z,
        UpAxis::Y | UpAxis::NegY => to,
    };
    to_y_up(to_y_up(point, from), back)
}

/// The matrix from a space with the up axis `from` to a space with the up axis `to`.
pub fn from_to(from: UpAxis, to: UpAxis) -> Mat4 {
    let [x, y, z] = Vec3::AXES.map(|axis| turned(axis, from, to).extend(0.0));
    Mat4::from_cols(x, y, z, Vec4::W)
}
