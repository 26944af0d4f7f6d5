//! Materials: the base colour, its texture, and what alpha means.
//!
//! ufbx brings the materials of all programs to one model. In FBX a texture replaces a colour. Colours are
//! those of a screen (sRGB), as three.js has them. The file of a texture is embedded, or near the FBX file; its folder
//! on the machine of its maker is not looked for.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3, Vec2, Vec4};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{AlphaMode, Material, Scene, Surface, Texture, Wrap};

use crate::Source;
use crate::fbx::matrix::matrix;
use crate::named_file::below;
use crate::texture::media_type;
use crate::warnings::Warnings;

/// The alpha, a fraction, from which on a surface with holes is there: glTF's default.
const CUTOFF: f32 = 0.5;

/// FBX has no mirror.
fn wrap(mode: ufbx::WrapMode) -> Wrap {
    match mode {
        ufbx::WrapMode::Clamp => Wrap::Clamp,
        ufbx::WrapMode::Repeat => Wrap::Repeat,
    }
}

/// A material of the scene, and how its meshes find their texture coordinates.
pub(super) struct Read {
    /// Its index in [`Scene::materials`].
    pub(super) index: usize,
    /// The name of the set of coordinates, empty for the first one, and the transform from there to the texture. The
    /// first set is kept of a mesh without a texture: another program may draw one.
    pub(super) coords: (String, DAffine3),
}

/// Reads each material and each texture once.
pub(super) struct Materials<'a> {
    source: &'a Source<'a>,
    known: HashMap<u32, Read>,
    /// The textures of the scene by the index of their files in the file's list; none for one that cannot be read.
    textures: HashMap<u32, Option<usize>>,
    /// Properties of materials whose textures are left out.
    pub(super) left_out: BTreeSet<String>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(source: &'a Source<'a>) -> Self {
        Self {
            source,
            known: HashMap::new(),
            textures: HashMap::new(),
            left_out: BTreeSet::new(),
        }
    }

    /// A material of the file; without one, a plain one.
    pub(super) fn read(
        &mut self,
        material: Option<&ufbx::Material>,
        scene: &mut Scene,
        warnings: &mut Warnings,
    ) -> &Read {
        let id = material.map_or(u32::MAX, |material| material.element.element_id);
        if !self.known.contains_key(&id) {
            let read = match material {
                Some(material) => self.add(material, scene, warnings),
                None => {
                    scene.materials.push(Material {
                        name: "MeshMaterial".to_owned(),
                        two_sided: true,
                        surface: None,
                    });
                    Read {
                        index: scene.materials.len() - 1,
                        coords: (String::new(), DAffine3::IDENTITY),
                    }
                }
            };
            self.known.insert(id, read);
        }
        &self.known[&id]
    }

    fn add(&mut self, material: &ufbx::Material, scene: &mut Scene, warnings: &mut Warnings) -> Read {
        let color = &material.pbr.base_color;
        let connected = color.texture.as_deref().filter(|_| color.texture_enabled);
        let file = connected.and_then(file_of);
        let texture = file.and_then(|file| self.texture(file, scene, warnings));
        let maps = [
            &material.pbr.opacity,
            &material.fbx.transparency_factor,
            &material.fbx.transparency_color,
        ];
        let mut connected_alpha = maps.into_iter().filter(|map| map.texture_enabled);
        let holes = connected_alpha.find_map(|map| map.texture.as_deref());
        let is_same = |other: &ufbx::Texture| file_of(other).map(name_of) == file.map(name_of);
        let has_holes = texture.is_some() && holes.is_some_and(is_same);
        for used in &material.textures {
            let is_color = connected.is_some_and(|color| color.element.element_id == used.texture.element.element_id);
            let is_alpha =
                has_holes && holes.is_some_and(|own| own.element.element_id == used.texture.element.element_id);
            if !is_color && !is_alpha {
                self.left_out.insert(used.material_prop.to_string());
            }
        }
        let stated = material.pbr.base_factor.value_vec4.x;
        let factor = if material.pbr.base_factor.has_value {
            stated
        } else {
            1.0
        };
        let shade = |value: f64| linear((value * factor) as f32);
        let base = match texture {
            // It replaces the colour.
            Some(_) => Vec4::ONE,
            None => {
                let ufbx::Vec4 { x, y, z, .. } = color.value_vec4;
                Vec4::new(shade(x), shade(y), shade(z), 1.0)
            }
        };
        let alpha = if holes.is_none() { opacity_of(material) } else { 1.0 };
        let surface = Surface {
            base_color: base.with_w(alpha),
            texture,
            alpha: match (has_holes, alpha < 1.0) {
                (true, _) => AlphaMode::Mask(CUTOFF),
                (false, true) => AlphaMode::Blend,
                (false, false) => AlphaMode::Opaque,
            },
            wrap: file.map_or([Wrap::Repeat; 2], |file| [file.wrap_u, file.wrap_v].map(wrap)),
        };
        scene.materials.push(Material {
            name: material.element.name.to_string(),
            two_sided: true,
            surface: Some(surface),
        });
        let file = file.filter(|_| texture.is_some());
        let coords = file.map_or((String::new(), DAffine3::IDENTITY), |file| {
            let to_texture = match file.has_uv_transform {
                true => DAffine3::from_mat4(matrix(&file.uv_to_texture)),
                false => DAffine3::IDENTITY,
            };
            (file.uv_set.to_string(), to_texture)
        });
        Read {
            index: scene.materials.len() - 1,
            coords,
        }
    }

    /// The index of a texture in [`Scene::textures`]; none, with a warning, where it cannot be read.
    fn texture(&mut self, file: &ufbx::Texture, scene: &mut Scene, warnings: &mut Warnings) -> Option<usize> {
        let id = file.file_index;
        if let Some(known) = self.textures.get(&id) {
            return *known;
        }
        let (name, mut problem) = (name_of(file), None);
        let embedded = [Some(&file.content), file.video.as_deref().map(|video| &video.content)];
        let embedded = embedded.into_iter().flatten().find(|content| !content.is_empty());
        let bytes = match embedded {
            Some(content) => Some(content.to_vec()),
            None => self.neighbour(file),
        };
        let found = bytes.and_then(|bytes| {
            match media_type(&bytes) {
                Some(media_type @ ("image/png" | "image/jpeg")) => {
                    scene.textures.push(Texture {
                        name: file.element.name.to_string(),
                        media_type: media_type.to_owned(),
                        bytes,
                    });
                    return Some(scene.textures.len() - 1);
                }
                _ => problem = Some("is neither PNG nor JPEG, which are the formats of glTF"),
            }
            None
        });
        if found.is_none() {
            let problem = problem.unwrap_or("is not in the file, and not beside it");
            let message = format!("the texture \"{name}\" {problem}; the colour of its material is without it");
            let help = format!("put {name} beside the FBX file, or into a folder of it, or embed it");
            warnings.distinct(Diagnostic::new(Code::IgnoredMesh, message).help(help));
        }
        self.textures.insert(id, found);
        found
    }

    /// The image of a texture from a file near this one: where the texture says, or by its name alone.
    fn neighbour(&self, file: &ufbx::Texture) -> Option<Vec<u8>> {
        let here = self.source.name;
        let name = PathBuf::from(name_of(file));
        let stated = PathBuf::from(file.relative_filename.replace('\\', "/"));
        let media = here
            .file_stem()
            .map(|stem| PathBuf::from(stem).with_extension("fbm").join(&name));
        let usual = ["textures", "Textures"].map(|folder| Path::new(folder).join(&name));
        let candidates = [stated, name].into_iter().chain(media).chain(usual);
        candidates
            .filter_map(below)
            .find_map(|name| (self.source.open)(&here.with_file_name(name)).ok())
    }
}

/// The opacity of a material without a texture for it. Older materials have a transparency and its colour, which some
/// programs write of what is opaque too: nothing is quite invisible.
fn opacity_of(material: &ufbx::Material) -> f32 {
    let ufbx::MaterialFbxMaps {
        transparency_factor: factor,
        transparency_color: color,
        ..
    } = &material.fbx;
    let stated = &material.pbr.opacity;
    let ufbx::Vec4 { x, y, z, .. } = color.value_vec4;
    let value = match (stated.has_value, factor.has_value && color.has_value) {
        (true, _) => stated.value_vec4.x,
        (false, true) => 1.0 - factor.value_vec4.x * (x + y + z) / 3.0,
        (false, false) => 1.0,
    };
    let is_seen = value.is_finite() && value > 0.0 && value < 1.0;
    if is_seen { value as f32 } else { 1.0 }
}

/// The texture of a file in a tree of layers.
fn file_of(texture: &ufbx::Texture) -> Option<&ufbx::Texture> {
    texture
        .file_textures
        .first()
        .map(|file| &**file)
        .filter(|file| file.has_file)
}

/// The name of the file of a texture, without folders.
fn name_of(file: &ufbx::Texture) -> String {
    let names = [&file.relative_filename, &file.filename, &file.absolute_filename];
    let path = names.into_iter().find(|name| !name.is_empty());
    let path = path.map_or(&*file.element.name, |path| &**path);
    path.rsplit(['/', '\\']).next().unwrap_or(path).to_owned()
}

/// A texture coordinate, whose origin is above in a scene and below in FBX.
pub(super) fn texture_coords(coords: ufbx::Vec2, to_texture: &DAffine3) -> Vec2 {
    let found = to_texture
        .transform_point3(DVec3::new(coords.x, coords.y, 0.0))
        .as_vec3();
    match found.is_finite() {
        true => Vec2::new(found.x, 1.0 - found.y),
        false => Vec2::ZERO,
    }
}

/// The fraction of light that a number for a screen (sRGB, IEC 61966-2-1) stands for.
fn linear(value: f32) -> f32 {
    let value = if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 };
    match value <= 0.04045 {
        true => value / 12.92,
        false => ((value + 0.055) / 1.055).powf(2.4),
    }
}
