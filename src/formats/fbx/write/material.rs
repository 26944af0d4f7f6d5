//! Writes materials as Phong materials, which every program supports, with a colour texture. Roughness and metallic
//! are stored as in Blender.
//!
//! Colours are sRGB, as in the reader. An image is embedded, or a file beside the FBX file.

use std::collections::HashMap;

use glam::{DVec3, Vec3};
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::scene::{AlphaMode, Material, Scene, Surface, Wrap};

use super::document::{Document, Id};
use super::encode::Element;
use super::names::Names;
use super::properties::Properties;
use super::{FbxReport, FbxTextures};
use crate::fbx::phong::shininess;
use crate::texture::file_stem;

/// Writes each used material and texture once.
pub(super) struct Materials<'a> {
    scene: &'a Scene,
    names: Names,
    files: Names,
    known: HashMap<usize, Id>,
    /// The textures, by image and wrap modes along u and v.
    textures: HashMap<(usize, [i32; 2]), Id>,
    stored: FbxTextures,
    /// The image files beside the FBX file: file names, and indices of the textures.
    beside: Vec<(String, usize)>,
}

impl<'a> Materials<'a> {
    pub(super) fn new(scene: &'a Scene, stored: FbxTextures) -> Self {
        Self {
            scene,
            stored,
            beside: Vec::new(),
            names: Names::default(),
            files: Names::default(),
            known: HashMap::new(),
            textures: HashMap::new(),
        }
    }

    pub(super) fn report(self, report: &mut FbxReport) {
        let is_mirrored = |material: &&Material| {
            let surface = material.surface.filter(|surface| surface.texture.is_some());
            surface.is_some_and(|surface| surface.wrap.contains(&Wrap::Mirror))
        };
        let mirrored = self.scene.materials.iter().filter(is_mirrored).count();
        if mirrored > 0 {
            let message = format!(
                "textures of {mirrored} materials have mirrored repeat, which FBX does not support: they are written with plain repeat"
            );
            let warning = Diagnostic::new(Code::IgnoredMesh, message);
            report
                .warnings
                .push(warning.help("clamp the textures, or bake the mirror image into the image"));
        }
        report.textures = self.textures.len();
        report.beside = self.beside;
    }

    /// The id of a material, by its index in the scene.
    pub(super) fn id(&mut self, index: usize, document: &mut Document<'a>) -> Id {
        if let Some(known) = self.known.get(&index) {
            return *known;
        }
        let plain = Material::default();
        let material = self.scene.materials.get(index).unwrap_or(&plain);
        let surface = material.surface.unwrap_or_default();
        let name = self.names.unique(&material.name, "Material");
        let (id, element) = document.object("Material", [&name, "Material", ""]);
        let element = element
            .child(Element::of("Version", 102))
            .child(Element::of("ShadingModel", "phong"))
            .child(Element::of("MultiLayer", 0))
            .child(colors(&surface).element());
        document.add("Material", element);
        let texture = surface.texture.filter(|texture| *texture < self.scene.textures.len());
        if let Some(texture) = texture {
            let texture = self.texture(texture, surface.wrap, document);
            document.connect_property(texture, id, "DiffuseColor");
            if surface.alpha != AlphaMode::Opaque {
                document.connect_property(texture, id, "TransparentColor");
            }
        }
        self.known.insert(index, id);
        id
    }

    /// The id of a texture with its image, by its index in the scene.
    fn texture(&mut self, index: usize, wrap: [Wrap; 2], document: &mut Document<'a>) -> Id {
        // 0 is repeat and 1 is clamp. FBX has no mirrored repeat.
        let wrap = wrap.map(|wrap| i32::from(wrap == Wrap::Clamp));
        if let Some(known) = self.textures.get(&(index, wrap)) {
            return *known;
        }
        let texture = &self.scene.textures[index];
        let extension = match texture.media_type.as_str() {
            "image/jpeg" => "jpg",
            _ => "png",
        };
        // Use the file name without folders.
        let stem = texture.name.rsplit(['/', '\\']).next().unwrap_or_default();
        let stem = stem.strip_suffix(&format!(".{extension}")).unwrap_or(stem);
        let file = format!("{}.{extension}", self.files.unique_file(&file_stem(stem), "texture"));
        let name = if texture.name.is_empty() { &file } else { &texture.name };
        let names = |element: Element<'a>, name: &'static str| {
            element
                .child(Element::of(name, file.clone()))
                .child(Element::of("RelativeFilename", file.clone()))
        };
        let (video, element) = document.object("Video", [name, "Video", "Clip"]);
        let path = Properties::new().property("Path", ["KString", "XRefUrl", ""], [file.clone().into()]);
        let element = element
            .child(Element::of("Type", "Clip"))
            .child(path.element())
            .child(Element::of("UseMipMap", 0));
        let element = names(element, "Filename");
        let element = match self.stored {
            FbxTextures::Embedded => element.child(Element::of("Content", texture.bytes.as_slice())),
            FbxTextures::Beside => element,
        };
        document.add("Video", element);
        let (id, element) = document.object("Texture", [name, "Texture", ""]);
        let [u, v] = wrap;
        let uses = Properties::new()
            .property("WrapModeU", ["enum", "", ""], [u.into()])
            .property("WrapModeV", ["enum", "", ""], [v.into()])
            .flag("UseMaterial", true)
            .flag("UseMipMap", false);
        let element = element
            .child(Element::of("Type", "TextureVideoClip"))
            .child(Element::of("Version", 202))
            .child(Element::of("TextureName", format!("{name}\0\u{1}Texture")))
            .child(uses.element())
            .child(Element::of("Media", format!("{name}\0\u{1}Video")));
        let element = names(element, "FileName")
            .child(Element::of("ModelUVTranslation", 0.0).with(0.0))
            .child(Element::of("ModelUVScaling", 1.0).with(1.0))
            .child(Element::of("Texture_Alpha_Source", "Alpha_Black"))
            .child(Element::of("Cropping", 0).with(0).with(0).with(0));
        document.add("Texture", element);
        document.connect(video, id);
        self.textures.insert((index, wrap), id);
        if self.stored == FbxTextures::Beside {
            self.beside.push((file, index));
        }
        id
    }
}

fn colors<'a>(surface: &Surface) -> Properties<'a> {
    let on_screen = |color: Vec3| DVec3::new(screen(color.x), screen(color.y), screen(color.z));
    let color = surface.base_color;
    let (emissive, screen) = (on_screen(surface.emissive), on_screen(color.truncate()));
    let alpha = f64::from(color.w).clamp(0.0, 1.0);
    let properties = Properties::new()
        .color("DiffuseColor", screen)
        .number("DiffuseFactor", 1.0)
        .color("SpecularColor", DVec3::ZERO)
        .number("SpecularFactor", 0.0)
        .number("Shininess", shininess(surface.roughness))
        .number("ReflectionFactor", f64::from(surface.metallic).clamp(0.0, 1.0))
        .color("EmissiveColor", emissive)
        .number("EmissiveFactor", 1.0);
    if alpha < 1.0 {
        properties
            .color("TransparentColor", DVec3::ONE)
            .number("TransparencyFactor", 1.0 - alpha)
            .number("Opacity", alpha)
    } else {
        properties
    }
}

/// Converts a linear value to sRGB (IEC 61966-2-1).
fn screen(value: f32) -> f64 {
    let value = if value.is_finite() {
        f64::from(value).clamp(0.0, 1.0)
    } else {
        1.0
    };
    match value <= 0.003_130_8 {
        true => 12.92 * value,
        false => 1.055 * value.powf(1.0 / 2.4) - 0.055,
    }
}
