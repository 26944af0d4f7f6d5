//! Reads materials: the values of a `UsdPreviewSurface`, its colour texture, and the meaning of alpha.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3, Vec4};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::{AlphaMode, Material, SKELETON_MATERIAL, Scene, Surface, Texture, Wrap};

use super::index::Index;
use crate::Source;
use crate::named_file::below;
use crate::texture::media_type;
use crate::usd::parse::{Prim, Value};
use crate::usd::{SKELETON_MESH, archive, is_archive};
use crate::warnings::Warnings;

/// The name of the material for meshes without a material.
const PLAIN: &str = "MeshMaterial";

/// The material of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Key {
    /// The index of the material's prim.
    Prim(usize),
    /// No material, because the mesh draws the skeleton.
    DrawnSkeleton,
    None,
}

/// Reads each material and each texture once.
pub(super) struct Materials<'a> {
    source: &'a Source<'a>,
    index: &'a Index<'a>,
    /// The index in `read` of each material, by its key.
    known: HashMap<Key, usize>,
    /// Materials, each with the name of its texture coordinates.
    read: Vec<(Material, Option<String>)>,
    /// The files of the archive, if the source is an archive.
    archive: Option<HashMap<&'a [u8], archive::Entry<'a>>>,
    /// The index of each texture by file path; `None` if the texture cannot be read.
    images: HashMap<PathBuf, Option<usize>>,
    /// The texture files that were not read.
    unread: BTreeSet<String>,
    textures: Vec<Texture>,
}

impl<'a> Materials<'a> {
    pub(super) fn of(index: &'a Index<'a>, source: &'a Source<'a>) -> Self {
        Self {
            source,
            index,
            known: HashMap::new(),
            read: Vec::new(),
            archive: is_archive(source.bytes).then(|| archive::files(source.bytes).unwrap_or_default()),
            images: HashMap::new(),
            unread: BTreeSet::new(),
            textures: Vec::new(),
        }
    }

    /// The index of the material for a mesh, from the index of its prim. A mesh without a material gets the index of a
    /// plain material.
    pub(super) fn index_of(&mut self, material: Option<usize>, mesh: &Prim) -> usize {
        let index = self.index;
        let prims = &index.layer.prims;
        let own = material.filter(|prim| prims[*prim].kind == "Material");
        let key = match mesh.attributes.contains_key(SKELETON_MESH) {
            true => Key::DrawnSkeleton,
            false => own.map_or(Key::None, Key::Prim),
        };
        let place = match self.known.get(&key) {
            Some(place) => *place,
            None => {
                let read = match key {
                    Key::Prim(prim) => self.material(prim),
                    Key::DrawnSkeleton => (plain(SKELETON_MATERIAL), None),
                    Key::None => (plain(PLAIN), None),
                };
                self.read.push(read);
                self.known.insert(key, self.read.len() - 1);
                self.read.len() - 1
            }
        };
        let sides = mesh
            .attributes
            .get("doubleSided")
            .and_then(|sides| sides.value.as_ref());
        let is_two_sided = |value: &Value| {
            value.numbers.first() == Some(&1.0) || value.texts.first().is_some_and(|text| text == "true")
        };
        self.read[place].0.two_sided |= sides.is_some_and(is_two_sided);
        place
    }

    /// The name of the texture coordinates that a material uses.
    pub(super) fn coords(&self, index: usize) -> Option<&str> {
        self.read[index].1.as_deref()
    }

    /// The shader that is connected to an input of a prim.
    fn connected(&self, prim: usize, input: &str) -> Option<usize> {
        let prims = &self.index.layer.prims;
        let output = prims[prim].texts(&format!("{input}.connect")).first()?;
        let found = self.index.find(output, prim);
        found.filter(|found| prims[*found].kind == "Shader")
    }

    fn material(&mut self, prim: usize) -> (Material, Option<String>) {
        let index = self.index;
        let prims = &index.layer.prims;
        let (own, prim) = (prim, &prims[prim]);
        let material = Material {
            name: prim.display_name().unwrap_or(&prim.name).clone(),
            ..Material::default()
        };
        let Some(surface) = self.connected(own, "outputs:surface") else {
            return (material, None);
        };
        let image = self.connected(surface, "inputs:diffuseColor");
        let has_holes = self.connected(surface, "inputs:opacity").is_some();
        let coords = image.and_then(|image| self.connected(image, "inputs:st"));
        let coords = coords.and_then(|reader| prims[reader].texts("inputs:varname").first().cloned());
        let surface = &prims[surface];
        let image = image.map(|image| &prims[image]);
        let image = image.filter(|image| !image.texts("inputs:file").is_empty());
        let texture = image.and_then(|image| self.texture(&image.texts("inputs:file")[0]));
        // If the texture cannot be read, the scale is the colour.
        let color = match image {
            Some(image) => image.numbers("inputs:scale"),
            None => surface.numbers("inputs:diffuseColor"),
        };
        let part = |index: usize| match color.get(index) {
            Some(part) if part.is_finite() => *part as f32,
            _ => 1.0,
        };
        let alpha = surface
            .numbers("inputs:opacity")
            .first()
            .filter(|alpha| alpha.is_finite());
        let alpha = alpha.map_or(part(3), |alpha| *alpha as f32);
        let least = surface.numbers("inputs:opacityThreshold").first().copied();
        let has_holes = has_holes && texture.is_some();
        let fraction = |name: &str, default: f32| match surface.numbers(name).first() {
            Some(stated) if stated.is_finite() => (*stated as f32).clamp(0.0, 1.0),
            _ => default,
        };
        let emissive = surface.numbers("inputs:emissiveColor");
        let emissive = match emissive {
            [red, green, blue, ..] if emissive.iter().all(|part| part.is_finite()) => {
                DVec3::new(*red, *green, *blue).as_vec3()
            }
            _ => Vec3::ZERO,
        };
        let wrap = |name: &str| match image.and_then(|image| image.texts(name).first()).map(String::as_str) {
            Some("mirror") => Wrap::Mirror,
            Some("clamp" | "black") => Wrap::Clamp,
            _ => Wrap::Repeat,
        };
        let surface = Surface {
            base_color: Vec4::new(part(0), part(1), part(2), alpha),
            texture,
            alpha: match least {
                Some(least) if least > 0.0 => AlphaMode::Mask(least as f32),
                _ if has_holes || alpha < 1.0 => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            wrap: ["inputs:wrapS", "inputs:wrapT"].map(wrap),
            // The defaults of the shader.
            metallic: fraction("inputs:metallic", 0.0),
            roughness: fraction("inputs:roughness", 0.5),
            emissive,
        };
        let material = Material {
            surface: Some(surface),
            ..material
        };
        (material, coords)
    }

    /// The index of the texture in a file: in the archive, at the stated path, or by its name in the folder of the
    /// source.
    fn texture(&mut self, file: &str) -> Option<usize> {
        let stated = below(file.replace('\\', "/"));
        let alone = Path::new(file).file_name().filter(|_| self.archive.is_none());
        let names = stated.into_iter().chain(alone.and_then(below));
        let found = names.filter_map(|name| self.image(name)).next();
        if found.is_none() {
            self.unread.insert(file.to_owned());
        }
        found
    }

    /// The index of the texture at a path, which is read once.
    fn image(&mut self, path: PathBuf) -> Option<usize> {
        if let Some(known) = self.images.get(&path) {
            return *known;
        }
        let found = self.open(&path).and_then(|bytes| {
            let media_type = media_type(&bytes)?.to_owned();
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            self.textures.push(Texture {
                name,
                media_type,
                bytes,
            });
            Some(self.textures.len() - 1)
        });
        self.images.insert(path, found);
        found
    }

    fn open(&self, path: &Path) -> Option<Vec<u8>> {
        let Some(archive) = &self.archive else {
            return (self.source.open)(&self.source.name.with_file_name(path)).ok();
        };
        let name = path.to_string_lossy().replace('\\', "/");
        let bytes = archive.get(name.as_bytes())?.bytes().ok()?;
        // Entries of a broken archive may share bytes, so a small file could give many textures.
        let read: usize = self.textures.iter().map(|texture| texture.bytes.len()).sum();
        (read + bytes.len() <= self.source.bytes.len()).then(|| bytes.to_vec())
    }

    /// Adds the materials and textures to the scene, and counts the textures that were not read.
    pub(super) fn give(self, scene: &mut Scene, warnings: &mut Warnings) {
        for name in &self.unread {
            let message = format!("the texture \"{name}\" is missing, or is not PNG, JPEG or WebP");
            let help = "put the texture at the stated path, or export a .usdz";
            warnings.distinct(Diagnostic::new(Code::IgnoredMesh, message).help(help));
        }
        let prims = || self.index.layer.prims.iter();
        let materials = prims().filter(|prim| prim.kind == "Material").count();
        let is_own = |key: &&Key| matches!(key, Key::Prim(_));
        let read = self.known.keys().filter(is_own).count();
        scene.lose(DataKind::Materials, materials.saturating_sub(read));
        let is_image = |prim: &&Prim| prim.texts("info:id").iter().any(|id| id == "UsdUVTexture");
        let images = prims().filter(is_image).count();
        let shown = self.read.iter().filter(|(material, _)| has_texture(material)).count();
        scene.lose(DataKind::Textures, images.saturating_sub(shown));
        scene
            .materials
            .extend(self.read.into_iter().map(|(material, _)| material));
        scene.textures.extend(self.textures);
    }
}

fn has_texture(material: &Material) -> bool {
    material.surface.is_some_and(|surface| surface.texture.is_some())
}

/// A material without a colour.
fn plain(name: &str) -> Material {
    Material {
        name: name.to_owned(),
        ..Material::default()
    }
}
