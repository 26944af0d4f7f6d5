//! Rotations and positions in several poses.

use crate::math::soa::{Quaternions, Vectors};

/// A rotation in `N` poses.
pub(crate) type Rotations<const N: usize> = Quaternions<f32, N>;

/// A position in `N` poses.
pub(crate) type Points<const N: usize> = Vectors<f32, N>;
