//! Rotations in lanes: the shortest rotation between directions, slerp, and the twist about an axis.

use glam::Vec3;

use super::{Lanes, Quaternions, Vectors};
use crate::math::quaternion::ANGLE_OVER_SINE;
use crate::math::quaternion::wide_arc;

/// The cosine of the angle between directions below which their shortest rotation is computed lane by lane.
const OPPOSITE: f32 = -0.9999;

/// Coefficients of the quotient of the sine of an angle and the angle, as a polynomial in the squared angle. It is the
/// Taylor series, within 5e-10 up to a right angle.
const SINE_OVER_ANGLE: [f32; 7] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
];

#[inline(always)]
fn polynomial<const TERMS: usize, const N: usize>(coefficients: [f32; TERMS], x: Lanes<f32, N>) -> Lanes<f32, N> {
    let mut sum = Lanes::all(coefficients[TERMS - 1]);
    for power in (0..TERMS - 1).rev() {
        sum = sum * x + Lanes::all(coefficients[power]);
    }
    sum
}

impl<const N: usize> Quaternions<f32, N> {
    /// The shortest rotation from a unit direction to a direction of any length; the identity if the length is 0.
    #[inline(always)]
    pub fn arc(from: Vectors<f32, N>, to: Vectors<f32, N>) -> Self {
        let length = to.dot(to).sqrt();
        let cos = from.dot(to);
        let axis = from.cross(to);
        let arc = Self {
            x: axis.x,
            y: axis.y,
            z: axis.z,
            w: length + cos,
        };
        let mut is_usual = true;
        for lane in 0..N {
            // The usual case excludes opposite directions, and a length that is 0 or not finite.
            is_usual &= cos.0[lane] > OPPOSITE * length.0[lane] && length.0[lane] < f32::INFINITY;
        }
        if is_usual {
            arc.normalize()
        } else {
            Self::arc_of_each(from, to)
        }
    }

    /// Like [`arc`](Self::arc), lane by lane.
    #[cold]
    fn arc_of_each(from: Vectors<f32, N>, to: Vectors<f32, N>) -> Self {
        Self::of(|lane| {
            let [from, to] = [from, to].map(|vectors| Vec3::from_array(vectors.lane(lane)).as_dvec3());
            wide_arc(from, to, from.any_orthonormal_vector()).as_quat().to_array()
        })
    }

    /// Interpolates between two rotations on the shorter arc.
    #[inline(always)]
    pub fn slerp(self, to: Self, fraction: f32) -> Self {
        let dot = self.dot(to);
        let cos = dot.negated_where_negative(dot);
        let from_one = Lanes::ONE - cos;
        // The angle divided by its sine. The squared sine is (1 - cos) (1 + cos).
        let quotient = polynomial(ANGLE_OVER_SINE, from_one);
        let square = quotient * quotient * (from_one * (Lanes::ONE + cos));
        let weight = |fraction: f32| {
            let sine = polynomial(SINE_OVER_ANGLE, square * Lanes::all(fraction * fraction));
            sine * quotient * Lanes::all(fraction)
        };
        let (before, after) = (weight(1.0 - fraction), weight(fraction).negated_where_negative(dot));
        self * before + to * after
    }

    /// The twist of a rotation about a unit axis: the rotation that remains after the shortest rotation that moves the
    /// axis in the same way. The twist is the identity if the axis is reversed.
    #[inline(always)]
    pub fn twist(self, axis: [f32; 3]) -> Self {
        let axis = Vectors::all(axis);
        let along = axis * self.xyz().dot(axis);
        let twist = Self {
            x: along.x,
            y: along.y,
            z: along.z,
            w: self.w,
        };
        let square = twist.dot(twist);
        let mut found = twist.normalize();
        for lane in 0..N {
            let is_round = square.0[lane] <= 1e-9;
            for (component, identity) in [
                (&mut found.x, 0.0),
                (&mut found.y, 0.0),
                (&mut found.z, 0.0),
                (&mut found.w, 1.0),
            ] {
                component.0[lane] = if is_round { identity } else { component.0[lane] };
            }
        }
        found
    }
}
