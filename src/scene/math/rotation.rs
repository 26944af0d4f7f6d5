//! Euler angles to quaternions and back in double precision, for formats that store angles.

pub mod lanes;

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3, EulerRot, Quat};

use crate::scene::RotationOrder;

/// A coordinate axis, as an index into `x y z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];
}

/// The order of glam with the same letters. glam's intrinsic orders are matrix products in the order of their letters,
/// like [`RotationOrder`].
pub fn euler_rot(order: RotationOrder) -> EulerRot {
    match order {
        RotationOrder::Xyz => EulerRot::XYZ,
        RotationOrder::Xzy => EulerRot::XZY,
        RotationOrder::Yxz => EulerRot::YXZ,
        RotationOrder::Yzx => EulerRot::YZX,
        RotationOrder::Zxy => EulerRot::ZXY,
        RotationOrder::Zyx => EulerRot::ZYX,
    }
}

/// The rotation by `degrees` about each axis in turn; each axis is rotated by the rotations before it. As matrices on
/// column vectors it is `R = R1 R2 R3`, in the order of the names in CHANNELS.
///
/// Each factor is a half-angle quaternion `cos(a/2) + sin(a/2) axis`. This function is the definition, for tests;
/// [`lanes`] is the production code.
pub fn from_euler(rotations: impl Iterator<Item = (Axis, f64)>) -> DQuat {
    rotations.fold(DQuat::IDENTITY, |rotation, (axis, degrees)| {
        let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
        let DQuat { x, y, z, w } = rotation;
        match axis {
            Axis::X => DQuat::from_xyzw(
                x * cos + w * sin,
                y * cos + z * sin,
                z * cos - y * sin,
                w * cos - x * sin,
            ),
            Axis::Y => DQuat::from_xyzw(
                x * cos - z * sin,
                y * cos + w * sin,
                z * cos + x * sin,
                w * cos - y * sin,
            ),
            Axis::Z => DQuat::from_xyzw(
                x * cos + y * sin,
                y * cos - x * sin,
                z * cos + w * sin,
                w * cos - z * sin,
            ),
        }
    })
}

/// The sign of a rotation's quaternion that Assimp chooses.
///
/// Assimp makes the quaternion from the rotation matrix. If the trace of the matrix is positive (`|w| > 1/2`), `w` is
/// positive. Otherwise the largest diagonal element decides: of `x`, `y` and `z`, the component with the largest
/// absolute value is positive.
pub fn with_assimp_sign(rotation: DQuat) -> Quat {
    let DQuat { x, y, z, w } = rotation;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let positive = if 3.0 * w * w > xx + yy + zz {
        w
    } else if xx > yy && xx > zz {
        x
    } else if yy > zz {
        y
    } else {
        z
    };
    // Adding zero turns the minus zeros of a rotation about a single axis into zeros.
    let rotation = if positive < 0.0 { -rotation } else { rotation } + DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0);
    rotation.as_quat()
}

/// The angles in degrees about the axes of `order` whose [`from_euler`] is `rotation`. Of all triples of angles for
/// this rotation, the function returns the triple nearest to `before`, so that angles continue past 180 degrees without
/// a jump.
///
/// With `R = Ri(a) Rj(b) Rk(c)` the matrix has `+-sin b` at row `i` of column `k`. `cos b` is a factor of the other
/// elements in that row and column, which give `b` and then `c`. `R` without `c` and `b` gives `a`. The other solution
/// is `(a + 180, 180 - b, c + 180)`. If `b` is 90 degrees (gimbal lock), `a` and `c` rotate about one axis, and only
/// their sum is known. Then `c` keeps its value.
pub fn to_euler(rotation: DQuat, order: RotationOrder, before: [f64; 3]) -> [f64; 3] {
    /// The cosine of `b` below which a single-precision key does not determine `c`.
    const LOCKED: f64 = 1e-6;
    let [i, j, k] = order.axes();
    let parity = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
    let matrix = DMat3::from_quat(rotation);
    let at = |row: usize, column: usize| matrix.col(column)[row];
    let before = before.map(f64::to_radians);

    let cos_b = at(i, i).hypot(at(i, j));
    let b = (parity * at(i, k)).atan2(cos_b);
    let c = if cos_b < LOCKED {
        before[2]
    } else {
        (-parity * at(i, j)).atan2(at(i, i))
    };
    let (sin_c, cos_c) = c.sin_cos();
    // Column j of R Rk(-c), which is column j of Ri(a).
    let without_c = |row| cos_c * at(row, j) + parity * sin_c * at(row, i);
    let a = (parity * without_c(k)).atan2(without_c(j));

    let near = |angles: [f64; 3]| {
        let mut near = angles;
        for (angle, before) in std::iter::zip(&mut near, before) {
            *angle += ((before - *angle) / TAU).round() * TAU;
        }
        near
    };
    let distance = |angles: &[f64; 3]| -> f64 {
        std::iter::zip(angles, before)
            .map(|(angle, before)| (angle - before).abs())
            .sum()
    };
    let (one, other) = (near([a, b, c]), near([a + PI, PI - b, c + PI]));
    let nearest = if distance(&other) < distance(&one) { other } else { one };
    nearest.map(f64::to_degrees)
}

/// The angles of [`to_euler`] about x, y and z.
pub fn to_euler_xyz(rotation: DQuat, order: RotationOrder, before: DVec3) -> DVec3 {
    let axes = order.axes();
    let mut angles = DVec3::ZERO;
    let found = to_euler(rotation, order, axes.map(|axis| before[axis]));
    for (axis, angle) in std::iter::zip(axes, found) {
        angles[axis] = angle;
    }
    angles
}
