//! The file that a scene was read from, where an output keeps what the scene does not hold.

use std::fmt;
use std::sync::Arc;

use super::{Keys, Mesh, Node, Scene};
use crate::error::{Code, Diagnostic, Result};

/// The name of the material of a mesh that is drawn of a skeleton, which is nothing that a file could lose. Other
/// programs number it.
#[doc(hidden)]
pub const SKELETON_MATERIAL: &str = "SkeletonMaterial";

impl Scene {
    /// The meshes but those that are drawn of a skeleton, here or by whoever wrote the file.
    #[doc(hidden)]
    pub fn own_meshes(&self) -> impl Iterator<Item = &Mesh> {
        self.meshes.iter().filter(|mesh| !self.is_drawn_skeleton(mesh))
    }

    /// Whether a mesh is drawn of a skeleton.
    #[doc(hidden)]
    pub fn is_drawn_skeleton(&self, mesh: &Mesh) -> bool {
        let material = self.materials.get(mesh.material_index);
        material.is_some_and(|material| material.name.starts_with(SKELETON_MATERIAL))
    }
}

/// How far a number of a node's transform may be from the number in the file: what a change and its inverse round.
const ROUNDED: f32 = 1e-5;

/// A glTF or VRM file with meshes, whole. A scene that has it is written as glTF into this file: its animations are
/// replaced by those of the scene, and everything else stays, byte by byte. Without it the skeleton alone is written.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::{Exporter, Format};
///
/// let mut scene = mocap::import("fixtures/characters/human_vrm0.vrm")?;
/// let hero = Exporter::new().write(&scene, Format::Gltf)?.len();
/// scene.original = None;
/// assert!(Exporter::new().write(&scene, Format::Gltf)?.len() < hero);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, PartialEq)]
pub struct Original {
    #[doc(hidden)]
    pub file: Arc<OriginalFile>,
    /// The one animation of the file that is replaced; otherwise all are.
    #[doc(hidden)]
    pub replaced: Option<usize>,
    /// The curves of the morph targets that animations move.
    #[doc(hidden)]
    pub morphs: Vec<MorphCurves>,
}

/// The weights of the morph targets of a node of the file over time.
#[derive(Clone, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct MorphCurves {
    /// The index of the node in the file.
    #[doc(hidden)]
    pub node: usize,
    /// The weight of each target at rest.
    #[doc(hidden)]
    pub at_rest: Vec<f32>,
    /// Of each target its weight in every animation of the scene, without keys where it stays at rest.
    #[doc(hidden)]
    pub targets: Vec<Vec<Keys<f32>>>,
}

/// What a reader keeps of a file.
#[derive(PartialEq)]
#[doc(hidden)]
pub struct OriginalFile {
    #[doc(hidden)]
    pub bytes: Vec<u8>,
    /// The files beside it that it refers to, by the names that it has for them.
    #[doc(hidden)]
    pub beside: Vec<(String, Vec<u8>)>,
    /// Whether it states a humanoid of VRM.
    #[doc(hidden)]
    pub is_vrm: bool,
    /// The index in the file of each node of the scene; none for a group above several roots.
    #[doc(hidden)]
    pub indices: Vec<Option<usize>>,
    /// The nodes of the scene with their transforms in the file, which a scene with a bind pose does not have.
    #[doc(hidden)]
    pub in_file: Vec<Node>,
    /// The nodes of the scene as it was read.
    #[doc(hidden)]
    pub as_read: Vec<Node>,
}

impl fmt::Debug for Original {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (file, replaced) = (&self.file, self.replaced);
        write!(f, "Original {{ {} bytes, replaced: {replaced:?} }}", file.bytes.len())
    }
}

impl Original {
    /// Whether the file states a humanoid of VRM, so that an output may be called `.vrm`.
    pub fn is_vrm(&self) -> bool {
        self.file.is_vrm
    }

    /// Refuses a scene whose skeleton is no longer the file's.
    #[doc(hidden)]
    pub fn check(&self, scene: &Scene) -> Result<()> {
        let (ours, theirs) = (&scene.nodes, &self.file.as_read);
        let is_same = |(a, b): (&Node, &Node)| {
            a.name == b.name && a.parent == b.parent && a.transform.abs_diff_eq(b.transform, ROUNDED)
        };
        let changed = std::iter::zip(ours, theirs).find(|pair| !is_same(*pair));
        let what = match changed {
            Some((node, old)) if node.name != old.name => format!("\"{}\" is called \"{}\"", old.name, node.name),
            Some((node, _)) => format!("the rest pose, the unit or the axes of \"{}\" were changed", node.name),
            None if ours.len() != theirs.len() => format!("it has {} nodes, and had {}", ours.len(), theirs.len()),
            None => return Ok(()),
        };
        let message = format!("the meshes of the file cannot be kept, for they fit its skeleton as it was: {what}");
        let help = "leave out {unit}, {up}, {rest}, {bone-axis}, {names} and {root-motion}, or write the skeleton without the meshes: \
                    {skeleton-only}";
        Err(Diagnostic::new(Code::Unrepresentable, message).help(help).into())
    }
}
