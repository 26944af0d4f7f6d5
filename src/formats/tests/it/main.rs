//! The integration tests of the formats: one program, because linking is slow, with one module per subject.

mod asf_amc;
mod bind_pose;
mod broken;
mod bvh;
mod bvh_out;
mod bvh_rest;
mod bvh_scales;
mod c3d;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../retarget/tests/it/characters.rs"]
mod characters;
mod clip_extras;
mod compressed_characters;
mod compression;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/cut.rs"]
mod cut;
mod dialects;
mod dump_number;
mod error_bounds;
mod face_shapes;
mod fbx;
mod fbx_bones;
mod fbx_kept;
mod fbx_out;
mod fbx_stated;
mod fbx_streams;
mod fbx_text;
mod gltf;
mod golden;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/kinematics.rs"]
mod kinematics;
mod left_out;
mod mesh_bounds;
mod mesh_surface;
mod mmd;
mod morph_targets;
mod motive;
mod named_file;
mod ndarray;
mod options;
mod rows;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod schema;
mod skin_weights;
mod text;
mod trc;
mod usd;
mod vrma;
mod vrma_face;
mod vrma_without_chest;

/// The root of the repository. Cargo runs the tests in the folder of their package.
const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
