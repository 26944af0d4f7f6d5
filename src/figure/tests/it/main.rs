//! The integration tests of figures: one program, because linking is slow, with one module per subject.

mod animals;
mod bone_names;
mod changed_skeletons;
mod contacts;
mod conversion;
mod generated_skeletons;
mod ground;
mod humanoid;
mod maps;
mod names;
mod placed_joints;
mod quadrupeds;
mod rest_pose;
mod rig;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod truth;
mod up;
