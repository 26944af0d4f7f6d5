//! Tests of the data of scenes.

mod humanoid_bone;
mod joint_tables;
mod metadata;
mod robot;
