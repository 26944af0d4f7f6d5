//! Arithmetic that several modules share.

pub mod cholesky;
pub mod cube_root;
pub mod directions;
pub mod half;
pub mod hull;
pub mod inertia;
pub mod median;
pub mod polyline;
pub mod principal;
pub mod quaternion;
pub mod rotation;
pub mod soa;
pub mod spread;
pub mod up_axis;
pub mod velocity;
pub mod wide;
