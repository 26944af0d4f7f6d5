//! Writes a scene as BVH.
//!
//! | scene | BVH |
//! |---|---|
//! | [`Scene::nodes`] | one ROOT, its JOINTs and End Sites, in the same order; several, where the scene was read from several |
//! | the translation of a node's rest transform | OFFSET, where the scene was read from BVH |
//! | the position in the first frame | OFFSET of JOINTs, where the scene was read from another format; the OFFSET of a ROOT is then zero, because some programs add it to the position |
//! | animated positions | position channels, as [`Channels`] says; the ROOT always has them |
//! | the unit of length | nothing: BVH has no unit, and numbers are written as they are |
//! | rotations | three rotation channels, in the node's [`Node::rotation_order`](mocap_scene::scene::Node::rotation_order) |
//! | the rotation of a rest transform | nothing: OFFSETs and rotation channels give the position of every node in every frame |
//! | a constant scale | scaled lengths below the node; an animated scale is lost |
//! | meshes, materials, further animations | nothing |
//! | a scene without an animation | one frame, the rest pose |
//!
//! Angles continue past 180 degrees, so that curves in an editor have no jumps. In gimbal lock the last angle keeps its
//! value.
//!
//! Numbers have the fewest decimals with which the same keys are read back: 1 degree is `1`, and the keys of a BVH file
//! with four decimals get four decimals again. Keys are the same bit by bit, with two exceptions: 1e-14, the precision
//! of an angle after some turns, counts as zero, and a quaternion whose sign depends on such a number may become its
//! negative. [`BvhOptions::digits`] sets a fixed number of decimals instead.

mod angles;
mod build;
mod number;

use crate::{Sidecar, WriteOptions, Written, WrittenFile};
use mocap_scene::error::{Diagnostic, Result};
use mocap_scene::options::setters;
use mocap_scene::scene::{RotationOrder, Scene};
use serde::{Deserialize, Serialize};

/// Which joints have position channels.
///
/// [`BvhOptions`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Channels {
    /// The ROOT, and joints whose position differs from their OFFSET in some frame.
    #[default]
    Auto,
    /// Only the ROOT. Other joints keep the position of the first frame, and the motion of their positions is lost.
    #[serde(rename = "3")]
    #[cfg_attr(feature = "clap", value(name = "3"))]
    Three,
    /// Every joint.
    #[serde(rename = "6")]
    #[cfg_attr(feature = "clap", value(name = "6"))]
    Six,
}

/// Options of the writer.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::bvh::{BvhOptions, Channels};
/// use mocap::scene::RotationOrder;
/// use mocap::{Exporter, Format};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let options = BvhOptions::new().order(RotationOrder::Yxz).digits(3).channels(Channels::Three);
/// let written = Exporter::new().bvh(options).write(&scene, Format::Bvh)?;
/// assert!(written.into_bytes()?.starts_with(b"HIERARCHY"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BvhOptions {
    /// The order of the rotation channels of all joints. Default: `None`, each joint's own order, or else `Zxy`.
    pub order: Option<RotationOrder>,
    /// Decimals of every number. Default: `None`, as many as are needed to read the same keys back.
    pub digits: Option<usize>,
    /// Which joints have position channels.
    pub channels: Channels,
    /// Whether a file beside it says how it was made, of which BVH has no word: `walk.bvh.json` beside `walk.bvh`.
    /// Every reader of the BVH file reads it.
    pub sidecar: bool,
}

setters! {
    BvhOptions {
        order: Option<RotationOrder>,
        digits: Option<usize>,
        channels: Channels,
        sidecar: bool,
    }
}

impl BvhOptions {
    /// The text of a BVH file.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::bvh::BvhOptions;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let text = String::from_utf8(BvhOptions::default().write(&scene)?).unwrap();
    /// assert!(text.starts_with("HIERARCHY\nROOT Shoulder\n{\n\tOFFSET 0 0 0\n"));
    /// assert!(text.contains("Frames: 10\nFrame Time: 0.1\n"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable), with the joint, where a value is not finite or a
    /// quaternion is not a rotation, and where the scene has no nodes.
    pub fn write(&self, scene: &Scene) -> Result<Vec<u8>> {
        Ok(build::text(scene, self)?.into_bytes())
    }
}

impl BvhOptions {
    /// Where joints of the file will be off because BVH has no scales: a warning with the largest distance.
    ///
    /// # Errors
    /// As [`BvhOptions::write`](crate::bvh::BvhOptions::write).
    pub fn scale_warning(&self, scene: &Scene) -> Result<Option<Diagnostic>> {
        build::scale_warning(scene, self)
    }
}

/// The files of the row.
pub(super) fn files(scene: &Scene, options: &WriteOptions) -> Result<Written> {
    let text = build::text(scene, &options.bvh)?;
    let beside = options
        .bvh
        .sidecar
        .then(|| Sidecar::of(scene, &options.name, text.as_bytes()));
    let main = WrittenFile::new(&options.name, text.into_bytes());
    Ok(Written {
        warnings: Vec::from_iter(options.bvh.scale_warning(scene)?),
        nodes: scene.nodes.len(),
        ..Written::of(beside.into_iter().chain([main]).collect())
    })
}
