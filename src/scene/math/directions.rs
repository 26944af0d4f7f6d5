//! Rotations of matrices, and between directions.

use glam::{DQuat, DVec3, Mat3, Mat4, Quat, Vec3, Vec4};

use super::soa::{Quaternions, Vectors};

/// How much the square of the length of an axis may differ from 1 that counts as 1.
const UNIT: f32 = 1e-5;

/// The rotation of a matrix whose axes may be scaled, and of a mirrored one the rotation of its
/// [`Trs`](crate::pose::Trs). Shear is lost.
pub fn rotation_of(matrix: &Mat4) -> Quat {
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

/// The shortest rotation from one direction to another, or the identity if one of them has no length. glam's gives the
/// identity for directions within 0.04 degrees.
pub fn arc(from: Vec3, to: Vec3) -> Quat {
    from.try_normalize().map_or(Quat::IDENTITY, |from| {
        let arc = Quaternions::<f32, 1>::arc(Vectors::all(from.to_array()), Vectors::all(to.to_array()));
        Quat::from_array(arc.lane(0))
    })
}

/// 1 and the cosine of the angle between opposite directions: 1e-12 at 1.4e-6 radians from opposite, where the axis has
/// no digits left.
const OPPOSITE: f64 = 1e-12;

/// The smallest rotation from one direction to another, which need not have unit length; about `axis` where they are
/// opposite. Exact for small angles too, where glam's gives none at all.
pub fn wide_arc(from: DVec3, to: DVec3, axis: DVec3) -> DQuat {
    let length = (from.length_squared() * to.length_squared()).sqrt();
    let (w, v) = (length + from.dot(to), from.cross(to));
    if !w.is_finite() || length <= 0.0 {
        DQuat::IDENTITY
    } else if w <= OPPOSITE * length {
        DQuat::from_xyzw(axis.x, axis.y, axis.z, 0.0).normalize()
    } else {
        DQuat::from_xyzw(v.x, v.y, v.z, w).normalize()
    }
}
