//! Counts the data of a glTF file that a scene does not hold.

use std::collections::{BTreeMap, BTreeSet};

use mocap_scene::scene::SKELETON_MATERIAL;
use mocap_scene::scene::report::{DataKind, DataLoss};
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::json;
use crate::ReadOptions;

#[derive(Default, Deserialize)]
#[serde(default)]
struct Contents {
    asset: Item,
    scenes: Vec<Item>,
    nodes: Vec<Item>,
    meshes: Vec<Mesh>,
    materials: Vec<Surface>,
    textures: Vec<IgnoredAny>,
    cameras: Vec<Item>,
    extensions: Extensions,
}

/// An item of the file, and the kind of data as which its loss counts.
#[derive(Default, Deserialize)]
#[serde(default)]
struct Item {
    name: String,
    skin: Option<usize>,
    extras: Value,
    extensions: Value,
}

/// The textures and other contents of a material.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Surface {
    name: String,
    extras: Value,
    extensions: Value,
    normal_texture: Value,
    occlusion_texture: Value,
    emissive_texture: Value,
    pbr_metallic_roughness: Value,
}

impl Surface {
    /// The textures besides the colour.
    fn maps(&self) -> usize {
        let metallic = &self.pbr_metallic_roughness["metallicRoughnessTexture"];
        let maps = [
            &self.normal_texture,
            &self.occlusion_texture,
            &self.emissive_texture,
            metallic,
        ];
        maps.into_iter().filter(|map| !map.is_null()).count()
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Primitive {
    attributes: BTreeMap<String, Value>,
    targets: Vec<IgnoredAny>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Extensions {
    #[serde(rename = "KHR_lights_punctual")]
    lights: Lights,
    #[serde(rename = "VRMC_vrm")]
    vrm1: Value,
    #[serde(rename = "VRM")]
    vrm0: Value,
    #[serde(rename = "VRMC_springBone")]
    springs: Value,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct Lights {
    lights: Vec<IgnoredAny>,
}

impl Primitive {
    fn sets(&self, attribute: &str) -> usize {
        let names = self.attributes.keys();
        names.filter(|name| name.starts_with(attribute)).count()
    }
}

/// The data that no scene holds with these options. Empty for a file with other contents.
pub(super) fn unread(bytes: &[u8], options: &ReadOptions) -> Vec<DataLoss> {
    let text = json::split(bytes).map(|(text, _)| text).unwrap_or_default();
    let Ok(file) = serde_json::from_str::<Contents>(&String::from_utf8_lossy(text)) else {
        return Vec::new();
    };
    let is_ours = file.asset.extras.get("mocap").is_some();
    let is_drawn = is_ours && file.materials.iter().all(|material| material.name == SKELETON_MATERIAL);
    let are_meshes_read = options.gltf_meshes && !options.without_meshes;
    let mut lost = Vec::new();
    let mut add = |kind: DataKind, count: usize| {
        if count > 0 {
            lost.push(DataLoss::new(kind, count as u64));
        }
    };
    if !options.without_meshes && !is_drawn {
        let primitives = || file.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let first_targets = file.meshes.iter().filter_map(|mesh| mesh.primitives.first());
        if !are_meshes_read {
            add(DataKind::Meshes, file.meshes.len());
            let skins: BTreeSet<usize> = file.nodes.iter().filter_map(|node| node.skin).collect();
            add(DataKind::Skins, if file.meshes.is_empty() { 0 } else { skins.len() });
            add(DataKind::Materials, file.materials.len());
            add(DataKind::Textures, file.textures.len());
        }
        if are_meshes_read {
            add(DataKind::SurfaceMaps, file.materials.iter().map(Surface::maps).sum());
        }
        // The first set of texture coordinates is read with its mesh.
        let read = usize::from(are_meshes_read);
        add(
            DataKind::UvSets,
            primitives()
                .map(|part| part.sets("TEXCOORD_").saturating_sub(read))
                .sum(),
        );
        add(
            DataKind::VertexColors,
            primitives().filter(|part| part.sets("COLOR_") > 0).count(),
        );
        if !(are_meshes_read && options.morph_targets) {
            add(
                DataKind::MorphTargets,
                first_targets.map(|part| part.targets.len()).sum(),
            );
        }
    }
    add(DataKind::Cameras, file.cameras.len());
    add(DataKind::Lights, file.extensions.lights.lights.len());
    let of_kind = |kind: &str| {
        file.extensions.vrm1["expressions"][kind]
            .as_object()
            .map_or(0, serde_json::Map::len)
    };
    let groups = &file.extensions.vrm0["blendShapeMaster"]["blendShapeGroups"];
    add(
        DataKind::Expressions,
        of_kind("preset") + of_kind("custom") + groups.as_array().map_or(0, Vec::len),
    );
    let (vrm0, vrm1) = (&file.extensions.vrm0, &file.extensions.vrm1);
    let length = |list: &Value| list.as_array().map_or(0, Vec::len);
    add(
        DataKind::Springs,
        length(&file.extensions.springs["springs"]) + length(&vrm0["secondaryAnimation"]["boneGroups"]),
    );
    let is_constrained = |node: &&Item| !node.extensions["VRMC_node_constraint"].is_null();
    add(DataKind::Constraints, file.nodes.iter().filter(is_constrained).count());
    let stated = [&vrm1["lookAt"], &vrm1["firstPerson"], &vrm0["firstPerson"]];
    let is_toon = |material: &&Surface| !material.extensions["VRMC_materials_mtoon"].is_null();
    let is_toon_of_vrm0 = |properties: &&Value| properties["shader"] == "VRM/MToon";
    let of_vrm0 = vrm0["materialProperties"].as_array().map_or(&[][..], Vec::as_slice);
    add(
        DataKind::CharacterSettings,
        stated.into_iter().filter(|part| !part.is_null()).count()
            + file.materials.iter().filter(is_toon).count()
            + of_vrm0.iter().filter(is_toon_of_vrm0).count(),
    );
    if !is_ours {
        let items = [&file.scenes, &file.nodes, &file.cameras].into_iter().flatten();
        let extras = items.map(|item| &item.extras);
        let extras = extras.chain(file.materials.iter().map(|material| &material.extras));
        add(DataKind::Extras, extras.filter(|extras| !extras.is_null()).count());
    }
    lost
}
