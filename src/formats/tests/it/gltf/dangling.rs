//! Indices without a target in passed-through contents: the writer writes none of them and reports each.

use std::fs;

use mocap::verify::report::Verification;
use mocap::{Code, Exporter, Format, Importer, Scene};
use serde_json::{Value, json};

/// An index beyond the end of every list.
const NOWHERE: u64 = 4_294_967_295;

fn file(name: &str) -> Value {
    serde_json::from_slice(&fs::read(format!("../../fixtures/{name}")).unwrap()).unwrap()
}

fn import(json: &Value) -> Scene {
    Importer::new().read(json.to_string().as_bytes(), "a.gltf").unwrap()
}

/// The JSON of a written scene, which another reader accepts.
fn written(scene: &Scene) -> Value {
    let files = Exporter::new().write(scene, Format::Gltf).unwrap();
    let bytes = files.into_bytes().unwrap();
    if let Err(gltf::Error::Validation(faults)) = gltf::Gltf::from_slice(&bytes) {
        // By the glTF specification, an accessor without a view has zeros. The crate requires a view.
        let is_of_zeros = |path: &str| path.starts_with("accessors[") && path.ends_with("].bufferView");
        assert!(faults.iter().all(|(path, _)| is_of_zeros(path.as_str())), "{faults:?}");
    }
    let verified = Verification::of(scene, &bytes).unwrap();
    assert!(verified.is_within(1e-5) && verified.findings.is_empty(), "{verified:?}");
    serde_json::from_slice(&gltf::Glb::from_slice(&bytes).unwrap().json).unwrap()
}

/// Whether an index without a target remains anywhere.
fn has_nowhere(value: &Value) -> bool {
    match value {
        Value::Array(items) => items.iter().any(has_nowhere),
        Value::Object(members) => members.values().any(has_nowhere),
        value => *value == NOWHERE,
    }
}

/// `json` with `value` at a pointer. Missing objects are created.
fn with(json: &Value, pointer: &str, value: &Value) -> Value {
    let mut json = json.clone();
    let mut at = &mut json;
    for part in pointer.split('/').skip(1) {
        at = match part.parse::<usize>() {
            Ok(index) if at.is_array() || at.is_null() => {
                if at.is_null() {
                    *at = json!([]);
                }
                let items = at.as_array_mut().unwrap();
                items.resize(items.len().max(index + 1), Value::Null);
                &mut items[index]
            }
            _ => &mut at[part],
        };
    }
    *at = value.clone();
    json
}

/// For each list of a mesh with a texture and a skin: an index without a target, and the removed contents.
#[test]
fn an_index_that_points_at_nothing_is_said_and_not_written() {
    let cases = [
        ("/meshes/0/primitives/0/attributes/POSITION", "meshes/0/primitives/0"),
        ("/meshes/0/primitives/0/attributes/JOINTS_0", "meshes/0/primitives/0"),
        ("/meshes/0/primitives/0/attributes/WEIGHTS_0", "meshes/0/primitives/0"),
        (
            "/meshes/0/primitives/0/attributes/TANGENT",
            "meshes/0/primitives/0/attributes/TANGENT",
        ),
        ("/meshes/0/primitives/0/targets/0/POSITION", "meshes/0/primitives/0"),
        ("/meshes/0/primitives/0/indices", "meshes/0/primitives/0"),
        ("/meshes/0/primitives/0/material", "meshes/0/primitives/0/material"),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/index",
            "materials/0/pbrMetallicRoughness/baseColorTexture",
        ),
        (
            "/materials/0/extensions/KHR_materials_sheen/sheenColorTexture/index",
            "sheenColorTexture",
        ),
        ("/textures/0/source", "textures/0"),
        ("/textures/0/sampler", "textures/0/sampler"),
        (
            "/textures/0/extensions/KHR_texture_basisu/source",
            "textures/0/extensions/KHR_texture_basisu",
        ),
        ("/images/0/bufferView", "images/0"),
        ("/accessors/1/bufferView", "accessors/1"),
        ("/bufferViews/1/buffer", "bufferViews/1"),
        ("/skins/0/inverseBindMatrices", "skins/0"),
        ("/skins/0/skeleton", "skins/0/skeleton"),
        ("/nodes/2/mesh", "nodes/2"),
        ("/nodes/2/skin", "nodes/2"),
        ("/nodes/2/camera", "nodes/2/camera"),
        ("/nodes/2/extensions/KHR_lights_punctual/light", "KHR_lights_punctual"),
        ("/animations/0/samplers/1/input", "animations/0/samplers/1"),
    ];
    let sound = file("made/two_bones_textured.gltf");
    for (pointer, gone) in cases {
        let mut json = sound.clone();
        if pointer.contains("samplers/1") {
            json = with(&json, "/animations/0/samplers/1", &json["animations"][0]["samplers"][0]);
        }
        let scene = import(&with(&json, pointer, &NOWHERE.into()));
        let found = scene
            .warnings
            .iter()
            .find(|warning| warning.pointer.as_deref() == Some(pointer));
        let warning = found.unwrap_or_else(|| panic!("{pointer}: {:?}", scene.warnings));
        assert_eq!(warning.code, Code::InvalidGltf);
        assert!(
            warning.message.contains("4294967295") && warning.message.contains(gone),
            "{}",
            warning.message
        );
        let json = written(&scene);
        assert!(!has_nowhere(&json), "{pointer}: {json}");
        // The moving parts remain.
        assert_eq!(json["skins"].as_array().unwrap().len(), 1, "{pointer}");
    }
}

/// The lists of VRM: bones, visibility and springs.
#[test]
fn extensions_of_vrm_name_nothing_that_is_not_there() {
    let vrm1 = file("skeletons/human_vrm1.gltf");
    let cases = [
        "/extensions/VRMC_vrm/meta/thumbnailImage",
        "/extensions/VRMC_vrm/firstPerson/meshAnnotations/0/node",
        "/extensions/VRMC_vrm/expressions/preset/happy/morphTargetBinds/0/node",
        "/extensions/VRMC_vrm/expressions/custom/wink/materialColorBinds/0/material",
        "/extensions/VRMC_springBone/springs/0/joints/0/node",
        "/extensions/VRMC_springBone/springs/0/center",
        "/extensions/VRMC_springBone/colliders/0/node",
        "/extensions/VRMC_springBone/colliderGroups/0/colliders/0",
        "/extensions/VRMC_springBone/springs/0/colliderGroups/0",
        "/extensions/VRM/meta/texture",
        "/extensions/VRM/firstPerson/meshAnnotations/0/mesh",
        "/extensions/VRM/blendShapeMaster/blendShapeGroups/0/binds/0/mesh",
        "/extensions/VRM/secondaryAnimation/boneGroups/0/bones/0",
        "/extensions/VRM/secondaryAnimation/boneGroups/0/colliderGroups/0",
        "/extensions/VRM/secondaryAnimation/colliderGroups/0/node",
        "/extensions/VRM/materialProperties/0/textureProperties/_MainTex",
        "/nodes/1/extensions/VRMC_node_constraint/constraint/roll/source",
    ];
    // A character of a few kilobytes gets a mesh, because a file without a mesh is not kept.
    let mut sound = file("made/two_bones_textured.gltf");
    let motion = mocap::import("../../fixtures/made/two_bones_textured.gltf")
        .unwrap()
        .animations;
    for pointer in cases {
        let broken = with(&sound, pointer, &NOWHERE.into());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gltf");
        fs::write(&path, broken.to_string()).unwrap();
        let character = Importer::new().import_character(&path).unwrap();
        let warnings = &character.scene().warnings;
        assert!(
            warnings
                .iter()
                .any(|warning| warning.pointer.as_deref() == Some(pointer)),
            "{pointer}: {warnings:?}"
        );
        let bytes = character.with_animations(&motion, false).unwrap();
        assert!(!has_nowhere(&serde_json::from_slice(&bytes).unwrap()), "{pointer}");
    }
    // VRM 0 writes -1 for no target.
    sound["extensions"] = json!({"VRM": {"firstPerson": {"firstPersonBone": -1}, "meta": {"texture": -1}}});
    let scene = import(&sound);
    assert!(
        scene.warnings.iter().all(|warning| warning.code != Code::InvalidGltf),
        "{:?}",
        scene.warnings
    );
    let original = vrm1["extensions"]["VRMC_vrm"]["humanoid"].clone();
    assert_eq!(
        import(&vrm1)
            .warnings
            .iter()
            .filter(|warning| warning.code == Code::InvalidGltf)
            .count(),
        0,
        "{original}"
    );
}

/// A correct file keeps its bytes. A file with a broken index keeps everything that does not use the index.
#[test]
fn the_rest_of_a_file_with_a_broken_index_stays() {
    let sound = file("made/two_bones_textured.gltf");
    let broken = with(&sound, "/nodes/2/camera", &NOWHERE.into());
    let (mut sound, mut mended) = (written(&import(&sound)), written(&import(&broken)));
    for json in [&mut sound, &mut mended] {
        // The animations name the input by its digest.
        json["animations"] = Value::Null;
    }
    assert_eq!(sound, mended);
}

/// Pointers of animations are strings, not numbers.
#[test]
fn a_pointer_of_an_animation_that_leads_nowhere_is_said_and_not_written() {
    let sound = file("made/two_bones_textured.gltf");
    let channels = sound["animations"][0]["channels"].as_array().unwrap().len();
    let place = format!("/animations/0/channels/{channels}");
    for (pointer, is_there) in [
        ("/materials/0/emissiveFactor", true),
        ("/materials/7/emissiveFactor", false),
        ("/nodes/0/weights/0", true),
        ("/nodes/4294967295/weights", false),
        ("/extensions/KHR_lights_punctual/lights/0/color", false),
        ("/somewhere", true),
    ] {
        let target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": pointer } } });
        let scene = import(&with(&sound, &place, &json!({ "sampler": 0, "target": target })));
        let said = scene.warnings.iter().any(|warning| warning.message.contains(pointer));
        assert_eq!(said, !is_there, "{pointer}: {:?}", scene.warnings);
        let text = written(&scene).to_string();
        assert!(is_there || !text.contains(pointer), "{pointer}");
    }
}
