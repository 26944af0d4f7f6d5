//! Numbers, vectors and rotations of some frames at a time.
//!
//! Every operation is a loop over lanes without branches, which the compiler turns into vector instructions.
//! Everything is inlined, because a function of its own would not be compiled for the wider vectors of those who use
//! it.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What there is one of for every frame.
pub(super) trait Real:
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

    fn root(self) -> Self;

    /// Whether it is not a number.
    fn is_none(self) -> bool;
}

macro_rules! reals {
    ($($number:ty),*) => {
        $(impl Real for $number {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;

            #[inline(always)]
            fn root(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn is_none(self) -> bool {
                self.is_nan()
            }
        })*
    };
}
reals!(f32, f64);

/// One number a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes<T, const N: usize>(pub(super) [T; N]);

/// As many as 32 bytes hold: on the processors of these years a vector, and two or three of those of 2003.
pub(super) const SINGLES: usize = 8;
pub(super) const DOUBLES: usize = 4;

impl<T: Real, const N: usize> Lanes<T, N> {
    pub(super) const ZERO: Self = Self([T::ZERO; N]);
    pub(super) const ONE: Self = Self([T::ONE; N]);

    #[inline(always)]
    pub(super) fn all(value: T) -> Self {
        Self([value; N])
    }

    /// Unlike the standard library's `from_fn` it is inlined, and becomes vector instructions.
    #[inline(always)]
    pub(super) fn of(value: impl Fn(usize) -> T) -> Self {
        let mut lanes = Self::ZERO;
        for lane in 0..N {
            lanes.0[lane] = value(lane);
        }
        lanes
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self::of(|lane| self.0[lane].root())
    }

    #[inline(always)]
    pub(super) fn recip(self) -> Self {
        Self::of(|lane| T::ONE / self.0[lane])
    }

    /// The larger of two; what is not a number stays.
    #[inline(always)]
    pub(super) fn max(self, other: Self) -> Self {
        Self::of(|lane| {
            let (a, b) = (self.0[lane], other.0[lane]);
            if b > a || b.is_none() { b } else { a }
        })
    }

    /// Itself, or its opposite where `sign` is below 0.
    #[inline(always)]
    pub(super) fn flipped(self, sign: Self) -> Self {
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
pub(super) struct Vectors<T, const N: usize> {
    pub(super) x: Lanes<T, N>,
    pub(super) y: Lanes<T, N>,
    pub(super) z: Lanes<T, N>,
}

impl<T: Real, const N: usize> Vectors<T, N> {
    pub(super) const ZERO: Self = Self {
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        z: Lanes::ZERO,
    };

    #[inline(always)]
    pub(super) fn all([x, y, z]: [T; 3]) -> Self {
        Self {
            x: Lanes::all(x),
            y: Lanes::all(y),
            z: Lanes::all(z),
        }
    }

    #[inline(always)]
    pub(super) fn of(value: impl Fn(usize) -> [T; 3]) -> Self {
        let mut vectors = Self::ZERO;
        for lane in 0..N {
            let [x, y, z] = value(lane);
            vectors.x.0[lane] = x;
            vectors.y.0[lane] = y;
            vectors.z.0[lane] = z;
        }
        vectors
    }

    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> [T; 3] {
        [self.x, self.y, self.z].map(|axis| axis.0[lane])
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Lanes<T, N> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(super) fn distance_squared(self, other: Self) -> Lanes<T, N> {
        let way = self - other;
        way.dot(way)
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
pub(super) struct Quaternions<T, const N: usize> {
    pub(super) x: Lanes<T, N>,
    pub(super) y: Lanes<T, N>,
    pub(super) z: Lanes<T, N>,
    pub(super) w: Lanes<T, N>,
}

impl<T: Real, const N: usize> Quaternions<T, N> {
    pub(super) const IDENTITY: Self = Self {
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        z: Lanes::ZERO,
        w: Lanes::ONE,
    };

    #[inline(always)]
    pub(super) fn all(value: [T; 4]) -> Self {
        Self::of(|_| value)
    }

    #[inline(always)]
    pub(super) fn of(value: impl Fn(usize) -> [T; 4]) -> Self {
        let mut quaternions = Self::IDENTITY;
        for lane in 0..N {
            let [x, y, z, w] = value(lane);
            quaternions.x.0[lane] = x;
            quaternions.y.0[lane] = y;
            quaternions.z.0[lane] = z;
            quaternions.w.0[lane] = w;
        }
        quaternions
    }

    #[inline(always)]
    pub(super) fn lane(&self, lane: usize) -> [T; 4] {
        self.components().map(|component| component.0[lane])
    }

    #[inline(always)]
    pub(super) fn components(&self) -> [Lanes<T, N>; 4] {
        [self.x, self.y, self.z, self.w]
    }

    #[inline(always)]
    pub(super) fn xyz(self) -> Vectors<T, N> {
        Vectors {
            x: self.x,
            y: self.y,
            z: self.z,
        }
    }

    /// The opposite rotation of one whose length is 1.
    #[inline(always)]
    pub(super) fn conjugate(self) -> Self {
        Self {
            x: -self.x,
            y: -self.y,
            z: -self.z,
            w: self.w,
        }
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Lanes<T, N> {
        (self.x * other.x + self.y * other.y) + (self.z * other.z + self.w * other.w)
    }

    #[inline(always)]
    pub(super) fn length(self) -> Lanes<T, N> {
        self.dot(self).sqrt()
    }

    #[inline(always)]
    pub(super) fn normalize(self) -> Self {
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

    /// The rotation `other`, and then this one.
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

    /// The vector, turned by a rotation whose length is 1: `v + 2 w (u x v) + 2 u x (u x v)`.
    #[inline(always)]
    fn mul(self, vector: Vectors<T, N>) -> Vectors<T, N> {
        let half = self.xyz().cross(vector);
        let way = half + half;
        vector + way * self.w + self.xyz().cross(way)
    }
}

/// Three columns each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Matrices<T, const N: usize>(pub(super) [Vectors<T, N>; 3]);

impl<T: Real, const N: usize> Matrices<T, N> {
    pub(super) const ZERO: Self = Self([Vectors::ZERO; 3]);

    /// Takes on the product of two. In place, for they are large.
    #[inline(always)]
    pub(super) fn set_product(&mut self, left: &Self, right: &Self) {
        for column in 0..3 {
            self.0[column] = left * right.0[column];
        }
    }

    /// What quaternions are as matrices whose lengths are not 1: they stretch. `squares` are those of the lengths, and
    /// `units` have the length 1.
    #[inline(always)]
    pub(super) fn stretching(units: Quaternions<T, N>, squares: Lanes<T, N>) -> Self {
        let Quaternions { x, y, z, w } = units;
        let two = squares + squares;
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
        Self::stretching(units, Lanes::ONE)
    }
}

impl<T: Real, const N: usize> Mul<Vectors<T, N>> for &Matrices<T, N> {
    type Output = Vectors<T, N>;

    #[inline(always)]
    fn mul(self, vector: Vectors<T, N>) -> Vectors<T, N> {
        self.0[0] * vector.x + self.0[1] * vector.y + self.0[2] * vector.z
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat, DVec3};

    use super::*;

    type Rotations = Quaternions<f64, DOUBLES>;

    fn rotations(first: f64) -> [DQuat; DOUBLES] {
        std::array::from_fn(|lane| {
            let angle = first + lane as f64;
            DQuat::from_euler(glam::EulerRot::XYZ, angle, 0.7 * angle, -1.3 * angle)
        })
    }

    #[test]
    fn rotations_are_those_of_glam() {
        let (a, b) = (rotations(0.3), rotations(2.0));
        let [many_a, many_b] = [a, b].map(|all| Rotations::of(|lane| all[lane].to_array()));
        let vector = DVec3::new(1.0, -2.0, 0.5);
        let vectors = Vectors::all(vector.to_array());
        let mut product = Matrices::ZERO;
        product.set_product(&many_a.into(), &many_b.into());
        for lane in 0..DOUBLES {
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
    fn a_longer_quaternion_is_a_matrix_that_stretches() {
        let (length, turn) = (1.2, rotations(1.0));
        let units = Rotations::of(|lane| turn[lane].to_array());
        let found = Matrices::stretching(units, Lanes::all(length * length));
        for (lane, turn) in turn.into_iter().enumerate() {
            let expected = DMat3::from_quat(turn * length);
            for column in 0..3 {
                let found = DVec3::from_array(found.0[column].lane(lane));
                assert!(found.abs_diff_eq(expected.col(column), 1e-14), "{found}");
            }
        }
    }

    #[test]
    fn what_is_not_a_number_stays_the_largest() {
        let a: Lanes<f32, 3> = Lanes([1.0, f32::NAN, 2.0]);
        let b = Lanes([3.0, 1.0, f32::NAN]);
        let found = a.max(b).0;
        assert!(found[0] == 3.0 && found[1].is_nan() && found[2].is_nan(), "{found:?}");
    }
}
