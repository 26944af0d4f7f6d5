//! The integration tests of the program: one test program, because linking is slow, with one module per subject.

mod agent;
mod angles;
mod as_json;
mod attribution;
mod batch;
mod build_note;
mod c3d_recorded;
mod chain;
mod conversion;
mod convert_and_verify;
mod corpus;
#[path = "../../../../tests/it/cut.rs"]
mod cut;
mod cut_off;
#[cfg(feature = "fbx")]
mod doctor;
mod doors;
mod doubts;
mod edit_command;
mod edit_many;
mod every_step;
mod exit_codes;
mod exporter;
#[cfg(feature = "fbx")]
mod fbx_out;
mod frame_rates;
mod graph;
mod help;
#[cfg(unix)]
mod inputs;
#[cfg(unix)]
mod interrupted;
mod jobs;
#[cfg(all(feature = "schema", unix))]
mod json_schema;
mod kept_characters;
mod lengths;
mod limits;
#[cfg(unix)]
mod live;
mod motion_files;
mod names;
mod one_answer;
#[cfg(all(feature = "schema", unix))]
#[path = "../../../job/tests/it/published_schema.rs"]
mod published_schema;
// The table has the options of `pack`.
#[cfg(feature = "parquet")]
mod one_meaning;
mod one_skeleton;
mod options;
mod output_sets;
mod outputs;
mod own_outputs;
#[cfg(feature = "parquet")]
mod pack_dataset;
mod packed_clip;
mod packets;
mod program;
mod refusals;
mod report;
mod resume;
mod retarget_command;
mod retarget_many;
mod retargeting;
mod robot_command;
#[cfg(unix)]
mod robot_stream;
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod search;
mod several_clips;
mod sidecar;
mod skeleton;
mod split;
mod streams;
#[cfg(unix)]
mod terminal;
mod usd;
mod verify_arrays;
mod wrong_words;

/// The root of the repository. Cargo runs the tests in the folder of their package; the program runs in this one.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// A file of the repository, for a test that reads it itself.
fn at_root(path: &str) -> String {
    format!("{ROOT}/{path}")
}
