//! Matrices and transforms in lanes.

use std::ops::Mul;

use super::{Lanes, Quaternions, Real, Vectors};

/// 3x3 matrices, column by column.
#[derive(Clone, Copy, Debug)]
pub struct Matrices<T, const N: usize>(pub [Vectors<T, N>; 3]);

impl<T: Real, const N: usize> Matrices<T, N> {
    pub const ZERO: Self = Self([Vectors::ZERO; 3]);

    /// Sets `self` to `left * right`, without a large copy.
    #[inline(always)]
    pub fn set_product(&mut self, left: &Self, right: &Self) {
        for column in 0..3 {
            self.0[column] = left * right.0[column];
        }
    }

    /// The matrices that the formula for unit quaternions gives for quaternions of any length. These matrices also
    /// scale. The quaternions are `units` times lengths; `squared_lengths` are the squares of the lengths.
    #[inline(always)]
    pub fn from_unnormalized(units: Quaternions<T, N>, squared_lengths: Lanes<T, N>) -> Self {
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
        // Row by row, so that few intermediate values are live at once.
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

/// Affine transforms: the axes and the origin of a node, relative to its parent.
#[derive(Clone, Copy, Debug)]
pub struct Transforms<T, const N: usize> {
    pub axes: Matrices<T, N>,
    pub origin: Vectors<T, N>,
}

impl<T: Real, const N: usize> Transforms<T, N> {
    /// Sets the origin to the origin of `parent * local`.
    #[inline(always)]
    pub fn set_product_of_origins(&mut self, parent: &Self, local: &Self) {
        self.origin = &parent.axes * local.origin + parent.origin;
    }

    /// Sets the axes to the axes of `parent * local`.
    #[inline(always)]
    pub fn set_product_of_axes(&mut self, parent: &Self, local: &Self) {
        self.axes.set_product(&parent.axes, &local.axes);
    }
}
