//! Writes a scene as UsdSkel.
//!
//! | scene | USD |
//! |---|---|
//! | the scene | a `SkelRoot`, the default prim |
//! | nodes | the `joints` of one `Skeleton`: paths of identifiers |
//! | their names and kinds | `jointNames`, `mocap:kinds` |
//! | the rest pose | `restTransforms` |
//! | the bind pose of bones, or else the rest pose | `bindTransforms` |
//! | an animation | a `SkelAnimation` of the driven joints; the skeleton is bound to the first animation |
//! | keys | time samples at the ticks of all joints, in frames of the first animation; one value if no joint moves |
//! | scales | 16-bit floats, as the schema requires; a note reports inexact values |
//! | metres, up axis, frame rate | `metersPerUnit`, `upAxis`, `timeCodesPerSecond` |
//! | a name | an identifier; `displayName` has the name of the scene |
//! | a mesh with bones | a `Mesh` with its joints and weights; its `geomBindTransform` leads to the bind pose |
//! | a mesh without bones | a `Mesh` that follows the joint of its node |
//! | a morph target | a `BlendShape` of its mesh, and its weights in each animation |
//! | a material with a surface | a `UsdPreviewSurface`, with its texture in the same folder, or in the archive |
//! | points | nothing |
//! | metadata | `customLayerData.mocap`: a [`Provenance`], as JSON |

pub(crate) mod animation;
mod blend_shapes;
mod material;
mod mesh;
pub(crate) mod names;
mod skeleton;
mod text;

use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::PROVENANCE;
use mocap_scene::limits;
use mocap_scene::scene::{Scene, UpAxis};

use self::blend_shapes::Shapes;
use self::names::Names;
use self::skeleton::Skeleton;
use self::text::Text;
use super::archive;
use crate::provenance::Provenance;
use crate::written::unit_warning;
use crate::{Export, ExportFile, WriteOptions, texture};

/// The name of the default prim, and of its skeleton.
const ROOT: &str = "Character";
const SKELETON: &str = "Skeleton";

/// An output texture: its path relative to the stage, and its index in the scene.
type Image = (String, usize);

/// The files of this format.
pub(crate) fn files(scene: &Scene, options: &WriteOptions) -> Result<Export> {
    let is_archive = options.has_extension("usdz");
    let mut stage = Stage::new(scene, is_archive)?;
    stage.write()?;
    let text = stage.text.into_bytes();
    let images = stage
        .images
        .iter()
        .map(|(path, texture)| (path, &scene.textures[*texture].bytes));
    let files = match is_archive {
        true => {
            let stem = options.name.rsplit_once('.').map_or("scene", |(stem, _)| stem);
            let name = format!("{}.usda", texture::file_stem_or(stem, "scene"));
            let images = images.map(|(path, bytes)| (path.clone(), bytes.as_slice()));
            let whole: Vec<_> = std::iter::once((name, text.as_slice())).chain(images).collect();
            let bytes = archive::write(&whole).ok_or_else(too_large)?;
            vec![ExportFile::new(&options.name, bytes)]
        }
        false => {
            let images = images.map(|(path, bytes)| ExportFile::new(path, bytes.clone()));
            images.chain([ExportFile::new(&options.name, text)]).collect()
        }
    };
    Ok(Export {
        notes: stage.notes,
        warnings: Vec::from_iter(
            scene
                .metadata
                .metres_per_unit
                .is_none()
                .then(|| unit_warning(scene, "USD"))
                .flatten(),
        ),
        nodes: scene.nodes.len(),
        ..Export::of(files)
    })
}

fn too_large() -> Error {
    Diagnostic::new(
        Code::LimitExceeded,
        "the archive would be larger than 4 GiB, the limit of .usdz",
    )
    .help("write .usda, or trim the motion")
    .into()
}

/// The error for data that cannot be written, with the joint.
fn unrepresentable(joint: &str, message: impl Into<String>) -> Error {
    Diagnostic::new(Code::Unrepresentable, message.into())
        .in_joint(joint)
        .into()
}

/// Builds a stage prim by prim.
struct Stage<'a> {
    scene: &'a Scene,
    skeleton: Skeleton,
    shapes: Shapes,
    text: Text,
    /// The names of the root's children.
    names: Names,
    /// The frame rate of the layer in frames per second, from the first animation.
    rate: f64,
    /// Whether textures are in a folder of an archive, not next to the file.
    is_archive: bool,
    images: Vec<Image>,
    notes: Vec<String>,
}

impl<'a> Stage<'a> {
    fn new(scene: &'a Scene, is_archive: bool) -> Result<Self> {
        if scene.nodes.is_empty() {
            return Err(Diagnostic::new(Code::Unrepresentable, "the scene has no nodes, so it has no skeleton").into());
        }
        let rate = scene
            .animations
            .first()
            .map_or(24.0, |animation| animation.ticks_per_second);
        let rate = limits::frame_rate(Code::FrameTime, rate)?;
        let mut names = Names::default();
        names.unique(SKELETON, SKELETON);
        Ok(Self {
            scene,
            skeleton: Skeleton::new(scene)?,
            shapes: Shapes::of(scene),
            text: Text::default(),
            names,
            rate,
            is_archive,
            images: Vec::new(),
            notes: Vec::new(),
        })
    }

    fn write(&mut self) -> Result<()> {
        let materials = material::Materials::of(self.scene);
        let binds = mesh::bind(self.scene, &mut self.skeleton, &mut self.notes)?;
        let clips: Vec<String> = self
            .scene
            .animations
            .iter()
            .map(|animation| self.names.unique(&animation.name, "Motion"))
            .collect();
        self.header()?;
        self.text
            .open("def SkelRoot", ROOT, &["prepend apiSchemas = [\"SkelBindingAPI\"]"]);
        self.skeleton.write(self.scene, clips.first(), &mut self.text);
        for (index, clip) in clips.iter().enumerate() {
            self.clip(index, clip)?;
        }
        self.meshes(&binds, &materials)?;
        self.materials(&materials);
        self.text.close();
        Ok(())
    }

    fn header(&mut self) -> Result<()> {
        let metadata = &self.scene.metadata;
        let metres = metadata.metres_per_unit.unwrap_or(1.0);
        let metres = limits::positive(Code::InvalidValue, "metres per unit of the scene", metres)?;
        let up = match metadata.up.unwrap_or_default() {
            UpAxis::Y => "Y",
            UpAxis::Z => "Z",
            _ => {
                let message = "USD has +Y or +Z up, but the scene has another up axis";
                let help = "convert the scene first: Conversion::new().apply(&mut scene)";
                return Err(Diagnostic::new(Code::Unrepresentable, message).help(help).into());
            }
        };
        let provenance =
            serde_json::to_string(&Provenance::in_file(self.scene, &crate::usd::FORMAT)).unwrap_or_default();
        let ends = self
            .scene
            .animations
            .iter()
            .map(|animation| animation.duration * self.rate / animation.ticks_per_second);
        let end = ends.fold(0.0, f64::max);
        let rate = self.rate;
        self.text.line("#usda 1.0");
        self.text.line("(");
        self.text.line("    customLayerData = {");
        self.text
            .line(&format!("        string {PROVENANCE} = {}", text::quoted(&provenance)));
        self.text.line("    }");
        for (name, value) in [
            ("defaultPrim", format!("\"{ROOT}\"")),
            ("endTimeCode", end.to_string()),
            ("framesPerSecond", rate.to_string()),
            ("metersPerUnit", metres.to_string()),
            ("startTimeCode", "0".to_owned()),
            ("timeCodesPerSecond", rate.to_string()),
            ("upAxis", format!("\"{up}\"")),
        ] {
            self.text.line(&format!("    {name} = {value}"));
        }
        self.text.line(")");
        self.text.line("");
        Ok(())
    }
}
