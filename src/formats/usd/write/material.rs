//! Writes materials: the preview surface that every USD renderer supports, with a colour texture.
//!
//! Colours are linear, as in a scene. The bytes of an image are in screen colours (sRGB).

use glam::Vec3;
use mocap_scene::scene::{AlphaMode, Material, Scene, Surface};

use super::names::Names;
use super::text;
use super::{ROOT, Stage};
use crate::texture::file_stem_or;

/// The name of the scope that contains all materials.
const SCOPE: &str = "Materials";

/// The name of the folder of images in an archive.
const FOLDER: &str = "textures";

/// The identifiers of the used materials with a surface.
pub(super) struct Materials(Vec<Option<String>>);

impl Materials {
    pub(super) fn of(scene: &Scene) -> Self {
        let mut names = Names::default();
        let is_used = |index: usize| scene.meshes.iter().any(|mesh| mesh.material_index == index);
        let name = |(index, material): (usize, &Material)| {
            (material.surface.is_some() && is_used(index)).then(|| names.unique(&material.name, "Material"))
        };
        Self(scene.materials.iter().enumerate().map(name).collect())
    }

    /// The path of a material.
    pub(super) fn path(&self, index: usize) -> Option<String> {
        let name = self.0.get(index)?.as_ref()?;
        Some(format!("/{ROOT}/{SCOPE}/{name}"))
    }
}

impl Stage<'_> {
    pub(super) fn materials(&mut self, materials: &Materials) {
        if materials.0.iter().all(Option::is_none) {
            return;
        }
        self.text.open("def Scope", SCOPE, &[]);
        for (index, name) in materials.0.iter().enumerate() {
            let material = &self.scene.materials[index];
            if let (Some(name), Some(surface)) = (name, material.surface) {
                self.material(&material.name, name, &surface);
            }
        }
        self.text.close();
    }

    fn material(&mut self, own: &str, name: &str, surface: &Surface) {
        let path = format!("/{ROOT}/{SCOPE}/{name}");
        let display = text::display_name(own, name).filter(|_| !own.is_empty());
        let metadata: Vec<&str> = display.as_deref().into_iter().collect();
        let image = surface.texture.and_then(|texture| self.image(texture));
        let color = surface.base_color;
        let out = &mut self.text;
        out.open("def Material", name, &metadata);
        out.line(&format!(
            "token outputs:surface.connect = <{path}/Surface.outputs:surface>"
        ));
        out.open("def Shader", "Surface", &[]);
        out.line("uniform token info:id = \"UsdPreviewSurface\"");
        match &image {
            Some(_) => out.line(&format!(
                "color3f inputs:diffuseColor.connect = <{path}/Color.outputs:rgb>"
            )),
            None => {
                let mut value = String::from("color3f inputs:diffuseColor = ");
                text::tuple(&mut value, [color.x, color.y, color.z]);
                out.line(&value);
            }
        }
        if let AlphaMode::Mask(least) = surface.alpha {
            out.line(&format!("float inputs:opacityThreshold = {least}"));
        }
        match (surface.alpha, &image) {
            (AlphaMode::Opaque, _) => {}
            (_, Some(_)) => out.line(&format!("float inputs:opacity.connect = <{path}/Color.outputs:a>")),
            (_, None) => out.line(&format!("float inputs:opacity = {}", color.w)),
        }
        if surface.emissive != Vec3::ZERO {
            let mut value = String::from("color3f inputs:emissiveColor = ");
            text::tuple(&mut value, surface.emissive.to_array());
            out.line(&value);
        }
        out.line(&format!("float inputs:metallic = {}", surface.metallic));
        out.line(&format!("float inputs:roughness = {}", surface.roughness));
        out.line("token outputs:surface");
        out.close();
        if let Some(image) = image {
            out.open("def Shader", "Color", &[]);
            out.line("uniform token info:id = \"UsdUVTexture\"");
            out.line(&format!("asset inputs:file = @{image}@"));
            out.line("token inputs:sourceColorSpace = \"sRGB\"");
            let mut scale = String::from("float4 inputs:scale = ");
            text::tuple(&mut scale, color.to_array());
            out.line(&scale);
            out.line(&format!("float2 inputs:st.connect = <{path}/Place.outputs:result>"));
            out.line("token inputs:wrapS = \"repeat\"");
            out.line("token inputs:wrapT = \"repeat\"");
            out.line("float outputs:a");
            out.line("float3 outputs:rgb");
            out.close();
            out.open("def Shader", "Place", &[]);
            out.line("uniform token info:id = \"UsdPrimvarReader_float2\"");
            out.line("string inputs:varname = \"st\"");
            out.line("float2 outputs:result");
            out.close();
        }
        out.close();
    }

    /// The path of a texture relative to the stage. The texture becomes a file of the output.
    fn image(&mut self, index: usize) -> Option<String> {
        let known = self.images.iter().find(|(_, texture)| *texture == index);
        if let Some((path, _)) = known {
            return Some(path.clone());
        }
        let texture = self.scene.textures.get(index)?;
        let extension = match texture.media_type.as_str() {
            "image/jpeg" => "jpg",
            "image/webp" => "webp",
            _ => "png",
        };
        let stem = texture.name.rsplit(['/', '\\']).next().unwrap_or_default();
        let stem = stem.strip_suffix(&format!(".{extension}")).unwrap_or(stem);
        let stem = file_stem_or(stem, "texture").replace('@', "_");
        let folder = if self.is_archive {
            format!("{FOLDER}/")
        } else {
            String::new()
        };
        let is_taken = |path: &str| self.images.iter().any(|(other, _)| other.eq_ignore_ascii_case(path));
        let mut path = format!("{folder}{stem}.{extension}");
        let mut count = 1;
        while is_taken(&path) {
            count += 1;
            path = format!("{folder}{stem}_{count}.{extension}");
        }
        self.images.push((path.clone(), index));
        Some(path)
    }
}
