//! A scene as animated glTF 2.0 that every client loads.
//!
//! | scene | glTF |
//! |---|---|
//! | [`Scene::nodes`] | the same nodes in the same order, as translation, rotation and scale; never a matrix |
//! | [`Node::name`](crate::scene::Node::name) | `name`, [made unique](Renamed); the original in `extras.source_name` where it differs |
//! | an end site | a node and a joint like any other, with `extras.end_site` |
//! | all joints and end sites | one `skin`, its `skeleton` the root, `inverseBindMatrices` from the bones or else the rest pose |
//! | a mesh with bones | a mesh node of its own at the scene's root, with that skin |
//! | meshes without bones | the mesh of their node; then no skin is written |
//! | meshes without any area, the joints all being in one place | an octahedron of 1 cm on the first joint, with the skin |
//! | normals equal to those of flat faces | left out: a glTF mesh without normals has flat shading |
//! | [`Scene::materials`] | `materials`; one without a surface in [`BASE_COLOR`] |
//! | [`Scene::textures`] | `images` in the buffer, those that a material uses |
//! | an animated track | a `LINEAR` sampler of 32-bit floats |
//! | a constant track | the node's own translation, rotation or scale |
//! | tracks with a [`Compression`] or a largest error | fewer keys, and normalised integers |
//! | ticks | seconds, in one accessor that all tracks with the same ticks share |
//! | metadata | `asset.extras.mocap`: a [`Provenance`] |
//!
//! Values go out as they are: glTF is in metres with +Y up, and [`Conversion`](crate::convert::Conversion) brings a
//! scene there. Where a scene is not known to be in metres, [`GltfReport::warnings`] says so.
//!
//! Reasons: a file without a skin gives no skeleton in Blender, Babylon and game engines; a skin without a mesh is
//! refused by model-viewer and Assimp and dropped by optimisers; a mesh under a joint, a duplicate name, a matrix or a
//! repeated time is refused or misread by some client.

mod animation;
mod buffer;
mod build;
mod container;
mod mesh;
mod names;
pub(super) mod patch;
mod rest;
mod text;
mod values;

use std::path::Path;

use serde::Serialize;

use super::{Achieved, Compression};
use crate::compress::ErrorBound;
use crate::error::{Code, Diagnostic, Result};
use crate::files::{write_file, write_files};
use crate::scene::Scene;

/// The colour of a material that has none, an orange visible on white, grey and black: linear red, green, blue and
/// alpha.
const BASE_COLOR: [f32; 4] = [0.80, 0.25, 0.03, 1.0];

/// Where a `.gltf` file has its buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BufferPlace {
    /// In a `.bin` file beside it.
    #[default]
    Beside,
    /// In the file itself, as a data URI, which takes a third more bytes.
    Embedded,
}

/// Options of the writer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfOptions {
    /// Write constant tracks as channels too, for engines that blend clips channel by channel. Default: `false`,
    /// constant values are only in the node.
    pub keep_constant: bool,
    /// Where a `.gltf` file has its buffer. A `.glb` file always contains it.
    pub buffer: BufferPlace,
    /// How the keys are stored.
    pub compression: Compression,
    /// The largest distance of any joint or end site from its position in the scene, in metres, at any whole tick and
    /// at any key of the scene, as a reader decodes it. Within it, keys are removed and numbers are rounded as
    /// [`GltfOptions::compression`] says; [`GltfReport::achieved`] has the result. Default: none for
    /// [`Compression::None`], which then keeps every key unchanged, otherwise 1 mm, that of [`ErrorBound`].
    pub error_bound: Option<ErrorBound>,
}

impl GltfOptions {
    /// The bound that compression keeps; `None` where every key stays as it is.
    fn bound(&self) -> Option<ErrorBound> {
        let is_compressed = self.compression != Compression::None;
        self.error_bound
            .clone()
            .or_else(|| is_compressed.then(ErrorBound::default))
    }
}

/// A node whose name had to change.
///
/// Clients find animated nodes by name or by a path of names, so a duplicate animates the wrong node. three.js removes
/// `[ ] . : /` and replaces spaces by `_`, so names are unique after that too. Other characters stay as they are, but
/// `/`, at which Unity separates the names of a path, and control characters, which become `_`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Renamed {
    /// Index into [`Scene::nodes`], and into the file's nodes.
    pub node: usize,
    /// The name in the scene.
    pub from: String,
    /// The name in the file.
    pub to: String,
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct GltfReport {
    /// The nodes whose name had to change.
    pub renamed: Vec<Renamed>,
    /// Joints of the skin, end sites included, or bones of a VRM animation; 0 where there is no skin.
    pub joints: usize,
    /// Vertices of all meshes, after equal ones were joined.
    pub vertices: usize,
    /// Animated tracks, each an animation channel.
    pub animated_tracks: usize,
    /// Constant tracks, now part of a node.
    pub constant_tracks: usize,
    /// Keys that were dropped because their time rounds to the same 32-bit number as the key before. Above 0 only in
    /// takes of more than 16 million frames.
    pub dropped_keys: usize,
    /// The error of the file, the largest of all animations. Absent where every key was kept unchanged.
    pub achieved: Option<Achieved>,
    /// The joints of the source that are no bones of the humanoid, and so no part of a VRM animation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Bytes of all files together.
    pub bytes: usize,
    /// What a reader of the file may be wrong about: [`Code::UnknownUnit`] where the lengths are not known to be
    /// metres.
    pub warnings: Vec<Diagnostic>,
}

/// The fraction of the largest error that the positions of bones may have: no joint shows how the bone at the end of a
/// chain is turned, and the skin around it is to keep the largest error too.
const BOUND_OF_BONES: f64 = 0.45;

/// What a document holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Content {
    /// The scene with its meshes, on the rest pose of its motion.
    Scene,
    /// The motion of a humanoid on its T-pose, and the extension that states its bones.
    VrmAnimation,
}

/// A scene as a glTF document, before it is written to files.
#[derive(Clone, Debug)]
pub struct Document {
    /// All but the animations.
    root: ::gltf::json::Root,
    animations: Vec<text::Animation>,
    bin: Vec<u8>,
    report: GltfReport,
}

impl Document {
    /// Makes the glTF document of `scene`.
    ///
    /// # Errors
    /// [`Code::Unrepresentable`](crate::Code::Unrepresentable), with the joint, where a value is not finite or a
    /// quaternion is not a rotation; [`Code::FrameTime`](crate::Code::FrameTime) where ticks per second are not above
    /// 0; [`Code::ErrorBound`](crate::Code::ErrorBound) where the largest error cannot be kept;
    /// [`Code::MissingFeature`](crate::Code::MissingFeature) where this build has no meshopt.
    pub fn new(scene: &Scene, options: &GltfOptions) -> Result<Self> {
        let mut document = build::document(scene, options, Content::Scene)?;
        document.report.warnings.extend(unit_warning(scene));
        Ok(document)
    }

    /// Makes the document of a VRM animation: `scene` as [`vrm_humanoid`](crate::retarget::vrm_humanoid()) makes it.
    pub(super) fn of_vrm_animation(scene: &Scene, options: &GltfOptions) -> Result<Self> {
        let options = GltfOptions {
            keep_constant: false,
            error_bound: options.bound().map(|bound| bound.tighter(BOUND_OF_BONES)),
            ..options.clone()
        };
        build::document(scene, &options, Content::VrmAnimation)
    }

    /// The report. [`GltfReport::bytes`] is set only by [`export`].
    pub fn report(&self) -> &GltfReport {
        &self.report
    }
}

/// Says so where the lengths of `scene` are not known to be in metres.
fn unit_warning(scene: &Scene) -> Option<Diagnostic> {
    let message = match scene.metadata.metres_per_unit {
        Some(1.0) => return None,
        Some(metres) => format!("glTF is in metres, and the scene is in units of {metres} m"),
        None => "glTF is in metres, and the unit of the scene is not stated".to_owned(),
    };
    let help = "convert the scene before: Conversion::new().apply(&mut scene)";
    Some(Diagnostic::new(Code::UnknownUnit, message).help(help))
}

/// The bytes of a `.glb` file. What there is to say about it, [`Document::report`] says.
///
/// # Errors
/// As [`Document::new`]; and [`Code::LimitExceeded`](crate::Code::LimitExceeded) beyond the 4 GiB that the container
/// can hold.
pub fn write_glb(scene: &Scene, options: &GltfOptions) -> Result<Vec<u8>> {
    Document::new(scene, options)?.to_glb()
}

/// Writes `scene` to `path`: as `.gltf` if it has that extension, otherwise as `.glb`.
///
/// After an error no file is partial, and a `.gltf` and the `.bin` beside it, which has the same name, are as before.
///
/// # Errors
/// As [`write_glb`], and [`Code::Io`](crate::Code::Io).
pub fn export(scene: &Scene, path: impl AsRef<Path>, options: &GltfOptions) -> Result<GltfReport> {
    let path = path.as_ref();
    let document = Document::new(scene, options)?;
    let is_text = path
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"));
    let bytes = match (is_text, options.buffer) {
        (false, _) => document.write_glb(path)? as usize,
        (true, BufferPlace::Embedded) => {
            let text = document.to_embedded()?;
            write_file(path, &text)?;
            text.len()
        }
        (true, BufferPlace::Beside) => {
            let bin_path = path.with_extension("bin");
            let name = bin_path.file_name().unwrap_or_default().to_string_lossy();
            let (text, bin) = document.to_text_and_bin(&name)?;
            if bin.is_empty() {
                write_file(path, &text)?;
            } else {
                write_files(&[(&bin_path, bin), (path, &text)])?;
            }
            text.len() + bin.len()
        }
    };
    Ok(GltfReport {
        bytes,
        ..document.report
    })
}
