//! The integration tests: one program, because linking is slow, with one module per subject.
//!
//! `memory` and `allocations` are separate, because each has its own global allocator.

mod architecture;
mod armatures;
mod array_files;
mod arrays;
mod asf_amc;
mod biomechanics;
mod bone_axis;
mod broken;
mod bvh_out;
mod bvh_rest;
mod c3d;
mod changed_skeletons;
mod clean;
mod compressed_characters;
mod compression;
mod conversion;
mod creatures;
mod cut;
mod dialects;
mod edit;
mod error_bounds;
mod examples;
mod exporter;
#[cfg(feature = "fbx")]
mod fbx;
#[cfg(feature = "fbx")]
mod fbx_bones;
#[cfg(feature = "fbx")]
mod fbx_out;
#[cfg(feature = "fbx")]
mod fbx_streams;
mod fixtures;
mod generated_skeletons;
mod gltf;
mod golden;
mod graph;
mod hostile;
mod humanoid;
mod jobs;
mod kinematics;
mod limits;
#[cfg(feature = "live")]
mod live;
mod markers;
mod mjcf_files;
mod mmd;
mod morph_targets;
mod motion_steps;
mod names;
mod numbers;
mod one_answer;
mod over_ground;
mod packed_clip;
mod palms;
mod process;
mod properties;
mod public;
#[cfg(feature = "render")]
mod render;
mod rest_out;
mod rest_poses;
mod retarget;
mod retargeting;
mod robot_dynamics;
mod robot_elbows;
mod robot_kinds;
mod robot_passes;
mod robot_stream;
mod robot_verdict;
mod robots;
mod roll;
mod sample;
mod scene_as_json;
mod schema;
mod search;
mod solve;
mod source;
mod survey;
mod threads;
mod trc;
mod usd;
mod validate;
mod verify;
mod vrma;
mod vrma_face;
mod vrma_without_chest;
mod world_positions;
mod wrap;

/// The root of the repository.
const ROOT: &str = env!("CARGO_MANIFEST_DIR");
