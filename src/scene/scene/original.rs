//! The source file of a scene, for outputs that keep the contents that a scene cannot hold.

use std::fmt;
use std::sync::Arc;

use super::{Keys, Mesh, Node, Scene};
use crate::error::{Code, Diagnostic, Result};

/// The material name of a mesh that draws a skeleton. An output without such a mesh has lost no data. Other programs
/// append a number to the name.
#[doc(hidden)]
pub const SKELETON_MATERIAL: &str = "SkeletonMaterial";

impl Scene {
    /// The meshes that do not draw a skeleton. This crate or the program that wrote the file may have drawn the
    /// skeleton.
    #[doc(hidden)]
    pub fn own_meshes(&self) -> impl Iterator<Item = &Mesh> {
        self.meshes.iter().filter(|mesh| !self.is_drawn_skeleton(mesh))
    }

    /// Whether a mesh draws a skeleton.
    #[doc(hidden)]
    pub fn is_drawn_skeleton(&self, mesh: &Mesh) -> bool {
        let material = self.materials.get(mesh.material_index);
        material.is_some_and(|material| material.name.starts_with(SKELETON_MATERIAL))
    }
}

/// The largest difference between a number of a node's transform and the number in the file that counts as rounding,
/// after a change and its inverse.
const ROUNDED: f32 = 1e-5;

/// A complete glTF or VRM file with meshes. If the scene has this file, a glTF output is the file with the animations
/// of the scene, and everything else stays byte for byte. Otherwise the output has only the skeleton.
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
    /// The animation of the file to replace; `None` means all.
    #[doc(hidden)]
    pub replaced: Option<usize>,
    /// The curves of animated morph targets.
    #[doc(hidden)]
    pub morphs: Vec<MorphCurves>,
}

/// A complete FBX file with meshes, binary or in text. An FBX output of the scene is this file with the clips of the
/// scene; all other elements are kept.
#[derive(Clone, PartialEq)]
#[doc(hidden)]
pub struct FbxOriginal {
    #[doc(hidden)]
    pub bytes: Arc<[u8]>,
    /// For each node of the scene, its index among the nodes of the file.
    #[doc(hidden)]
    pub nodes: Arc<[u32]>,
    /// Whether the clips of the file are kept beside the clips of the scene.
    #[doc(hidden)]
    pub keeps_clips: bool,
}

impl fmt::Debug for FbxOriginal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FbxOriginal {{ {} bytes }}", self.bytes.len())
    }
}

/// The morph target weights of a node in the file, over time.
#[derive(Clone, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct MorphCurves {
    /// The index of the node in the file.
    #[doc(hidden)]
    pub node: usize,
    /// The name of each target.
    #[doc(hidden)]
    pub names: Vec<String>,
    /// The weight of each target at rest.
    #[doc(hidden)]
    pub at_rest: Vec<f32>,
    /// The weights of each target in every animation of the scene. An animation in which the weight stays at rest has
    /// no keys.
    #[doc(hidden)]
    pub targets: Vec<Vec<Keys<f32>>>,
}

/// The parts of a file that a reader keeps.
#[derive(PartialEq)]
#[doc(hidden)]
pub struct OriginalFile {
    #[doc(hidden)]
    pub bytes: Vec<u8>,
    /// The companion files to which the file refers, each with the name by which the file refers to it.
    #[doc(hidden)]
    pub beside: Vec<(String, Vec<u8>)>,
    /// Whether the file states a VRM humanoid.
    #[doc(hidden)]
    pub is_vrm: bool,
    /// The index in the file of each node of the scene; `None` for the group above several roots.
    #[doc(hidden)]
    pub indices: Vec<Option<usize>>,
    /// The nodes of the scene with their transforms in the file. A scene with a bind pose has other transforms.
    #[doc(hidden)]
    pub in_file: Vec<Node>,
    /// The nodes of the scene as they were read.
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
    /// Whether the file states a VRM humanoid, so that an output may have the extension `.vrm`.
    pub fn is_vrm(&self) -> bool {
        self.file.is_vrm
    }

    /// Refuses a scene whose skeleton differs from the file's.
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
            None if ours.len() != theirs.len() => {
                format!("the scene has {} nodes, but the file has {}", ours.len(), theirs.len())
            }
            None => return Ok(()),
        };
        let message = format!(
            "the meshes of the file cannot be kept, because they fit only its original skeleton: \
            {what}"
        );
        let help = "omit {unit}, {up}, {rest}, {bone-axis}, {names} and {root-motion}, or write the skeleton without \
            the meshes: {skeleton-only}";
        Err(Diagnostic::new(Code::Unrepresentable, message).help(help).into())
    }
}
