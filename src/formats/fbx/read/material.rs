//! Reads materials: base colour, texture, the use of alpha, and the values of the surface.
//!
//! ufbx converts the materials of all programs to one model. In FBX a texture replaces a colour. Colours are sRGB, as
//! in three.js. The file of a texture is embedded, or near the FBX file. The reader ignores absolute paths from the
//! author's machine.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{AlphaMode, Material, Scene, Surface, Texture, Wrap};

use crate::Source;
use crate::fbx::matrix::matrix;
use crate::fbx::phong::roughness;
use crate::named_file::below;
use crate::texture::media_type;
use crate::warnings::Warnings;

/// The least alpha of an opaque point on a surface with holes: glTF's default `alphaCutoff`.
const CUTOFF: f32 = 0.5;

/// FBX has no mirrored repeat.
fn wrap(mode: ufbx::WrapMode) -> Wrap {
    match mode {
        ufbx::WrapMode::Clamp => Wrap::Clamp,
        ufbx::WrapMode::Repeat => Wrap::Repeat,
    }
}

/// A material of the scene, with the texture coordinates that its meshes use.
pub(super) struct Read {
    /// The index of the material in [`Scene::materials`].
    pub(super) index: usize,
    /// The name of the set of coordinates (empty for the first set), and the transform from the set to the texture. A
    /// mesh without a texture keeps the first set, because another program may add a texture.
    pub(super) coords: (String, DAffine3),
}

/// Reads each material and each texture once.
pub(super) struct Materials<'a> {
    source: &'a Source<'a>,
    known: HashMap<u32, Read>,
    /// For each index in the file's list of textures, the index of the texture in the scene, or `None` if the image
    /// cannot be read.
    textures: HashMap<u32, Option<usize>>,
    /// Whether this crate wrote the file.
    is_own: bool,
    /// Properties of materials whose textures are skipped.
    pub(super) left_out: BTreeSet<String>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(source: &'a Source<'a>, file: &ufbx::Scene) -> Self {
        Self {
            source,
            known: HashMap::new(),
            textures: HashMap::new(),
            is_own: file.metadata.creator.starts_with("mocap "),
            left_out: BTreeSet::new(),
        }
    }

    /// Reads a material of the file. If there is no material, returns a plain material.
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
        let factor = value_or_one(&material.pbr.base_factor);
        let shade = |value: f64| linear((value * factor) as f32);
        let base = match texture {
            // The texture replaces the colour.
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
            ..self.appearance(material)
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

    /// The values of a surface that are no colours. In Phong materials only Blender and this crate state them, by
    /// Blender's convention.
    fn appearance(&self, material: &ufbx::Material) -> Surface {
        let plain = Surface::default();
        let (fbx, pbr) = (&material.fbx, &material.pbr);
        let is_phong = matches!(
            material.shader_type,
            ufbx::ShaderType::FbxPhong | ufbx::ShaderType::FbxLambert
        );
        let stated = |map: &ufbx::MaterialMap| map.has_value && map.texture.is_none() && map.value_vec4.x.is_finite();
        let value = |map: &ufbx::MaterialMap, default: f32| match stated(map) {
            true => (map.value_vec4.x as f32).clamp(0.0, 1.0),
            false => default,
        };
        let (metallic, roughness) = match (is_phong, self.is_own) {
            (false, _) => (
                value(&pbr.metalness, plain.metallic),
                value(&pbr.roughness, plain.roughness),
            ),
            (true, true) if stated(&fbx.specular_exponent) => {
                let exponent = fbx.specular_exponent.value_vec4.x;
                (value(&fbx.reflection_factor, plain.metallic), roughness(exponent))
            }
            (true, _) => (plain.metallic, plain.roughness),
        };
        let (color, factor) = (&pbr.emission_color, value_or_one(&pbr.emission_factor));
        let ufbx::Vec4 { x, y, z, .. } = color.value_vec4;
        let emissive = match color.has_value && color.texture.is_none() {
            true => Vec3::from([x, y, z].map(|part| linear((part * factor) as f32))),
            false => Vec3::ZERO,
        };
        Surface {
            metallic,
            roughness,
            emissive,
            ..plain
        }
    }

    /// The index of a texture in [`Scene::textures`]. If the image cannot be read, adds a warning and returns `None`.
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
            let problem = problem.unwrap_or("is not in the file and not near it");
            let message = format!("the texture \"{name}\" {problem}; its material has only a colour");
            let help = format!("put {name} into the folder of the FBX file, or embed it");
            warnings.distinct(Diagnostic::new(Code::IgnoredMesh, message).help(help));
        }
        self.textures.insert(id, found);
        found
    }

    /// The image of a texture from a file near the FBX file: at the stated relative path, or by file name.
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

/// The opacity of a material without an opacity texture. Older materials have a transparency factor and colour. Some
/// programs write full transparency for opaque materials, so an opacity of 0 counts as opaque.
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

/// The value of a factor; 1 if the material does not state it.
fn value_or_one(map: &ufbx::MaterialMap) -> f64 {
    match map.has_value {
        true => map.value_vec4.x,
        false => 1.0,
    }
}

/// The first texture with a file in a tree of layered textures.
fn file_of(texture: &ufbx::Texture) -> Option<&ufbx::Texture> {
    texture
        .file_textures
        .first()
        .map(|file| &**file)
        .filter(|file| file.has_file)
}

/// The file name of a texture, without folders.
fn name_of(file: &ufbx::Texture) -> String {
    let names = [&file.relative_filename, &file.filename, &file.absolute_filename];
    let path = names.into_iter().find(|name| !name.is_empty());
    let path = path.map_or(&*file.element.name, |path| &**path);
    path.rsplit(['/', '\\']).next().unwrap_or(path).to_owned()
}

/// Converts a texture coordinate. The origin is the upper left corner in a scene, and the lower left corner in FBX.
pub(super) fn texture_coords(coords: ufbx::Vec2, to_texture: &DAffine3) -> Vec2 {
    let found = to_texture
        .transform_point3(DVec3::new(coords.x, coords.y, 0.0))
        .as_vec3();
    match found.is_finite() {
        true => Vec2::new(found.x, 1.0 - found.y),
        false => Vec2::ZERO,
    }
}

/// Converts an sRGB value (IEC 61966-2-1) to linear.
fn linear(value: f32) -> f32 {
    let value = if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 };
    match value <= 0.04045 {
        true => value / 12.92,
        false => ((value + 0.055) / 1.055).powf(2.4),
    }
}
