//! Structure-of-arrays numbers, vectors, quaternions, matrices and transforms: one value per lane, and a frame per lane.
//!
//! Every operation is a loop over the lanes without branches, which the compiler turns into vector instructions.
//! Everything is `#[inline(always)]`, so that it is compiled for the instructions of its caller: see
//! [`wide`](super::wide).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The scalar of a lane: `f32` or `f64`.
pub(crate) trait Real:
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
pub(crate) struct Lanes<T, const N: usize>(pub(crate) [T; N]);

/// Eight 32-bit floats, a vector of 32 bytes.
pub(crate) mod single {
    pub(crate) const LANES: usize = 8;
    pub(crate) type Lanes = super::Lanes<f32, LANES>;
    pub(crate) type Vectors = super::Vectors<f32, LANES>;
    pub(crate) type Quaternions = super::Quaternions<f32, LANES>;
    pub(crate) type Transforms = super::Transforms<f32, LANES>;
}

/// Four 64-bit floats, a vector of 32 bytes.
pub(crate) mod double {
    pub(crate) const LANES: usize = 4;
    pub(crate) type Lanes = super::Lanes<f64, LANES>;
    pub(crate) type Vectors = super::Vectors<f64, LANES>;
    pub(crate) type Quaternions = super::Quaternions<f64, LANES>;
    pub(crate) type Matrices = super::Matrices<f64, LANES>;
}

impl<T: Real, const N: usize> Lanes<T, N> {
    pub(crate) const ZERO: Self = Self([T::ZERO; N]);
    pub(crate) const ONE: Self = Self([T::ONE; N]);

    #[inline(always)]
    pub(crate) fn all(value: T) -> Self {
        Self([value; N])
    }

    /// One value per lane. Unlike [`std::array::from_fn`] it is always inlined.
    #[inline(always)]
    pub(crate) fn of(value: impl Fn(usize) -> T) -> Self {
        let mut lanes = Self::ZERO;
        for lane in 0..N {
            lanes.0[lane] = value(lane);
        }
        lanes
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self::of(|lane| self.0[lane].square_root())
    }

    #[inline(always)]
    pub(crate) fn recip(self) -> Self {
        Self::of(|lane| T::ONE / self.0[lane])
    }

    /// The larger of two; NaN if either is NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self::of(|lane| {
            let (a, b) = (self.0[lane], other.0[lane]);
            if b > a || b.is_not_a_number() { b } else { a }
        })
    }

    /// Negated in the lanes where `sign` is below 0.
    #[inline(always)]
    pub(crate) fn negated_where_negative(self, sign: Self) -> Self {
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

#[derive(Clone, Copy, Debug)]
pub(crate) struct Vectors<T, const N: usize> {
    pub(crate) x: Lanes<T, N>,
    pub(crate) y: Lanes<T, N>,
    pub(crate) z: Lanes<T, N>,
}

impl<T: Real, const N: usize> Vectors<T, N> {
    pub(crate) const ZERO: Self = Self {
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        z: Lanes::ZERO,
    };

    #[inline(always)]
    pub(crate) fn all([x, y, z]: [T; 3]) -> Self {
        Self {
            x: Lanes::all(x),
            y: Lanes::all(y),
            z: Lanes::all(z),
        }
    }

    #[inline(always)]
    pub(crate) fn of(value: impl Fn(usize) -> [T; 3]) -> Self {
        let mut vectors = Self::ZERO;
        for lane in 0..N {
            vectors.set_lane(lane, value(lane));
        }
        vectors
    }

    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> [T; 3] {
        [self.x.0[lane], self.y.0[lane], self.z.0[lane]]
    }

    #[inline(always)]
    pub(crate) fn set_lane(&mut self, lane: usize, [x, y, z]: [T; 3]) {
        self.x.0[lane] = x;
        self.y.0[lane] = y;
        self.z.0[lane] = z;
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Lanes<T, N> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn distance_squared(self, other: Self) -> Lanes<T, N> {
        let difference = self - other;
        difference.dot(difference)
    }
}

impl<T: Real, const N: usize> Add for Vectors<T, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }
}

impl<T: Real, const N: usize> Sub for Vectors<T, N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<T: Real, const N: usize> Mul<Lanes<T, N>> for Vectors<T, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: Lanes<T, N>) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Quaternions<T, const N: usize> {
    pub(crate) x: Lanes<T, N>,
    pub(crate) y: Lanes<T, N>,
    pub(crate) z: Lanes<T, N>,
    pub(crate) w: Lanes<T, N>,
}

impl<T: Real, const N: usize> Quaternions<T, N> {
    pub(crate) const IDENTITY: Self = Self {
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        z: Lanes::ZERO,
        w: Lanes::ONE,
    };

    #[inline(always)]
    pub(crate) fn all(value: [T; 4]) -> Self {
        Self::of(|_| value)
    }

    #[inline(always)]
    pub(crate) fn of(value: impl Fn(usize) -> [T; 4]) -> Self {
        let mut quaternions = Self::IDENTITY;
        for lane in 0..N {
            quaternions.set_lane(lane, value(lane));
        }
        quaternions
    }

    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> [T; 4] {
        [self.x.0[lane], self.y.0[lane], self.z.0[lane], self.w.0[lane]]
    }

    #[inline(always)]
    pub(crate) fn set_lane(&mut self, lane: usize, [x, y, z, w]: [T; 4]) {
        self.x.0[lane] = x;
        self.y.0[lane] = y;
        self.z.0[lane] = z;
        self.w.0[lane] = w;
    }

    #[inline(always)]
    pub(crate) fn components(&self) -> [Lanes<T, N>; 4] {
        [self.x, self.y, self.z, self.w]
    }

    #[inline(always)]
    pub(crate) fn xyz(self) -> Vectors<T, N> {
        Vectors {
            x: self.x,
            y: self.y,
            z: self.z,
        }
    }

    /// The inverse rotation, for quaternions of length 1.
    #[inline(always)]
    pub(crate) fn conjugate(self) -> Self {
        Self {
            x: -self.x,
            y: -self.y,
            z: -self.z,
            w: self.w,
        }
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Lanes<T, N> {
        (self.x * other.x + self.y * other.y) + (self.z * other.z + self.w * other.w)
    }

    #[inline(always)]
    pub(crate) fn length(self) -> Lanes<T, N> {
        self.dot(self).sqrt()
    }

    #[inline(always)]
    pub(crate) fn normalize(self) -> Self {
        self * self.length().recip()
    }
}

impl<T: Real, const N: usize> Add for Quaternions<T, N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
            w: self.w + other.w,
        }
    }
}

impl<T: Real, const N: usize> Mul<Lanes<T, N>> for Quaternions<T, N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: Lanes<T, N>) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
            w: self.w * factor,
        }
    }
}

impl<T: Real, const N: usize> Mul for Quaternions<T, N> {
    type Output = Self;

    /// The Hamilton product: rotates by `other` first, then by `self`.
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let Self { x, y, z, w } = self;
        Self {
            x: w * other.x + x * other.w + y * other.z - z * other.y,
            y: w * other.y - x * other.z + y * other.w + z * other.x,
            z: w * other.z + x * other.y - y * other.x + z * other.w,
            w: w * other.w - x * other.x - y * other.y - z * other.z,
        }
    }
}

impl<T: Real, const N: usize> Mul<Vectors<T, N>> for Quaternions<T, N> {
    type Output = Vectors<T, N>;

    /// Rotates a vector, for quaternions of length 1: `v + 2 w (u x v) + 2 u x (u x v)`.
    #[inline(always)]
    fn mul(self, vector: Vectors<T, N>) -> Vectors<T, N> {
        let half = self.xyz().cross(vector);
        let twice = half + half;
        vector + twice * self.w + self.xyz().cross(twice)
    }
}

/// 3x3 matrices, by column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Matrices<T, const N: usize>(pub(crate) [Vectors<T, N>; 3]);

impl<T: Real, const N: usize> Matrices<T, N> {
    pub(crate) const ZERO: Self = Self([Vectors::ZERO; 3]);

    /// Sets `self` to `left * right`. In place, because a copy would be large.
    #[inline(always)]
    pub(crate) fn set_product(&mut self, left: &Self, right: &Self) {
        for column in 0..3 {
            self.0[column] = left * right.0[column];
        }
    }

    /// The matrices that the formula for unit quaternions gives for quaternions of other lengths: they stretch. The
    /// quaternions are `units` times lengths whose squares are `squared_lengths`.
    #[inline(always)]
    pub(crate) fn from_unnormalized(units: Quaternions<T, N>, squared_lengths: Lanes<T, N>) -> Self {
        let Quaternions { x, y, z, w } = units;
        let two = squared_lengths + squared_lengths;
        let (x2, y2, z2) = (x * two, y * two, z * two);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let column = |x, y, z| Vectors { x, y, z };
        Self([
            column(Lanes::ONE - (yy + zz), xy + wz, xz - wy),
            column(xy - wz, Lanes::ONE - (xx + zz), yz + wx),
            column(xz + wy, yz - wx, Lanes::ONE - (xx + yy)),
        ])
    }
}

impl<T: Real, const N: usize> From<Quaternions<T, N>> for Matrices<T, N> {
    #[inline(always)]
    fn from(units: Quaternions<T, N>) -> Self {
        Self::from_unnormalized(units, Lanes::ONE)
    }
}

impl<T: Real, const N: usize> Mul<Vectors<T, N>> for &Matrices<T, N> {
    type Output = Vectors<T, N>;

    #[inline(always)]
    fn mul(self, vector: Vectors<T, N>) -> Vectors<T, N> {
        // Row by row, so that few intermediate values are alive at once.
        let [a, b, c] = &self.0;
        let row = |a: &Lanes<T, N>, b: &Lanes<T, N>, c: &Lanes<T, N>| {
            Lanes::of(|lane| a.0[lane] * vector.x.0[lane] + b.0[lane] * vector.y.0[lane] + c.0[lane] * vector.z.0[lane])
        };
        Vectors {
            x: row(&a.x, &b.x, &c.x),
            y: row(&a.y, &b.y, &c.y),
            z: row(&a.z, &b.z, &c.z),
        }
    }
}

/// Affine transforms: the axes and the origin of a space in that of its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transforms<T, const N: usize> {
    pub(crate) axes: Matrices<T, N>,
    pub(crate) origin: Vectors<T, N>,
}

impl<T: Real, const N: usize> Transforms<T, N> {
    /// Sets the origin to that of `parent * local`.
    #[inline(always)]
    pub(crate) fn set_product_of_origins(&mut self, parent: &Self, local: &Self) {
        self.origin = &parent.axes * local.origin + parent.origin;
    }

    /// Sets the axes to those of `parent * local`.
    #[inline(always)]
    pub(crate) fn set_product_of_axes(&mut self, parent: &Self, local: &Self) {
        self.axes.set_product(&parent.axes, &local.axes);
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
        let (length, turn) = (1.2, rotations(1.0));
        let units = Rotations::of(|lane| turn[lane].to_array());
        let found = Matrices::from_unnormalized(units, Lanes::all(length * length));
        for (lane, turn) in turn.into_iter().enumerate() {
            let expected = DMat3::from_quat(turn * length);
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
