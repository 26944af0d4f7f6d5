//! The integration tests of solving: one program, because linking is slow, with one module per subject.

mod biomechanics;
mod markers;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod solve;
