//! The integration tests of import and export: one program, because linking is slow, with one module per subject.

mod exporter;
mod faces;
mod large;
mod limits;
mod losses;
mod losses_of_time;
mod numbers;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod threads;
mod units;
