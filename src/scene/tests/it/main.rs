//! The integration tests of scenes: one program, because linking is slow, with one module per subject.

mod files;
#[cfg(feature = "ik")]
mod ik;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/kinematics.rs"]
mod kinematics;
mod math;
mod motion_steps;
mod nearest;
mod player;
mod pose;
mod process;
mod scene;
mod spelling;
mod validate;
mod world_positions;
