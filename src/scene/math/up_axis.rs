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
