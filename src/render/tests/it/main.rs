//! The integration tests of pictures: one program, because linking is slow, with one module per subject.

mod limits;
mod render;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
