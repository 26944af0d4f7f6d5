//! Rotation functions that glam lacks.

use glam::{DQuat, DVec3, Quat, Vec3};

/// `rotation` scaled to length 1, without minus zeros; `None` if its length is 0 or not finite. Uses double precision,
/// because the squares of tiny and of huge components underflow or overflow single precision.
pub fn unit(rotation: Quat) -> Option<Quat> {
    let rotation = rotation.as_dquat();
    let length = rotation.length();
    (length.is_finite() && length > 0.0)
        .then(|| Quat::from_array((rotation / length).to_array().map(|c| c as f32 + 0.0)))
}

/// `rotation` or its negative, which is the same rotation: whichever is nearer to `reference`.
pub fn in_hemisphere_of(reference: Quat, rotation: Quat) -> Quat {
    if rotation.dot(reference) < 0.0 {
        -rotation
    } else {
        rotation
    }
}

/// Normalized linear interpolation on the shorter arc. For rotations a few degrees apart, it is within a hundredth of a
/// degree of slerp.
pub fn nlerp(from: Quat, to: Quat, alpha: f32) -> Quat {
    (from + (in_hemisphere_of(from, to) - from) * alpha).normalize()
}

/// The normalized sum of nearby rotations; `None` without rotations.
pub fn mean(rotations: &[Quat]) -> Option<Quat> {
    let first = *rotations.first()?;
    let add = |sum: Quat, rotation: &Quat| sum + in_hemisphere_of(first, *rotation);
    Some(rotations.iter().fold(first * 0.0, add).normalize())
}

/// The rotation vector (axis times angle) of a rotation in double precision, along the shorter arc.
pub fn rotation_vector(rotation: DQuat) -> DVec3 {
    let shorter = if rotation.w < 0.0 { -rotation } else { rotation };
    shorter.to_scaled_axis()
}

/// The rotation vector (axis times angle) of a rotation along the shorter arc: its logarithm. It is exact for small
/// angles, unlike glam's, which uses an arc cosine.
#[inline]
pub fn log(rotation: Quat) -> Vec3 {
    let (v, w) = match rotation.w < 0.0 {
        true => (-rotation.xyz(), -rotation.w),
        false => (rotation.xyz(), rotation.w),
    };
    let square = v.length_squared();
    if square < 0.04 {
        // asin(s) / s as a series. The next term is 5e-8 at an angle of 23 degrees.
        let series =
            1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + square * (15.0 / 336.0 + square * (105.0 / 3456.0))));
        return v * (2.0 * series);
    }
    let sin = square.sqrt();
    v * (2.0 * sin.atan2(w) / sin)
}

/// Coefficients of the quotient of an angle and its sine, as a polynomial in 1 minus the cosine. It interpolates at
/// Chebyshev's nodes of 0 to 1 with degree 9, with an error of at most 2e-8.
pub const ANGLE_OVER_SINE: [f32; 10] = [
    1.0,
    0.333_335_38,
    0.133_266_57,
    0.057_977_802,
    0.020_163_49,
    0.030_059_176,
    -0.033_552_997,
    0.050_975_76,
    -0.032_591_69,
    0.011_162_825,
];

/// [`log`] of the components x, y, z, w without a branch, so that a loop over it becomes vector instructions.
#[inline(always)]
pub fn log_without_branches([x, y, z, w]: [f32; 4]) -> [f32; 3] {
    let quotient = 2.0 * polynomial(ANGLE_OVER_SINE, 1.0 - w.abs());
    let factor = if w < 0.0 { -quotient } else { quotient };
    [x * factor, y * factor, z * factor]
}

/// The square of the angle between two rotations (the squared length of a [`log`]), without a branch. It is a
/// polynomial in the squared chord between the quaternions, at Chebyshev's nodes of 0 to 2, with a relative error
/// within 4e-8.
#[inline(always)]
pub fn squared_angle(a: [f32; 4], b: [f32; 4]) -> f32 {
    /// Coefficients of the quotient of the squared angle and the squared chord, by powers of the squared chord.
    const QUOTIENT: [f32; 9] = [
        4.0,
        0.333_331_8,
        0.044_464_83,
        0.007_040_987,
        0.001_520_764_2,
        -0.000_098_814_1,
        0.000_307_327_4,
        -0.000_098_291_15,
        0.000_022_240_254,
    ];
    let (x, y, z, w) = (a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]);
    let chord = (x * x + y * y) + (z * z + w * w);
    // The negative of the other quaternion is the same rotation. Its squared chord is 4 minus the squared chord here.
    let chord = if chord > 2.0 { 4.0 - chord } else { chord };
    chord * polynomial(QUOTIENT, chord)
}

#[inline(always)]
fn polynomial<const N: usize>(coefficients: [f32; N], x: f32) -> f32 {
    let mut sum = coefficients[N - 1];
    for power in (0..N - 1).rev() {
        sum = sum * x + coefficients[power];
    }
    sum
}

/// The rotation of a rotation vector: the inverse of [`log`].
#[inline]
pub fn exp(vector: Vec3) -> Quat {
    let half = 0.5 * vector.length();
    let sinc = if half < 1e-4 {
        1.0 - half * half / 6.0
    } else {
        half.sin() / half
    };
    let v = vector * (0.5 * sinc);
    Quat::from_xyzw(v.x, v.y, v.z, half.cos())
}

/// The twist of a rotation about a unit axis (swing-twist decomposition). The rotation is the product of the twist and
/// the swing, which is the shortest rotation that moves the axis in the same way.
pub fn twist(rotation: Quat, axis: Vec3) -> Quat {
    let along = axis * rotation.xyz().dot(axis);
    let twist = Quat::from_xyzw(along.x, along.y, along.z, rotation.w);
    // If the rotation reverses the axis, both parts are 0 and the twist is undefined.
    if twist.length_squared() > 1e-9 {
        twist.normalize()
    } else {
        Quat::IDENTITY
    }
}

/// The angle of the [`twist`], from -pi to pi.
pub fn twist_angle(rotation: Quat, axis: Vec3) -> f32 {
    let along = rotation.xyz().dot(axis);
    let angle = 2.0 * along.atan2(rotation.w);
    if angle > std::f32::consts::PI {
        angle - std::f32::consts::TAU
    } else if angle < -std::f32::consts::PI {
        angle + std::f32::consts::TAU
    } else {
        angle
    }
}

/// 1 plus the cosine of the smallest angle at which directions count as opposite: 1e-12 at 1.4e-6 radians from
/// opposite, where the axis has no digits left.
const OPPOSITE: f64 = 1e-12;

/// The smallest rotation from one direction to another, of any length. If the directions are opposite, the rotation is
/// about `axis`. The rotation is exact for small angles, for which glam returns the identity.
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
