//! Rotations and positions in several poses.

use mocap_scene::math::soa::{Quaternions, Vectors};

/// A rotation in `N` poses.
pub type Rotations<const N: usize> = Quaternions<f32, N>;

/// A position in `N` poses.
pub type Points<const N: usize> = Vectors<f32, N>;
