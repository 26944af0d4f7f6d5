//! Writes a scene as binary FBX.
//!
//! | scene | FBX |
//! |---|---|
//! | a joint, an end site | a model `LimbNode` with its attribute |
//! | a group | a model `Null`; `LimbNode` between bones or where a mesh is bound to it; no model for the root node |
//! | a root joint | a child of a `Null`; see [`FbxRoot`] |
//! | the name of a node | the name, made unique; a changed name has its original in the property `mocap_source_name` |
//! | the rotation of the rest pose | `Lcl Rotation` or `PreRotation`; see [`FbxRest`] |
//! | [`Node::rotation_order`](mocap_scene::scene::Node::rotation_order) | `RotationOrder`; without one, FBX's XYZ |
//! | the rest pose, or the bind pose of bones | a `BindPose` |
//! | an animation | an `AnimationStack` with one `AnimationLayer` |
//! | a track | an `AnimationCurve` for each axis that leaves the rest pose, with linear keys |
//! | [`FbxOptions::error_bound`] | within the bound, keys are dropped |
//! | rotations | angles in degrees that continue past 180, so that no curve jumps |
//! | ticks per second | `TimeMode`, or `CustomFrameRate` |
//! | metres and the up axis | [`FbxOptions::metres_per_unit`] and [`FbxOptions::up`], stated in `GlobalSettings` |
//! | meshes of one node with the same name and bones | a mesh with several materials |
//! | [`Mesh::bones`](mocap_scene::scene::Mesh::bones) | a skin with a cluster for each bone, and every weight |
//! | a mesh without bones | a mesh below its node |
//! | [`Mesh::morph_targets`](mocap_scene::scene::Mesh::morph_targets) | blend shapes, with curves of `DeformPercent` |
//! | a material with a surface | a Phong material with its colour, opacity and texture |
//! | the image of a texture | embedded, or a separate file; see [`FbxOptions::textures`] |
//! | points | not written |
//! | metadata | the property `mocap` of the scene: a [`Provenance`], as JSON |
//!
//! Equal scenes give equal bytes, so files have no time of creation.

mod animation;
mod blend_shapes;
mod curves;
mod document;
mod encode;
mod kept;
mod material;
mod mesh;
mod names;
mod properties;
mod skeleton;
mod space;
pub(crate) mod time;

use std::fmt;

use glam::DMat4;
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::limits;
use mocap_scene::report::counted;
use mocap_scene::scene::{Scene, UpAxis};
use serde::Serialize;

use self::document::{Document, Settings};
use self::names::Names;
use self::space::Space;
use self::time::Rate;
pub(super) use super::{FbxOptions, FbxRest, FbxRoot, FbxTextures, FbxVersion};
use crate::provenance::Provenance;
use crate::report::{Deviation, NodeRename};
use crate::written::millimetres;
use crate::{Export, ExportFile, WriteOptions};

/// The name of the writing program in the file.
const CREATOR: &str = concat!("mocap ", env!("CARGO_PKG_VERSION"));

impl FbxVersion {
    fn number(self) -> u32 {
        match self {
            Self::V7400 => 7400,
            Self::V7500 => 7500,
        }
    }
}

/// The report of the FBX writer.
///
/// [`FbxOptions::write`](crate::fbx::FbxOptions::write) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FbxReport {
    /// The renamed nodes: the index in the scene, the name in the scene and the name in the file.
    pub renamed: Vec<(usize, String, String)>,
    /// The number of bones, including end sites.
    pub bones: usize,
    /// The number of vertices of all meshes.
    pub vertices: usize,
    /// The number of textures.
    pub textures: usize,
    /// The image files that belong beside the FBX file: the file name, and the index of the texture in
    /// [`Scene::textures`].
    pub beside: Vec<(String, usize)>,
    /// The number of curves of all clips.
    pub curves: usize,
    /// The number of keys of all curves.
    pub keys: usize,
    /// The largest error of the file over all clips; `None` if every key was written. `achieved.keys` counts the keys
    /// of the scene's tracks.
    pub achieved: Option<Deviation>,
    /// The size of the file, in bytes.
    pub bytes: usize,
    /// Whether the file is the original file of the scene with other clips.
    #[serde(skip)]
    #[doc(hidden)]
    pub is_kept: bool,
    /// Warnings: [`Code::UnknownUnit`] if the unit of the scene is unknown, so a reader may assume a wrong size.
    pub warnings: Vec<Diagnostic>,
}

impl fmt::Display for FbxReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (bones, vertices) = (counted(self.bones, "bone"), self.vertices);
        let (curves, keys, bytes) = (self.curves, self.keys, counted(self.bytes, "byte"));
        write!(
            f,
            "{bones}, vertices: {vertices}, curves: {curves}, keys: {keys}, {bytes}"
        )
    }
}

impl FbxOptions {
    /// Writes an FBX file. Returns its bytes and a report.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Conversion;
    /// use mocap::fbx::FbxOptions;
    ///
    /// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// Conversion::new().apply(&mut scene)?;
    /// let (bytes, report) = FbxOptions::default().write(&scene)?;
    /// assert!(bytes.starts_with(b"Kaydara FBX Binary"));
    /// assert_eq!(report.bones, scene.nodes.len());
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// - [`Code::Unrepresentable`], with the joint, if a value is not finite or a quaternion is not a rotation, and if
    ///   the scene has no nodes
    /// - [`Code::FrameTime`] if ticks per second are not above 0
    /// - [`Code::InvalidValue`] if a unit or the largest error is not above 0
    /// - [`Code::ErrorBound`] if single precision cannot keep the largest error
    /// - [`Code::Unrepresentable`] if an error bound is set and a joint with children changes its scale
    /// - [`Code::LimitExceeded`] if the file is too large for its version
    pub fn write(&self, scene: &Scene) -> Result<(Vec<u8>, FbxReport)> {
        if let Some(original) = &scene.metadata.fbx {
            let kept = self.keeps_file().then(|| kept::write(scene, original, self));
            let reason = match kept {
                Some(Ok(written)) => return Ok(written),
                Some(Err(reason)) => Some(reason),
                None => None,
            };
            let mut anew = scene.clone();
            anew.metadata.fbx = None;
            let (bytes, mut report) = self.write(&anew)?;
            report.warnings.extend(reason.map(|reason| written_anew(&reason)));
            return Ok((bytes, report));
        }
        let mut report = FbxReport::default();
        if scene.nodes.is_empty() {
            return Err(Diagnostic::new(Code::Unrepresentable, "the scene has no nodes, so it has no skeleton").into());
        }
        let unit = limits::positive(Code::InvalidValue, "metres per unit", self.metres_per_unit)?;
        let own_unit = scene.metadata.metres_per_unit.unwrap_or(1.0);
        let own_unit = limits::positive(Code::InvalidValue, "metres per unit of the scene", own_unit)?;
        let space = Space::new(own_unit / unit, scene.metadata.up.unwrap_or_default(), self.up);
        if let Some(bound) = &self.error_bound {
            limits::positive(Code::InvalidValue, "the largest error", bound.max_error)?;
        }
        let mut document = Document::new();
        let mut names = Names::default();
        let bones = mesh::bound_nodes(scene);
        let placed = skeleton::write(scene, &space, self, &bones, &mut names, &mut document, &mut report)?;
        let binds = mesh::binds(scene, &space, &placed);
        let mut names_of_clips = Names::default();
        let clips = animation::write(
            scene,
            &space,
            &placed,
            self,
            &mut names_of_clips,
            &mut document,
            &mut report,
        )?;
        let beside = skeleton::beside_the_tails(scene, &placed, &clips.moving);
        // The transform of a node in the bind pose.
        let bound = |index: usize, mut bind: DMat4| {
            bind.w_axis += beside[index].extend(0.0);
            bind
        };
        let meshes = mesh::write(
            scene,
            &space,
            (&placed, &bound),
            self.textures,
            &mut names,
            &mut document,
            &mut report,
        )?;
        blend_shapes::write_curves(&meshes.targets, &clips.layers, &mut document, &mut report);
        let nodes = placed
            .iter()
            .enumerate()
            .filter(|(_, at_rest)| at_rest.id != document::SCENE_ROOT);
        let nodes = nodes.map(|(index, at_rest)| {
            let bind = binds[index].unwrap_or(at_rest.world);
            (at_rest.id, bound(index, bind))
        });
        let pose: Vec<_> = nodes.chain(meshes.skinned).collect();
        skeleton::bind_pose(&mut document, &pose);
        let clips = clips.ends;
        let provenance = Provenance {
            up: Some(self.up).filter(|up| *up != UpAxis::Y),
            ..Provenance::in_file(scene, &crate::fbx::FORMAT)
        };
        let settings = Settings {
            version: self.version,
            up: self.up,
            metres_per_unit: unit,
            rate: Rate::of(scene, self)?,
            end: clips.iter().map(|clip| clip.1).max().unwrap_or(0),
            clips,
            provenance: serde_json::to_string(&provenance).unwrap_or_default(),
        };
        let bytes = encode::file(document.sections(&settings), self.version, CREATOR)?;
        report.bytes = bytes.len();
        report.warnings.extend(unit_warning(scene));
        Ok((bytes, report))
    }
}

impl FbxOptions {
    /// Whether the writer may keep the original file: no option asks for another unit, axis, rest pose or version.
    fn keeps_file(&self) -> bool {
        let usual = Self {
            error_bound: self.error_bound.clone(),
            whole_rate: self.whole_rate,
            ..Self::default()
        };
        *self == usual
    }
}

/// Warns that the output lacks data that a scene cannot store.
fn written_anew(reason: &str) -> Diagnostic {
    let message = format!(
        "the file is written from the scene, because {reason}: polygons become triangles, and data that a scene cannot store is dropped"
    );
    Diagnostic::new(Code::NotCarriedOver, message)
}

/// Writes the files of the format.
pub(super) fn files(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    let options_of_fbx = FbxOptions {
        error_bound: options.bound(),
        ..options.fbx.clone()
    };
    let (bytes, report) = options_of_fbx.write(scene)?;
    // Losses that the ledger does not count because a kept original file has the data.
    let is_anew = scene.metadata.fbx.is_some() && !report.is_kept;
    let losses = scene.metadata.lost.iter().filter(|_| is_anew).copied();
    let images = report.beside.iter();
    let images = images.map(|(name, texture)| ExportFile::new(name, scene.textures[*texture].bytes.clone()));
    let main = ExportFile::new(&options.name, bytes);
    let renamed = report.renamed.into_iter();
    Ok(Export {
        notes: Vec::from_iter(report.achieved.as_ref().map(|achieved| {
            let most = millimetres(achieved.max_error);
            format!(
                "{} keys in {} curves; error {most} mm at most",
                report.keys, report.curves
            )
        })),
        warnings: report.warnings,
        losses: losses.collect(),
        renamed: renamed
            .map(|(node, from, to)| NodeRename {
                node,
                from,
                to,
                is_asked_for: false,
            })
            .collect(),
        error: report.achieved,
        nodes: scene.nodes.len(),
        ..Export::of(images.chain([main]).collect())
    })
}

/// Warns if the unit of `scene` is unknown.
fn unit_warning(scene: &Scene) -> Option<Diagnostic> {
    scene.metadata.metres_per_unit.is_none().then(|| {
        let message = "an FBX file states its unit, but the unit of the scene is unknown: mocap assumed metres";
        let help = "convert the scene first: Conversion::new().apply(&mut scene)";
        Diagnostic::new(Code::UnknownUnit, message).help(help)
    })
}

fn unrepresentable(node: &str, message: String) -> Error {
    Diagnostic::new(Code::Unrepresentable, message).in_joint(node).into()
}
