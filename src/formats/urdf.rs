//! URDF, the Unified Robot Description Format of ROS.
//!
//! ```text
//! <robot name>
//!   <link name>    <inertial>, <visual>*, <collision>*: each with <origin xyz rpy> and <geometry>
//!   <joint name type="revolute | continuous | prismatic | fixed | floating | planar | spherical">
//!     <origin xyz rpy> <parent link> <child link> <axis xyz> <limit lower upper velocity effort>
//!     <mimic joint multiplier offset>
//! ```
//!
//! Links and joints are in any order, and form one tree. The axes of a link are the axes of the joint to its parent.
//! `rpy` are rotations about the fixed axes X, Y and Z, in this order: `Rz Ry Rx`. Units are metres and radians, and +Z
//! is up.

#[cfg(feature = "urdf")]
mod read;

use mocap_scene::scene::Format;

use crate::text::begins_with_element;
use crate::{Contents, FormatInfo};

#[cfg(feature = "urdf")]
pub(super) use self::read::read_robot;

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Urdf,
    name: "URDF",
    description: "robot, for ROS",
    extensions: Format::Urdf.extensions(),
    reading: "good: links, joints, limits and shapes of robots",
    writing: "no",
    sniff: |bytes| begins_with_element(bytes, "robot"),
    feature: Some("urdf"),
    reads: cfg!(feature = "urdf"),
    read: reader!("urdf", read::read),
    keeps_shear: true,
    contents: Contents::Robot,
    ..FormatInfo::BASE
};
