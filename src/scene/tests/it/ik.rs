//! Tests of inverse kinematics.

mod chain;
mod hinge;
mod two_bone;
