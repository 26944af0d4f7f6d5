//! Tests of steps: the laws that every step keeps, and the effect of each step on real files.

mod alike;
mod bent;
mod bones;
mod cleaned;
mod constant;
mod feet;
mod joined;
mod laws;
mod mirrored;
mod reached;
mod smoothed;

use mocap::glam::{DVec3, Vec3};
use mocap::scene::NodeId;
use mocap::{Binding, Pose, Scene};

use crate::positions::{assert_bones_keep_their_lengths, exact_positions, import, positions, ratios};
