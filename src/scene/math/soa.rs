//! Structure-of-arrays numbers, vectors, quaternions, matrices and transforms: one value per lane, and a frame per
//! lane.
//!
//! Every operation is a loop over the lanes without branches, of which the compiler makes vector instructions.
//! Everything is `#[inline(always)]`, so that it is compiled for the instructions of its caller: see
//! [`wide`](super::wide).

use std::ops::{Add, Div, Mul, Neg, Sub};

mod matrix;
mod rotation;
mod vector;

pub use matrix::{Matrices, Transforms};
pub use vector::{Quaternions, Vectors};

/// The scalar of a lane: `f32` or `f64`.
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    const ZERO: Self;
    const ONE: Self;

    fn square_root(self) -> Self;

    fn is_not_a_number(self) -> bool;
}

macro_rules! reals {
    ($($number:ty),*) => {
        $(impl Real for $number {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;

            #[inline(always)]
            fn square_root(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn is_not_a_number(self) -> bool {
                self.is_nan()
            }
        })*
    };
}
reals!(f32, f64);

/// One number per lane.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<T, const N: usize>(pub [T; N]);

/// Eight 32-bit floats, a vector of 32 bytes.
pub mod single {
    pub const LANES: usize = 8;
    pub type Lanes = super::Lanes<f32, LANES>;
    pub type Vectors = super::Vectors<f32, LANES>;
    pub type Quaternions = super::Quaternions<f32, LANES>;
    pub type Transforms = super::Transforms<f32, LANES>;
}

/// Four 64-bit floats, a vector of 32 bytes.
pub mod double {
    pub const LANES: usize = 4;
    pub type Lanes = super::Lanes<f64, LANES>;
    pub type Vectors = super::Vectors<f64, LANES>;
    pub type Quaternions = super::Quaternions<f64, LANES>;
    pub type Matrices = super::Matrices<f64, LANES>;
}

impl<T: Real, const N: usize> Lanes<T, N> {
    pub const ZERO: Self = Self([T::ZERO; N]);
    pub const ONE: Self = Self([T::ONE; N]);

    #[inline(always)]
    pub fn all(value: T) -> Self {
        Self([value; N])
    }

    /// One value per lane. Unlike [`std::array::from_fn`] it is always inlined.
    #[inline(always)]
    pub fn of(value: impl Fn(usize) -> T) -> Self {
        let mut lanes = Self::ZERO;
        for lane in 0..N {
            lanes.0[lane] = value(lane);
        }
        lanes
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self::of(|lane| self.0[lane].square_root())
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        Self::of(|lane| T::ONE / self.0[lane])
    }

    /// The larger of two; NaN if either is NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self::of(|lane| {
            let (a, b) = (self.0[lane], other.0[lane]);
            if b > a || b.is_not_a_number() { b } else { a }
        })
    }

    /// Negated in the lanes where `sign` is below 0.
    #[inline(always)]
    pub fn negated_where_negative(self, sign: Self) -> Self {
        Self::of(|lane| {
            if sign.0[lane] < T::ZERO {
                -self.0[lane]
            } else {
                self.0[lane]
            }
        })
    }
}

impl<T: Real, const N: usize> Add for Lanes<T, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::of(|lane| self.0[lane] + other.0[lane])
    }
}

impl<T: Real, const N: usize> Sub for Lanes<T, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::of(|lane| self.0[lane] - other.0[lane])
    }
}

impl<T: Real, const N: usize> Mul for Lanes<T, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self::of(|lane| self.0[lane] * other.0[lane])
    }
}

impl<T: Real, const N: usize> Neg for Lanes<T, N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self::of(|lane| -self.0[lane])
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat, DVec3};

    use super::*;

    type Rotations = double::Quaternions;

    fn rotations(first: f64) -> [DQuat; double::LANES] {
        std::array::from_fn(|lane| {
            let angle = first + lane as f64;
            DQuat::from_euler(glam::EulerRot::XYZ, angle, 0.7 * angle, -1.3 * angle)
        })
    }

    #[test]
    fn products_equal_those_of_glam() {
        let (a, b) = (rotations(0.3), rotations(2.0));
        let [many_a, many_b] = [a, b].map(|all| Rotations::of(|lane| all[lane].to_array()));
        let vector = DVec3::new(1.0, -2.0, 0.5);
        let vectors = Vectors::all(vector.to_array());
        let mut product = Matrices::ZERO;
        product.set_product(&many_a.into(), &many_b.into());
        for lane in 0..double::LANES {
            let (a, b) = (a[lane], b[lane]);
            let is_near = |found: [f64; 3], expected: DVec3| {
                let found = DVec3::from_array(found);
                assert!(found.abs_diff_eq(expected, 1e-14), "{found}, not {expected}");
            };
            is_near((many_a * vectors).lane(lane), a * vector);
            is_near((many_a.conjugate() * vectors).lane(lane), a.conjugate() * vector);
            is_near((&product * vectors).lane(lane), a * (b * vector));
            let found = DQuat::from_array((many_a * many_b).lane(lane));
            assert!(found.abs_diff_eq(a * b, 1e-15), "{found}");
        }
    }

    #[test]
    fn an_unnormalized_quaternion_is_a_matrix_that_stretches() {
        let (length, units) = (1.2, rotations(1.0));
        let many = Rotations::of(|lane| units[lane].to_array());
        let found = Matrices::from_unnormalized(many, Lanes::all(length * length));
        for (lane, unit) in units.into_iter().enumerate() {
            let expected = DMat3::from_quat(unit * length);
            for column in 0..3 {
                let found = DVec3::from_array(found.0[column].lane(lane));
                assert!(found.abs_diff_eq(expected.col(column), 1e-14), "{found}");
            }
        }
    }

    #[test]
    fn the_larger_of_a_number_and_nan_is_nan() {
        let a: Lanes<f32, 3> = Lanes([1.0, f32::NAN, 2.0]);
        let b = Lanes([3.0, 1.0, f32::NAN]);
        let found = a.max(b).0;
        assert!(found[0] == 3.0 && found[1].is_nan() && found[2].is_nan(), "{found:?}");
    }
}
