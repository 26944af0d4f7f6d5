//! Functions of quaternions.

use super::{dot, functions, near, normalized};
use crate::abi::{aiMatrix3x3, aiQuaternion, aiVector3D};

/// The smallest cosine at which the arc between two quaternions counts as straight.
const NEARLY_ONE: f32 = 0.0001;

functions! {
    /// The rotation about x by the third angle, then about y by the first, then about z by the second, in radians.
    make aiQuaternionFromEulerAngles(aiQuaternion, x: f32, y: f32, z: f32) { from_euler_angles(x, y, z) }

    /// The rotation about `axis` by `angle`, in radians.
    make aiQuaternionFromAxisAngle(aiQuaternion, axis: *const aiVector3D, angle: f32) {
        let (sin, cos) = ((angle / 2.0).sin(), (angle / 2.0).cos());
        let [x, y, z] = normalized(axis).map(|component| component * sin);
        [cos, x, y, z]
    }

    /// The unit quaternion with these x, y and z and a w that is not negative.
    make aiQuaternionFromNormalizedQuaternion(aiQuaternion, normalized: *const aiVector3D) {
        let [x, y, z] = normalized;
        let square = 1.0 - x * x - y * y - z * z;
        [if square < 0.0 { 0.0 } else { square.sqrt() }, x, y, z]
    }

    /// 1 if both have the same numbers, else 0.
    tell aiQuaternionAreEqual(a: *const aiQuaternion, b: *const aiQuaternion) -> i32 { i32::from(a == b) }

    /// 1 if no component differs by more than `epsilon`, else 0.
    tell aiQuaternionAreEqualEpsilon(a: *const aiQuaternion, b: *const aiQuaternion, epsilon: f32) -> i32 {
        i32::from(near(&a, &b, epsilon))
    }

    /// Of length 1; unchanged if the length is 0.
    change aiQuaternionNormalize(q: aiQuaternion) { unit(q) }

    /// The conjugate.
    change aiQuaternionConjugate(q: aiQuaternion) { conjugate(q) }

    /// The product with `factor` on the right.
    change aiQuaternionMultiply(q: aiQuaternion, factor: *const aiQuaternion) { multiply(q, factor) }

    /// On the shorter arc from `start` to `end`, `factor` of the way.
    make aiQuaternionInterpolate(aiQuaternion, start: *const aiQuaternion, end: *const aiQuaternion, factor: f32) {
        slerp(start, end, factor)
    }

    /// The rotation of a matrix.
    make aiCreateQuaternionFromMatrix(aiQuaternion, matrix: *const aiMatrix3x3) { quaternion_of(matrix) }
}

fn from_euler_angles(pitch: f32, yaw: f32, roll: f32) -> aiQuaternion {
    let halves = |angle: f32| ((angle * 0.5).sin(), (angle * 0.5).cos());
    let ((sin_pitch, cos_pitch), (sin_yaw, cos_yaw), (sin_roll, cos_roll)) = (halves(pitch), halves(yaw), halves(roll));
    let (cosines, sines) = (cos_pitch * cos_yaw, sin_pitch * sin_yaw);
    [
        cos_roll * cosines + sin_roll * sines,
        sin_roll * cosines - cos_roll * sines,
        cos_roll * sin_pitch * cos_yaw + sin_roll * cos_pitch * sin_yaw,
        cos_roll * cos_pitch * sin_yaw - sin_roll * sin_pitch * cos_yaw,
    ]
}

/// Sums go from x to w, as in Assimp.
fn squares(q: aiQuaternion) -> [f32; 4] {
    let [w, x, y, z] = q;
    [x, y, z, w]
}

pub(super) fn unit(q: aiQuaternion) -> aiQuaternion {
    let length = dot(squares(q), squares(q)).sqrt();
    super::divided(q, length)
}

pub(super) fn conjugate([w, x, y, z]: aiQuaternion) -> aiQuaternion {
    [w, -x, -y, -z]
}

pub(super) fn multiply([w, x, y, z]: aiQuaternion, [d, a, b, c]: aiQuaternion) -> aiQuaternion {
    [
        w * d - x * a - y * b - z * c,
        w * a + x * d + y * c - z * b,
        w * b + y * d + z * a - x * c,
        w * c + z * d + x * b - y * a,
    ]
}

fn slerp(start: aiQuaternion, end: aiQuaternion, factor: f32) -> aiQuaternion {
    let cosine = dot(squares(start), squares(end));
    let (cosine, end) = match cosine < 0.0 {
        true => (-cosine, end.map(|component| -component)),
        false => (cosine, end),
    };
    let (left, right) = if 1.0 - cosine > NEARLY_ONE {
        let angle = cosine.acos();
        let sine = angle.sin();
        (((1.0 - factor) * angle).sin() / sine, (factor * angle).sin() / sine)
    } else {
        (1.0 - factor, factor)
    };
    super::each(start, end, |start, end| left * start + right * end)
}

/// The rotation matrix of a unit quaternion.
pub(super) fn matrix_of([w, x, y, z]: aiQuaternion) -> aiMatrix3x3 {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

/// The rotation as a quaternion, by Shepperd's method. The divisor comes from the trace if that is positive, else from
/// the greatest element of the diagonal. The divisor is positive. This determines which of the two opposite quaternions
/// the result is, and the result for a matrix that shears.
pub(super) fn quaternion_of([[a1, a2, a3], [b1, b2, b3], [c1, c2, c3]]: aiMatrix3x3) -> aiQuaternion {
    let twice_root = |sum: f32| 2.0 * sum.sqrt();
    if a1 + b2 + c3 > 0.0 {
        let s = twice_root(1.0 + (a1 + b2 + c3));
        [0.25 * s, (c2 - b3) / s, (a3 - c1) / s, (b1 - a2) / s]
    } else if a1 > b2 && a1 > c3 {
        let s = twice_root(1.0 + a1 - b2 - c3);
        [(c2 - b3) / s, 0.25 * s, (b1 + a2) / s, (a3 + c1) / s]
    } else if b2 > c3 {
        let s = twice_root(1.0 + b2 - a1 - c3);
        [(a3 - c1) / s, (b1 + a2) / s, 0.25 * s, (c2 + b3) / s]
    } else {
        let s = twice_root(1.0 + c3 - a1 - b2);
        [(b1 - a2) / s, (a3 + c1) / s, (c2 + b3) / s, 0.25 * s]
    }
}
