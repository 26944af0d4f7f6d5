//! The integration tests of the whole library: one program, because linking is slow, with one module per subject. The
//! tests of a single package are in `src/PACKAGE/tests/it`.
//!
//! `memory` and `allocations` are separate, because each has its own global allocator.

mod architecture;
mod closed_forms;
mod constants;
#[allow(dead_code, reason = "the tests of the packages use it")]
mod cut;
mod examples;
mod fixtures;
mod hostile;
#[allow(dead_code, reason = "the tests of the packages use the rest of it")]
mod kinematics;
mod messages;
mod properties;
mod prose;
mod public;
#[allow(dead_code, reason = "the tests of the packages use the rest of it")]
mod sample;
mod scene_as_json;
mod source;
mod weights;
mod wrap;

/// The root of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");
