//! The integration tests: one program, because linking is slow, with one module per subject.
//!
//! `memory` and `allocations` are separate, because each has its own global allocator.

#[cfg(feature = "cli")]
mod agent;
mod architecture;
mod armatures;
mod array_files;
mod arrays;
mod asf_amc;
#[cfg(feature = "cli")]
mod batch;
mod biomechanics;
mod bone_axis;
mod broken;
mod bvh_out;
mod bvh_rest;
mod c3d;
#[cfg(feature = "cli")]
mod c3d_recorded;
mod changed_skeletons;
mod clean;
mod compressed_characters;
mod compression;
mod conversion;
#[cfg(feature = "cli")]
mod convert_and_verify;
#[cfg(feature = "cli")]
mod corpus;
mod creatures;
mod cut;
mod dialects;
#[cfg(all(feature = "cli", feature = "fbx", feature = "npz"))]
mod doors;
mod edit;
mod error_bounds;
#[cfg(feature = "cli")]
mod every_step;
mod examples;
#[cfg(feature = "cli")]
mod exit_codes;
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
#[cfg(feature = "cli")]
mod frame_rates;
mod generated_skeletons;
mod gltf;
mod golden;
mod graph;
mod hostile;
mod humanoid;
#[cfg(all(unix, feature = "cli"))]
mod interrupted;
mod jobs;
#[cfg(feature = "cli")]
mod kept_characters;
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
mod one_skeleton;
#[cfg(feature = "cli")]
mod options;
#[cfg(feature = "cli")]
mod outputs;
mod over_ground;
mod packed_clip;
mod palms;
mod process;
#[cfg(feature = "cli")]
mod program;
mod properties;
mod public;
#[cfg(feature = "cli")]
mod refusals;
#[cfg(feature = "render")]
mod render;
mod rest_out;
mod rest_poses;
mod retarget;
#[cfg(feature = "cli")]
mod retarget_command;
#[cfg(feature = "cli")]
mod retarget_many;
mod retargeting;
#[cfg(feature = "cli")]
mod robot_command;
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
#[cfg(feature = "cli")]
mod streams;
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
