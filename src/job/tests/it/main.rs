//! The integration tests of jobs and arrays: one program, because linking is slow, with one module per subject.

mod array_files;
mod array_units;
mod arrays;
mod bone_axis;
mod bone_maps;
mod conversion;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/cut.rs"]
mod cut;
#[cfg(debug_assertions)]
mod found;
mod gaps;
mod graph;
mod jobs;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/kinematics.rs"]
mod kinematics;
mod losses;
mod names;
mod one_answer;
mod over_ground;
#[cfg(feature = "schema")]
mod published_schema;
mod rest_out;
mod robot_files;
#[path = "../../../retarget/tests/it/robot_walk.rs"]
mod robot_walk;
mod sam3d;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
#[cfg(feature = "schema")]
mod schema;
mod text;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../figure/tests/it/truth.rs"]
mod truth;
mod verify;
mod weights;

/// The root of the repository. Cargo runs the tests in the folder of their package.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
