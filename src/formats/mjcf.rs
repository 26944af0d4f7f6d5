//! MJCF, MuJoCo's model format.
//!
//! ```text
//! <mujoco model>
//!   <compiler angle eulerseq autolimits meshdir>
//!   <default> <joint ...> <geom ...> <default class> ... </default>
//!   <asset> <mesh name file scale>
//!   <worldbody>
//!     <body name pos quat | euler | axisangle | xyaxes | zaxis childclass>
//!       <inertial> <joint type pos axis range> | <freejoint>, <geom type size pos ... | fromto>
//!       <frame pos quat ... childclass> <joint>, <geom>, <body> ...
//!       <body> ...
//!   <equality> <joint joint1 joint2 polycoef>
//! ```
//!
//! Bodies are nested. The joints of a body are applied in order, each about a point of the body. A body with several
//! joints gets a link for each joint. A ball joint becomes three hinges about X, Y and Z.
//!
//! Missing attributes of an element come from its class, else from the class of the surrounding body, else from the
//! outermost `<default>`. Angles are in degrees unless the compiler states `radian`. Quaternions are `w x y z`.
//!
//! A body without `<inertial>` has the mass of its geoms, unless one of them is a mesh.
//!
//! `<include file>` may occur anywhere: the elements of the included file replace it. File names are relative to the
//! folder of the main file. A `<frame>` transforms its contents.

#[cfg(feature = "mjcf")]
mod read;

use mocap_scene::scene::Format;

use crate::text::begins_with_element;
use crate::{Contents, FormatInfo};

#[cfg(feature = "mjcf")]
pub(super) use self::read::read_robot;

pub(super) const FORMAT: FormatInfo = FormatInfo {
    format: Format::Mjcf,
    name: "MJCF",
    description: "robot, for MuJoCo",
    // `.xml` may be anything, so the contents decide.
    extensions: Format::Mjcf.extensions(),
    reading: "good: links, joints, limits and shapes of robots",
    writing: "no",
    sniff: |bytes| begins_with_element(bytes, "mujoco"),
    feature: Some("mjcf"),
    reads: cfg!(feature = "mjcf"),
    read: reader!("mjcf", read::read),
    keeps_shear: true,
    contents: Contents::Robot,
    ..FormatInfo::BASE
};
