//! Structure-of-arrays numbers, vectors, quaternions, matrices and transforms. Each lane has the value of one frame.
//!
//! Every operation is a branchless loop over the lanes, which the compiler turns into vector instructions. Everything
//! is `#[inline(always)]`, so that it is compiled for the instruction set of its caller: see [`wide`](super::wide).

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
    /// The number of 32-bit values in a vector of 32 bytes, the width of AVX2.
    pub const LANES: usize = 8;
    pub type Lanes = super::Lanes<f32, LANES>;
    pub type Vectors = super::Vectors<f32, LANES>;
    pub type Quaternions = super::Quaternions<f32, LANES>;
    pub type Transforms = super::Transforms<f32, LANES>;
}

/// Four 64-bit floats, a vector of 32 bytes.
pub mod double {
    /// The number of 64-bit values in a vector of 32 bytes, the width of AVX2.
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

    /// One value per lane. Unlike [`std::array::from_fn`], this function is always inlined.
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

    /// The larger value; NaN if either is NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self::of(|lane| {
            let (a, b) = (self.0[lane], other.0[lane]);
            if b > a || b.is_not_a_number() { b } else { a }
        })
    }

    /// Negates the lanes in which `sign` is below 0.
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
