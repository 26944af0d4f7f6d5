//! Rotations in parts.

use glam::{Mat3, Mat4, Quat, Vec3, Vec4};

/// How much the square of the length of an axis may differ from 1 that counts as 1.
const UNIT: f32 = 1e-5;

/// The rotation of a matrix whose axes may be scaled, and of a mirrored one that of [`Trs`](crate::pose::Trs). Shear is
/// lost.
pub(super) fn rotation_of(matrix: &Mat4) -> Quat {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec4::truncate);
    // Most have length 1, and need no square root.
    let is_unit = axes.iter().all(|axis| (axis.length_squared() - 1.0).abs() < UNIT);
    let [mut x, y, z] = if is_unit {
        axes
    } else {
        axes.map(Vec3::normalize_or_zero)
    };
    if x.cross(y).dot(z) < 0.0 {
        x = -x;
    }
    let rotation = Quat::from_mat3(&Mat3::from_cols(x, y, z));
    if rotation.is_finite() {
        rotation.normalize()
    } else {
        Quat::IDENTITY
    }
}

/// A share of a rotation, on the shorter arc.
pub(super) fn share(rotation: Quat, share: f32) -> Quat {
    between(Quat::IDENTITY, rotation, share)
}

/// A rotation between two, on the shorter arc.
pub(super) fn between(from: Quat, to: Quat, share: f32) -> Quat {
    match share {
        0.0 => from,
        1.0 => to,
        _ => from.slerp(to, share),
    }
}

/// The shortest rotation from one direction to another; none where one has no length.
pub(super) fn arc(from: Vec3, to: Vec3) -> Quat {
    match (from.try_normalize(), to.try_normalize()) {
        (Some(from), Some(to)) => Quat::from_rotation_arc(from, to),
        _ => Quat::IDENTITY,
    }
}
