//! The integration tests of compression: one program, because linking is slow, with one module per subject.

mod packed_clip;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
