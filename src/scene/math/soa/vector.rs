//! Vectors and quaternions in lanes.

use std::ops::{Add, Mul, Sub};

use super::{Lanes, Real};

/// Declares a type with several components, each with its lanes, and the common functions of vectors and quaternions.
macro_rules! components {
    ($name:ident, $count:literal, $($component:ident),+) => {
        #[derive(Clone, Copy, Debug)]
        pub struct $name<T, const N: usize> {
            $(pub $component: Lanes<T, N>,)+
        }

        impl<T: Real, const N: usize> $name<T, N> {
            #[inline(always)]
            pub fn all([$($component),+]: [T; $count]) -> Self {
                Self { $($component: Lanes::all($component),)+ }
            }

            #[inline(always)]
            pub fn of(value: impl Fn(usize) -> [T; $count]) -> Self {
                // Compute all values first. Then the lanes of a component become a vector without interruption.
                let mut values = [[T::ZERO; $count]; N];
                for lane in 0..N {
                    values[lane] = value(lane);
                }
                let mut all = Self { $($component: Lanes::ZERO,)+ };
                for lane in 0..N {
                    all.set_lane(lane, values[lane]);
                }
                all
            }

            #[inline(always)]
            pub fn lane(&self, lane: usize) -> [T; $count] {
                [$(self.$component.0[lane]),+]
            }

            #[inline(always)]
            pub fn set_lane(&mut self, lane: usize, [$($component),+]: [T; $count]) {
                $(self.$component.0[lane] = $component;)+
            }
        }

        impl<const N: usize> $name<f64, N> {
            /// Like [`of`](Self::of), from 32-bit floats.
            #[inline(always)]
            pub fn of_single(value: impl Fn(usize) -> [f32; $count]) -> Self {
                let single = $name::<f32, N>::of(value);
                Self { $($component: Lanes::of(|lane| single.$component.0[lane].into()),)+ }
            }
        }

        impl<T: Real, const N: usize> Add for $name<T, N> {
            type Output = Self;

            #[inline(always)]
            fn add(self, other: Self) -> Self {
                Self { $($component: self.$component + other.$component,)+ }
            }
        }

        impl<T: Real, const N: usize> Mul<Lanes<T, N>> for $name<T, N> {
            type Output = Self;

            #[inline(always)]
            fn mul(self, factor: Lanes<T, N>) -> Self {
                Self { $($component: self.$component * factor,)+ }
            }
        }
    };
}

components!(Vectors, 3, x, y, z);
components!(Quaternions, 4, x, y, z, w);

impl<T: Real, const N: usize> Vectors<T, N> {
    pub const ZERO: Self = Self {
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        z: Lanes::ZERO,
    };

    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Lanes<T, N> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub fn distance_squared(self, other: Self) -> Lanes<T, N> {
        let difference = self - other;
        difference.dot(difference)
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

impl<T: Real, const N: usize> Quaternions<T, N> {
    pub const IDENTITY: Self = Self {
        x: Lanes::ZERO,
        y: Lanes::ZERO,
        z: Lanes::ZERO,
        w: Lanes::ONE,
    };

    #[inline(always)]
    pub fn components(&self) -> [Lanes<T, N>; 4] {
        [self.x, self.y, self.z, self.w]
    }

    #[inline(always)]
    pub fn xyz(self) -> Vectors<T, N> {
        Vectors {
            x: self.x,
            y: self.y,
            z: self.z,
        }
    }

    /// The inverse of rotations, for unit quaternions.
    #[inline(always)]
    pub fn conjugate(self) -> Self {
        Self {
            x: -self.x,
            y: -self.y,
            z: -self.z,
            w: self.w,
        }
    }

    #[inline(always)]
    pub fn dot(self, other: Self) -> Lanes<T, N> {
        (self.x * other.x + self.y * other.y) + (self.z * other.z + self.w * other.w)
    }

    /// The sum, in glam's order of additions.
    #[inline(always)]
    pub fn squared_length(self) -> Lanes<T, N> {
        (self.x * self.x + self.z * self.z) + (self.y * self.y + self.w * self.w)
    }

    #[inline(always)]
    pub fn length(self) -> Lanes<T, N> {
        self.dot(self).sqrt()
    }

    #[inline(always)]
    pub fn normalize(self) -> Self {
        self * self.length().recip()
    }
}

impl<T: Real, const N: usize> Mul for Quaternions<T, N> {
    type Output = Self;

    /// The Hamilton product: applies `other` first, then `self`.
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

    /// Rotates a vector, for unit quaternions: `v + 2 w (u x v) + 2 u x (u x v)`.
    #[inline(always)]
    fn mul(self, vector: Vectors<T, N>) -> Vectors<T, N> {
        let half = self.xyz().cross(vector);
        let twice = half + half;
        vector + twice * self.w + self.xyz().cross(twice)
    }
}
