//! Rotations of matrices, and rotations between directions.

use glam::{Mat3, Mat4, Quat, Vec3, Vec4};

use super::soa::{Quaternions, Vectors};

/// The largest difference from 1 of an axis's squared length that counts as 1.
const UNIT: f32 = 1e-5;

/// The rotation of a matrix whose axes may be scaled. For a mirrored matrix, the rotation of its
/// [`Trs`](crate::pose::Trs). Shear is lost.
pub fn rotation_of(matrix: &Mat4) -> Quat {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec4::truncate);
    // Most axes have length 1 and need no square root.
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

/// The shortest rotation from one direction to another; the identity if one has no length. glam's function also returns
/// the identity for directions within 0.04 degrees.
pub fn arc(from: Vec3, to: Vec3) -> Quat {
    from.try_normalize().map_or(Quat::IDENTITY, |from| {
        let arc = Quaternions::<f32, 1>::arc(Vectors::all(from.to_array()), Vectors::all(to.to_array()));
        Quat::from_array(arc.lane(0))
    })
}
