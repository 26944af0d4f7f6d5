//! The arithmetic of several modules.

pub(crate) mod cholesky;
pub(crate) mod cube_root;
pub(crate) mod directions;
pub(crate) mod half;
pub(crate) mod hull;
pub(crate) mod inertia;
pub(crate) mod median;
pub(crate) mod polyline;
pub(crate) mod principal;
pub(crate) mod quaternion;
pub(crate) mod rotation;
pub(crate) mod soa;
pub(crate) mod spread;
pub(crate) mod up_axis;
pub(crate) mod velocity;
pub(crate) mod wide;
