//! Writes a scene as BVH.
//!
//! | scene | BVH |
//! |---|---|
//! | [`Scene::nodes`] | one ROOT, its JOINTs and End Sites, in the same order; several ROOTs if the scene was read from several |
//! | the translation of a node's rest transform | OFFSET, if the scene was read from BVH |
//! | the position in the first frame | OFFSET of JOINTs, if the scene was read from another format; the OFFSET of a ROOT is then zero, because some programs add it to the position |
//! | animated positions | position channels, by the rules of [`Channels`]; the ROOT always has them |
//! | the unit of length | nothing: BVH has no unit, and numbers are written unchanged |
//! | rotations | three rotation channels, in the node's [`Node::rotation_order`](mocap_scene::scene::Node::rotation_order) |
//! | the rotation of a rest transform | nothing: OFFSETs and rotation channels give the position of every node in every frame |
//! | a scale | the positions of descendant joints; position channels, if it changes or differs between axes |
//! | static groups above all joints | nothing: the ROOT includes their transforms |
//! | names | unique, `_` for braces and control characters, `Joint` for an empty name: [`NodeRename`](crate::report::NodeRename) |
//! | meshes, materials, further animations | nothing |
//! | a scene without an animation | one frame, the rest pose |
//!
//! Angles continue past 180 degrees, so that curves in an editor have no jumps. In gimbal lock the last angle keeps its
//! value.
//!
//! Numbers have the fewest decimals from which the same keys are read back. 1 degree is `1`, and the keys of a BVH file
//! with four decimals get four decimals again. The keys are equal bit by bit, with two exceptions. A number within
//! 1e-14, the precision of an angle after some turns, counts as zero. A quaternion whose sign depends on such a number
//! may become its negative. [`BvhOptions::digits`] sets a fixed number of decimals instead.

pub(crate) mod angles;
mod build;
mod motion;
pub(crate) mod number;
mod scale_warning;
mod scales;

use mocap_scene::error::{Diagnostic, Result};
use mocap_scene::scene::Scene;

use super::BvhOptions;
use crate::{Export, ExportFile, Sidecar, WriteOptions};

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
    /// [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable), with the joint, if a value is not finite or a
    /// quaternion is not a rotation. The same code, without a joint, if the scene has no nodes.
    pub fn write(&self, scene: &Scene) -> Result<Vec<u8>> {
        Ok(ExportFile::of_parts("", build::text(scene, self)?.0).into_bytes())
    }
}

impl BvhOptions {
    /// A warning if joint positions in the file will deviate from the scene, because BVH has no channels for scales.
    /// The warning states the largest distance.
    ///
    /// # Errors
    /// The errors of [`BvhOptions::write`](crate::bvh::BvhOptions::write).
    pub fn scale_warning(&self, scene: &Scene) -> Result<Option<Diagnostic>> {
        scale_warning::scale_warning(scene, self)
    }
}

/// The files of this format.
pub(super) fn files(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    let (text, renamed) = build::text(scene, &options.bvh)?;
    let main = ExportFile::of_parts(&options.name, text);
    let beside = options.bvh.sidecar.then(|| Sidecar::of(scene, options, &main));
    Ok(Export {
        warnings: Vec::from_iter(options.bvh.scale_warning(scene)?),
        renamed,
        nodes: scene.nodes.len(),
        ..Export::of(beside.into_iter().chain([main]).collect())
    })
}
