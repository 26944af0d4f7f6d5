//! A scene as BVH, for the programs that read nothing else.
//!
//! | scene | BVH |
//! |---|---|
//! | [`Scene::nodes`] | one ROOT, its JOINTs and End Sites, in the same order; several, where the scene was read from several |
//! | the translation of a node's rest transform | OFFSET, where the scene was read from BVH |
//! | the place in the first frame | OFFSET of JOINTs, where the scene was read from another format; a ROOT has none then, for some programs add it to its position |
//! | positions that move | position channels, as [`Channels`] says; the ROOT has them always |
//! | rotations | three rotation channels, in the node's [`rotation_order`](crate::scene::Node::rotation_order) |
//! | a rest transform that turns | nothing: OFFSETs are enough to put every node into its place in every frame |
//! | a constant scale | lengths below it; a scale that changes is lost |
//! | meshes, materials, further animations | nothing |
//! | a scene without an animation | one frame, the rest pose |
//!
//! Angles go on past 180 degrees where the motion does, so that a curve in an editor has no jumps. In gimbal lock the
//! last angle stays as it was.
//!
//! Numbers are as short as they can be while a key that is read back is the same key: 1 degree is `1`, and the keys of
//! a BVH file that was written with four decimals come out with four decimals. Keys are the same bit by bit, except
//! that 1e-14, the precision of an angle after some turns, counts as zero, and that a quaternion whose sign hangs on
//! such a number may become its negative. [`Options::digits`] asks for a fixed number of decimals instead.

mod angles;
mod build;
mod number;

use std::path::Path;

use crate::error::Result;
use crate::export::write_file;
use crate::scene::{RotationOrder, Scene};

/// Which joints have position channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channels {
    /// The ROOT, and joints whose position is not their OFFSET all the time.
    #[default]
    Auto,
    /// The ROOT alone. Joints stay where their first frame has them, so motion of their positions is lost.
    Three,
    /// Every joint.
    Six,
}

/// What a caller can ask of the writer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The order of the rotation channels, for every joint. Default: each joint's own, else `Zxy`.
    pub order: Option<RotationOrder>,
    /// Decimals of every number. Default: as many as it takes to read the same keys back.
    pub digits: Option<usize>,
    /// Which joints have position channels.
    pub channels: Channels,
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Report {
    /// Rows of the motion.
    pub frames: usize,
    /// Values in a row.
    pub channels: usize,
    /// Bytes of the file.
    pub bytes: usize,
}

/// The text of a BVH file.
///
/// ```
/// use mocap::bvh::{Options, write};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let text = String::from_utf8(write(&scene, &Options::default())?).unwrap();
/// assert!(text.starts_with("HIERARCHY\nROOT Shoulder\n{\n\tOFFSET 0 0 0\n"));
/// assert!(text.contains("Frames: 10\nFrame Time: 0.1\n"));
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// [`Code::Unrepresentable`](crate::Code::Unrepresentable), with the joint, where a value is not finite or a rotation
/// is none, and where the scene has no node.
pub fn write(scene: &Scene, options: &Options) -> Result<Vec<u8>> {
    Ok(build::text(scene, options)?.0.into_bytes())
}

/// Writes `scene` to `path`. The file is whole or absent.
///
/// # Errors
/// As [`write()`], and [`Code::Io`](crate::Code::Io).
pub fn export(scene: &Scene, path: impl AsRef<Path>, options: &Options) -> Result<Report> {
    let (text, report) = build::text(scene, options)?;
    write_file(path.as_ref(), text.as_bytes())?;
    Ok(report)
}
