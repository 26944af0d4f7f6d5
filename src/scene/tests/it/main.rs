//! The integration tests of scenes: one program, because linking is slow, with one module per subject.

#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/kinematics.rs"]
mod kinematics;
mod motion_steps;
mod process;
mod validate;
mod world_positions;
