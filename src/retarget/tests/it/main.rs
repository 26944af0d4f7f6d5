//! The integration tests of retargeting: one program, because linking is slow, with one module per subject.

mod above_floor;
mod animals;
mod armatures;
mod characters;
mod constant;
mod creatures;
mod hands;
mod live;
mod mjcf_files;
mod palms;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../edit/tests/it/positions.rs"]
mod positions;
mod quadrupeds;
mod rest_poses;
mod retarget;
mod retargeting;
mod rigs;
mod robot;
mod robot_dynamics;
mod robot_elbows;
mod robot_kinds;
mod robot_passes;
mod robot_scores;
mod robot_stream;
mod robot_time_scale;
mod robot_to_robot;
mod robot_verdict;
mod robot_walk;
mod robots;
mod roll;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../../tests/it/sample.rs"]
mod sample;
mod steps;
#[path = "../../../edit/tests/it/still.rs"]
mod still;
#[allow(dead_code, reason = "other packages use the rest of it")]
#[path = "../../../figure/tests/it/truth.rs"]
mod truth;
