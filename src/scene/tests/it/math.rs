//! Tests mathematical functions against other formulas.

mod cube_root;
mod half;
mod hull;
mod principal;
mod quaternion;
mod rotation;
mod soa;
mod up_axis;
mod velocity;
