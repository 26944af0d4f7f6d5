//! The integration tests of steps and motion graphs: one program, because linking is slow, with one module per subject.

mod animals;
mod clean;
mod edit;
mod gaps;
mod graph;
mod lock;
mod positions;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod spline;
mod still;
mod text;
