//! Rotations of lanes: the shortest one between directions, slerp, and the twist about an axis.

use glam::{Quat, Vec3};

use super::{Lanes, Quaternions, Vectors};
use crate::math::quaternion::ANGLE_OVER_SINE;

/// The cosine of the angle between directions from which on their shortest rotation is computed lane by lane.
const OPPOSITE: f32 = -0.9999;

/// The quotient of the sine of an angle and the angle, as a polynomial in the square of the angle: the Taylor series,
/// which up to a right angle is within 5e-10.
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
    /// The shortest rotation from a direction of length 1 to one of any length; the identity where that has none.
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
            // Not so for opposite directions, and for no length and one that is not finite either.
            is_usual &= cos.0[lane] > OPPOSITE * length.0[lane] && length.0[lane] < f32::INFINITY;
        }
        if is_usual {
            arc.normalize()
        } else {
            Self::arc_of_each(from, to)
        }
    }

    /// As [`arc`](Self::arc), lane by lane.
    #[cold]
    fn arc_of_each(from: Vectors<f32, N>, to: Vectors<f32, N>) -> Self {
        Self::of(|lane| {
            let (from, to) = (Vec3::from_array(from.lane(lane)), Vec3::from_array(to.lane(lane)));
            let arc = match (from.try_normalize(), to.try_normalize()) {
                (Some(from), Some(to)) => Quat::from_rotation_arc(from, to),
                _ => Quat::IDENTITY,
            };
            arc.to_array()
        })
    }

    /// A rotation between two, on the shorter arc.
    #[inline(always)]
    pub fn slerp(self, to: Self, fraction: f32) -> Self {
        let dot = self.dot(to);
        let cos = dot.negated_where_negative(dot);
        let from_one = Lanes::ONE - cos;
        // The angle divided by its sine; and the sine's square is (1 - cos) (1 + cos).
        let quotient = polynomial(ANGLE_OVER_SINE, from_one);
        let square = quotient * quotient * (from_one * (Lanes::ONE + cos));
        let weight = |fraction: f32| {
            let sine = polynomial(SINE_OVER_ANGLE, square * Lanes::all(fraction * fraction));
            sine * quotient * Lanes::all(fraction)
        };
        let (before, after) = (weight(1.0 - fraction), weight(fraction).negated_where_negative(dot));
        self * before + to * after
    }

    /// What is left of a rotation after the shortest rotation that brings an axis of length 1 where it brings it. It is
    /// the identity where the axis is reversed.
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

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::math::quaternion::twist;

    type Rotations = Quaternions<f32, 8>;

    fn is_near(found: [f32; 4], expected: Quat) {
        let found = Quat::from_array(found);
        assert!(found.abs_diff_eq(expected, 1e-6), "{found}, not {expected}");
    }

    #[test]
    fn the_shortest_rotations_are_those_of_glam() {
        let from = Vec3::new(0.6, 0.0, -0.8);
        let aside = Vec3::new(0.0, 1.0, 0.0);
        let angles = [0.0, 1e-4, 0.3, FRAC_PI_2, 2.0, 3.0, 3.13, -1.0_f32];
        let to = angles.map(|angle| 7.0 * (from * angle.cos() + aside * angle.sin()));
        let found = Rotations::arc(Vectors::all(from.to_array()), Vectors::of(|lane| to[lane].to_array()));
        for (lane, to) in to.into_iter().enumerate() {
            is_near(found.lane(lane), Quat::from_rotation_arc(from, to.normalize()));
        }
    }

    #[test]
    fn directions_without_a_shortest_rotation_do_no_harm_to_others() {
        let from = Vec3::Y;
        let to = [
            Vec3::ZERO,
            -Vec3::Y,
            Vec3::X,
            Vec3::splat(f32::NAN),
            Vec3::splat(f32::INFINITY),
            -2.0 * Vec3::Y + 1e-6 * Vec3::X,
            Vec3::Y,
            1e-30 * Vec3::Y,
        ];
        let found = Rotations::arc(Vectors::all(from.to_array()), Vectors::of(|lane| to[lane].to_array()));
        for lane in [0, 3, 4, 6, 7] {
            is_near(found.lane(lane), Quat::IDENTITY);
        }
        is_near(found.lane(2), Quat::from_rotation_arc(Vec3::Y, Vec3::X));
        for lane in [1, 5] {
            let turned = Quat::from_array(found.lane(lane)) * from;
            assert!(turned.abs_diff_eq(-Vec3::Y, 1e-5), "{turned}");
        }
    }

    #[test]
    fn between_rotations_lies_what_lies_there_for_glam() {
        let from = Quat::from_euler(glam::EulerRot::XYZ, 0.3, -1.0, 2.0);
        let axis = Vec3::new(0.48, -0.6, 0.64);
        let angles = [0.0, 1e-5, 0.01, 0.5, 1.5, 2.5, PI - 0.01, -2.9_f32];
        for sign in [1.0, -1.0] {
            let to = angles.map(|angle| Quat::from_axis_angle(axis, angle) * from * sign);
            for fraction in [0.0, 0.2, 0.5, 0.75, 1.0] {
                let many = Rotations::all(from.to_array());
                let found = many.slerp(Rotations::of(|lane| to[lane].to_array()), fraction);
                for (lane, to) in to.into_iter().enumerate() {
                    is_near(found.lane(lane), from.slerp(to, fraction));
                }
            }
        }
    }

    #[test]
    fn twists_are_those_of_one_rotation() {
        let axis = Vec3::new(0.6, 0.0, -0.8);
        let angles = [0.0, 0.5, -2.0, 3.0, PI, 1.0, -0.1, 2.2_f32];
        let turned = angles.map(|angle| Quat::from_euler(glam::EulerRot::YXZ, angle, 0.4 * angle, -angle));
        let turned = turned.map(|rotation| {
            if rotation == turned[4] {
                Quat::from_axis_angle(Vec3::Y, PI)
            } else {
                rotation
            }
        });
        let found = Rotations::of(|lane| turned[lane].to_array()).twist(axis.to_array());
        for (lane, turned) in turned.into_iter().enumerate() {
            is_near(found.lane(lane), twist(turned, axis));
        }
    }
}
