//! Writes a scene as animated glTF 2.0 that every client loads.
//!
//! | scene | glTF |
//! |---|---|
//! | [`Scene::nodes`] | the same nodes in the same order, as translation, rotation and scale; never a matrix |
//! | [`Node::name`](mocap_scene::scene::Node::name) | `name`, [made unique](NodeRename); the original in `extras.source_name` if it differs |
//! | an end site | a node and a joint like any other, with `extras.end_site` |
//! | all joints and end sites | one `skin`, its `skeleton` the root, `inverseBindMatrices` from the bones or else the rest pose |
//! | a mesh with bones | a separate mesh node at the scene's root, with that skin |
//! | meshes without bones | the mesh of their node; then no skin is written |
//! | meshes without any area, because all joints are at one point | an octahedron of 1 cm on the first joint, with the skin |
//! | normals equal to the normals of flat faces | omitted: a glTF mesh without normals has flat shading |
//! | [`Scene::materials`] | `materials`; one without a surface in [`BASE_COLOR`] |
//! | [`Scene::textures`] | `images` in the buffer, if a material uses them |
//! | an animated track | a `LINEAR` sampler of 32-bit floats |
//! | a constant track | the node's own translation, rotation or scale |
//! | tracks with a [`Compression`] or a largest error | fewer keys, and normalised integers |
//! | ticks | seconds, in one accessor that all tracks with the same ticks share |
//! | metadata | `asset.extras.mocap`: a [`Provenance`] |
//!
//! Values are written unchanged: glTF is in metres with +Y up, and [`Conversion`](mocap_figure::convert::Conversion)
//! converts a scene. If a scene is not known to be in metres, [`GltfReport::warnings`] has a warning.
//!
//! The reasons for this structure:
//!
//! - A file without a skin has no skeleton in Blender, Babylon and game engines.
//! - Model-viewer and Assimp refuse a skin without a mesh, and optimisers drop such a skin.
//! - At least one client refuses or misreads a mesh under a joint, a duplicate name, a matrix or a repeated time.

mod animation;
mod buffer;
mod build;
mod container;
pub(super) mod dangling;
mod edits;
mod freed;
mod glb;
mod indices;
mod kept;
mod mesh;
mod morphs;
mod names;
pub(super) mod patch;
mod rest;
#[doc(hidden)]
pub(crate) mod text;
pub(crate) mod values;

use std::fmt;

use mocap_compress::ErrorBound;
use mocap_scene::error::{Diagnostic, Result};
use mocap_scene::options::setters;
use mocap_scene::report::counted;
use mocap_scene::scene::Scene;
use serde::Serialize;

use super::report::Deviation;
use super::{BufferPlace, Compression};
use crate::report::NodeRename;
use crate::written::unit_warning;
use crate::{Export, ExportFile, WriteOptions};
#[cfg(doc)]
use mocap_scene::error::Code;

/// The colour of a material without a colour, an orange visible on white, grey and black: linear red, green, blue and
/// alpha.
const BASE_COLOR: [f32; 4] = [0.80, 0.25, 0.03, 1.0];

/// Options of the writer.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::gltf::{Compression, GltfOptions};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let options = GltfOptions::new().compression(Compression::Int16).keep_constant(true);
/// assert!(options.write_glb(&scene)?.starts_with(b"glTF"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct GltfOptions {
    /// Whether to write constant tracks as channels too, for engines that blend clips channel by channel. Default:
    /// `false`, only the node has a constant value.
    pub keep_constant: bool,
    /// The place of a `.gltf` file's buffer. A `.glb` file always contains its buffer.
    pub buffer: BufferPlace,
    /// The storage of keys.
    pub compression: Compression,
    /// The largest distance in metres of a joint or end site from its position in the scene, as a reader decodes the
    /// file. The limit applies at every whole tick and at every key of the scene. Within this limit, keys are removed
    /// and numbers are rounded, by [`GltfOptions::compression`]. [`GltfReport::achieved`] has the result. Default: none
    /// for [`Compression::None`], which then keeps every key unchanged. For other compressions, the default is 1 mm, as
    /// in [`ErrorBound`].
    pub error_bound: Option<ErrorBound>,
}

setters! {
    GltfOptions {
        keep_constant: bool,
        buffer: BufferPlace,
        compression: Compression,
        error_bound: Option<ErrorBound>,
    }
}

impl GltfOptions {
    /// The bound of the compression; `None` if every key stays unchanged.
    fn bound(&self) -> Option<ErrorBound> {
        let is_compressed = self.compression != Compression::None;
        self.error_bound
            .clone()
            .or_else(|| is_compressed.then(ErrorBound::default))
    }
}

/// The report about a written file.
///
/// [`VrmaOptions`](crate::vrma::VrmaOptions) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct GltfReport {
    /// The renamed nodes.
    pub renamed: Vec<NodeRename>,
    /// The number of joints of the skin, including end sites, or of bones of a VRM animation; 0 without a skin.
    pub joints: usize,
    /// The number of vertices of all meshes, after equal vertices were merged.
    pub vertices: usize,
    /// The number of animated tracks, each an animation channel.
    pub animated_tracks: usize,
    /// The number of constant tracks, which became part of a node.
    pub constant_tracks: usize,
    /// The number of dropped keys whose time rounds to the same 32-bit number as the time of the previous key. Above 0
    /// only in takes of more than 16 million frames.
    pub dropped_keys: usize,
    /// The error of the file, the largest of all animations. Absent if every key was kept unchanged.
    pub achieved: Option<Deviation>,
    /// The source joints that are not bones of the humanoid, and so are not in a VRM animation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// The size of all files in bytes.
    pub bytes: usize,
    /// Warnings about what a reader of the file may misinterpret: [`Code::UnknownUnit`] if the lengths are not known to
    /// be metres.
    pub warnings: Vec<Diagnostic>,
}

impl fmt::Display for GltfReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (joints, vertices) = (counted(self.joints, "joint"), self.vertices);
        let (animated, constant) = (self.animated_tracks, self.constant_tracks);
        let bytes = counted(self.bytes, "byte");
        write!(
            f,
            "{joints}, vertices: {vertices}, animated tracks: {animated}, constant tracks: {constant}, {bytes}"
        )
    }
}

/// The fraction of the largest error for bone positions. Joint positions do not reveal a rotation error of the last
/// bone in a chain, but the skin around this bone must also stay within the bound. So bones get a smaller bound.
const BOUND_OF_BONES: f64 = 0.45;

/// The contents of a document.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Content {
    /// The scene with its meshes, in the rest pose of its motion.
    Scene,
    /// The motion of a humanoid in its T-pose, with the extension that states its bones.
    VrmAnimation,
}

/// A scene as a glTF document, before it is written to files.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::gltf::{Document, GltfOptions};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let document = Document::new(&scene, &GltfOptions::new())?;
/// assert!(document.report().animated_tracks > 0);
/// assert!(document.to_glb()?.starts_with(b"glTF"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Document {
    /// The document without its animations.
    root: gltf_json::Root,
    animations: Vec<text::Animation>,
    bin: Vec<u8>,
    report: GltfReport,
}

impl Document {
    /// Makes the glTF document of `scene`.
    ///
    /// # Errors
    /// - [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable), with the joint, if a value is not finite or a
    ///   quaternion is not a rotation
    /// - [`Code::FrameTime`](mocap_scene::Code::FrameTime) if ticks per second are not above 0
    /// - [`Code::ErrorBound`](mocap_scene::Code::ErrorBound) if the largest error cannot be kept
    /// - [`Code::MissingFeature`](mocap_scene::Code::MissingFeature) if this build has no meshopt
    pub fn new(scene: &Scene, options: &GltfOptions) -> Result<Self> {
        let mut document = build::document(scene, options, Content::Scene)?;
        document.report.warnings.extend(unit_warning(scene, "glTF"));
        Ok(document)
    }

    /// Makes the document of a VRM animation from a scene of [`figure::vrm_humanoid`](mocap_figure::vrm_humanoid()).
    pub(super) fn of_vrm_animation(scene: &Scene, options: &GltfOptions) -> Result<Self> {
        let options = GltfOptions {
            keep_constant: false,
            error_bound: options.bound().map(|bound| bound.tighter(BOUND_OF_BONES)),
            ..options.clone()
        };
        build::document(scene, &options, Content::VrmAnimation)
    }

    /// The report. [`GltfReport::bytes`] is 0, because there is no file yet.
    pub fn report(&self) -> &GltfReport {
        &self.report
    }
}

impl GltfOptions {
    /// The glTF options among the options of all writers.
    pub(super) fn of(options: &WriteOptions) -> Self {
        let usual = match options.error_bound {
            Some(_) => Compression::Int16,
            None => Compression::None,
        };
        let compression = options.compression.unwrap_or(usual);
        Self {
            keep_constant: options.keep_constant,
            buffer: options.buffer,
            compression,
            error_bound: match compression {
                Compression::None => options.bound(),
                _ => Some(options.bound_or_usual()),
            },
        }
    }
}

impl GltfReport {
    /// The common report of all formats.
    pub(super) fn written(&self) -> Export {
        let dropped = (self.dropped_keys > 0).then(|| {
            format!(
                "{} keys were dropped, because 32-bit times cannot distinguish them",
                self.dropped_keys
            )
        });
        Export {
            notes: Vec::from_iter(left_out(&self.left_out).into_iter().chain(dropped)),
            warnings: self.warnings.clone(),
            renamed: self.renamed.clone(),
            error: self.achieved.clone(),
            nodes: self.joints,
            ..Export::default()
        }
    }
}

/// The source joints that a VRM animation lacks, as a sentence.
fn left_out(joints: &[String]) -> Option<String> {
    /// The largest number of joints that a note names.
    const MOST: usize = 8;
    let (shown, more) = joints.split_at(joints.len().min(MOST));
    let more = match more.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let names = shown.join(", ");
    (!joints.is_empty()).then(|| format!("joints: {names}{more} dropped, because they are not VRM bones"))
}

/// The files of this format: `.gltf` if the name has that extension, otherwise `.glb`. If the scene was read from a
/// file with meshes, the result is that file with the motion of the scene.
pub(super) fn files(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    let gltf = GltfOptions::of(options);
    if let Some(original) = &scene.original {
        return kept::files(scene, original, options, &gltf);
    }
    let document = Document::new(scene, &gltf)?;
    let written = Export {
        nodes: scene.nodes.len(),
        ..document.report.written()
    };
    let name = &options.name;
    let files = match (options.has_extension("gltf"), gltf.buffer) {
        (false, _) => vec![document.into_glb_file(name)?],
        (true, BufferPlace::Embedded) => vec![ExportFile::new(name, document.to_embedded()?)],
        (true, BufferPlace::Beside) => document.into_text_and_bin_files(name)?,
    };
    Ok(Export { files, ..written })
}

impl GltfOptions {
    /// The bytes of a `.glb` file. Its report is [`Document::report`].
    ///
    /// # Errors
    /// The errors of [`Document::new`], and [`Code::LimitExceeded`](mocap_scene::Code::LimitExceeded) beyond the
    /// container's 4 GiB.
    pub fn write_glb(&self, scene: &Scene) -> Result<Vec<u8>> {
        Document::new(scene, self)?.to_glb()
    }
}
