//! Reads materials and their colour textures. Other textures of a material are not read.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::{Mat3, Vec2, Vec3, Vec4};
use mocap_scene::scene::{AlphaMode, Material, Surface, Texture, Wrap};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::super::invalid::{invalid, json_words, missing};
use super::Buffers;
use crate::Failure;
use crate::texture::media_type;

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct MaterialJson {
    name: String,
    double_sided: bool,
    alpha_mode: Option<String>,
    alpha_cutoff: Option<f32>,
    emissive_factor: Vec3,
    emissive_texture: Option<IgnoredAny>,
    pbr_metallic_roughness: Pbr,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Pbr {
    base_color_factor: Option<[f32; 4]>,
    base_color_texture: Option<TextureInfo>,
    metallic_factor: Option<f32>,
    roughness_factor: Option<f32>,
    metallic_roughness_texture: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureInfo {
    index: usize,
    #[serde(default)]
    tex_coord: usize,
    #[serde(default)]
    extensions: InfoExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct InfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TextureTransform>,
}

/// The extension `KHR_texture_transform`.
#[derive(Clone, Copy, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct TextureTransform {
    offset: [f32; 2],
    rotation: f32,
    scale: [f32; 2],
    tex_coord: Option<usize>,
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self {
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
            tex_coord: None,
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct TextureJson {
    source: Option<usize>,
    sampler: Option<usize>,
    extensions: TextureExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct SamplerJson {
    wrap_s: u32,
    wrap_t: u32,
}

/// The wrap mode for glTF's OpenGL number. Unknown numbers mean repeat, the default.
fn wrap(number: u32) -> Wrap {
    match number {
        33_071 => Wrap::Clamp,
        33_648 => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    webp: Option<Source>,
}

#[derive(Deserialize)]
struct Source {
    source: usize,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct ImageJson {
    name: String,
    uri: Option<String>,
    mime_type: Option<String>,
    buffer_view: Option<usize>,
}

/// A material, and the texture coordinates that its meshes use.
pub(super) struct Read {
    pub(super) material: Material,
    /// The number of the texture coordinate set.
    pub(super) coords: usize,
    /// The transform from the texture coordinates of the mesh to the coordinates in the image.
    pub(super) to_texture: Mat3,
}

/// A factor of a material. The default of glTF is 1.
fn fraction(stated: Option<f32>) -> f32 {
    stated
        .filter(|stated| stated.is_finite())
        .map_or(1.0, |stated| stated.clamp(0.0, 1.0))
}

/// The lists of materials, textures and images in the file.
pub(super) struct Lists<'a> {
    pub(super) materials: &'a [Value],
    pub(super) textures: &'a [Value],
    pub(super) images: &'a [Value],
    pub(super) samplers: &'a [Value],
}

/// Reads materials, and each image once.
#[derive(Default)]
pub(super) struct Images {
    pub(super) textures: Vec<Texture>,
    /// The index in `textures` of each image of the file.
    known: HashMap<usize, usize>,
}

impl Images {
    /// Reads a material. A texture that cannot be read is skipped, and the reason is returned.
    pub(super) fn material(
        &mut self,
        lists: &Lists<'_>,
        index: usize,
        buffers: &mut Buffers<'_>,
    ) -> Result<(Read, Option<Failure>), Failure> {
        let json: MaterialJson = item(lists.materials, "materials", "material", index)?;
        let pbr = json.pbr_metallic_roughness;
        let color = pbr.base_color_factor.map_or(Vec4::ONE, Vec4::from);
        let mut surface = Surface {
            base_color: if color.is_finite() {
                color.clamp(Vec4::ZERO, Vec4::ONE)
            } else {
                Vec4::ONE
            },
            texture: None,
            alpha: match json.alpha_mode.as_deref() {
                Some("MASK") => AlphaMode::Mask(json.alpha_cutoff.unwrap_or(0.5)),
                Some("BLEND") => AlphaMode::Blend,
                _ => AlphaMode::Opaque,
            },
            emissive: match json.emissive_texture {
                None if json.emissive_factor.is_finite() => json.emissive_factor.clamp(Vec3::ZERO, Vec3::ONE),
                _ => Vec3::ZERO,
            },
            ..Surface::default()
        };
        // If the material has a texture for these factors, the factors mean nothing without the texture. The texture is
        // not read.
        if pbr.metallic_roughness_texture.is_none() {
            surface.metallic = fraction(pbr.metallic_factor);
            surface.roughness = fraction(pbr.roughness_factor);
        }
        let (mut coords, mut to_texture, mut fault) = (0, Mat3::IDENTITY, None);
        if let Some(info) = pbr.base_color_texture {
            match self.texture(lists, info.index, buffers) {
                Ok((texture, wrap)) => (surface.texture, surface.wrap) = (Some(texture), wrap),
                Err(error) => fault = Some(error),
            }
            let transform = info.extensions.transform.unwrap_or_default();
            coords = transform.tex_coord.unwrap_or(info.tex_coord);
            let [offset, scale] = [transform.offset, transform.scale].map(Vec2::from);
            // The extension's rotation is counter-clockwise if v points down.
            let matrix = Mat3::from_translation(offset)
                * Mat3::from_angle(-transform.rotation)
                * Mat3::from_scale(if scale == Vec2::ZERO { Vec2::ONE } else { scale });
            if matrix.is_finite() {
                to_texture = matrix;
            }
        }
        let material = Material {
            name: json.name,
            two_sided: json.double_sided,
            surface: Some(surface),
        };
        let read = Read {
            material,
            coords,
            to_texture,
        };
        Ok((read, fault))
    }

    /// The index of a texture's image in `textures`, and its wrap modes.
    fn texture(
        &mut self,
        lists: &Lists<'_>,
        index: usize,
        buffers: &mut Buffers<'_>,
    ) -> Result<(usize, [Wrap; 2]), Failure> {
        let json: TextureJson = item(lists.textures, "textures", "texture", index)?;
        let sampler = json.sampler.and_then(|sampler| lists.samplers.get(sampler));
        let sampler = sampler.and_then(|sampler| SamplerJson::deserialize(sampler).ok());
        let sampler = sampler.unwrap_or_default();
        let wrap = [wrap(sampler.wrap_s), wrap(sampler.wrap_t)];
        let image = json.source.or(json.extensions.webp.map(|webp| webp.source));
        let image = image.ok_or_else(|| invalid(format!("/textures/{index}"), "the texture has no image"))?;
        if let Some(&known) = self.known.get(&image) {
            return Ok((known, wrap));
        }
        let json: ImageJson = item(lists.images, "images", "image", image)?;
        let pointer = format!("/images/{image}");
        let bytes = match (&json.uri, json.buffer_view) {
            (Some(uri), _) => buffers.file(uri, &pointer)?,
            (None, Some(view)) => Cow::Owned(buffers.view(view)?.to_vec()),
            (None, None) => return Err(invalid(pointer, "the image has neither a uri nor a buffer view").into()),
        };
        let media_type = media_type(&bytes).or(json.mime_type.as_deref());
        self.textures.push(Texture {
            name: json.name,
            media_type: media_type.unwrap_or("application/octet-stream").to_owned(),
            bytes: bytes.into_owned(),
        });
        self.known.insert(image, self.textures.len() - 1);
        Ok((self.textures.len() - 1, wrap))
    }
}

/// An item of a list of the file.
pub(super) fn item<T: serde::de::DeserializeOwned>(
    list: &[Value],
    section: &str,
    what: &str,
    index: usize,
) -> Result<T, Failure> {
    let pointer = format!("/{section}/{index}");
    let value = list
        .get(index)
        .ok_or_else(|| missing(&*pointer, what, index, list.len()))?;
    T::deserialize(value).map_err(|error| {
        let message = format!("the {what} cannot be read: {}", json_words(&error));
        Box::new(invalid(pointer, message))
    })
}
