//! Meshes that are read: vertices, bones, materials and textures.

use mocap::glam::{Vec2, Vec3};
use mocap::render::{Clip, Page, PageClip};
use mocap::scene::{AlphaMode, Scene};
use mocap::{Code, Importer};
use serde_json::{Value, json};

const BAR: &str = "../../fixtures/made/two_bones_textured.gltf";

fn read(file: &Value) -> Scene {
    let importer = Importer::new().gltf_meshes(true);
    importer.read(file.to_string().as_bytes(), "bar.gltf").unwrap()
}

fn bar() -> Value {
    serde_json::from_str(&std::fs::read_to_string(BAR).unwrap()).unwrap()
}

#[test]
fn a_skin_has_its_vertices_bones_and_texture() {
    let scene = Importer::new().gltf_meshes(true).import(BAR).unwrap();
    assert_eq!(scene.validate(), []);
    let mesh = &scene.meshes[0];
    assert_eq!((mesh.vertices.len(), mesh.faces().len()), (10, 8));
    assert_eq!(mesh.vertices[2], Vec3::new(-0.3, 0.5, 0.0));
    assert_eq!(mesh.texture_coords[9], Vec2::new(1.0, 0.0));
    // The file has no normals; the bar faces +Z.
    assert!(mesh.normals.iter().all(|normal| *normal == Vec3::Z));
    assert_eq!(mesh.bones[1].offset_matrix.w_axis.truncate(), Vec3::new(0.0, -1.0, 0.0));
    // Where the bones meet, both weights are a half.
    let halves = mesh.bones.iter().map(|bone| {
        let mut weights = bone.weights.iter();
        weights.find(|weight| weight.vertex_id == 4).map(|weight| weight.weight)
    });
    assert_eq!(halves.collect::<Vec<_>>(), [Some(0.5), Some(0.5)]);
    let material = &scene.materials[mesh.material_index];
    let surface = material.surface.unwrap();
    assert!(material.two_sided);
    assert_eq!(surface.alpha, AlphaMode::Mask(0.5));
    let texture = &scene.textures[surface.texture.unwrap()];
    assert_eq!(
        (texture.media_type.as_str(), &texture.bytes[1..4]),
        ("image/png", &b"PNG"[..])
    );
}

#[test]
fn meshes_are_read_only_where_they_are_asked_for() {
    let scene = mocap::import(BAR).unwrap();
    assert!(scene.textures.is_empty() && scene.meshes.iter().all(|mesh| mesh.name.is_empty()));
}

#[test]
fn a_mesh_without_a_skin_follows_its_node() {
    let mut file = bar();
    file["nodes"][2].as_object_mut().unwrap().remove("skin");
    file["nodes"][1]["children"] = json!([2]);
    file["scenes"][0]["nodes"] = json!([0]);
    file["nodes"][2]["translation"] = json!([5.0, 0.0, 0.0]);
    let scene = read(&file);
    assert_eq!(scene.warnings, []);
    // The node that only shows the mesh is omitted, so the node above it moves the mesh.
    let bone = &scene.meshes[0].bones[0];
    assert_eq!(bone.name, "upper");
    assert_eq!(bone.offset_matrix.w_axis.truncate(), Vec3::new(5.0, 0.0, 0.0));
    assert_eq!(bone.weights.len(), 10);
}

#[test]
fn a_place_on_the_texture_is_transformed() {
    let mut file = bar();
    file["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
        json!({"KHR_texture_transform": {"offset": [0.5, 0.25], "scale": [2.0, 1.0]}});
    assert_eq!(read(&file).meshes[0].texture_coords[9], Vec2::new(2.5, 0.25));
}

#[test]
fn what_is_broken_is_left_out_with_a_warning() {
    type Edit = fn(&mut Value);
    let edits: [(&str, Edit, bool); 9] = [
        (
            "/accessors/0",
            |file| file["accessors"][0]["count"] = json!(1_000_000),
            false,
        ),
        (
            "/meshes/0/primitives/0",
            |file| file["skins"][0]["joints"] = json!([0]),
            false,
        ),
        (
            "/skins/0/inverseBindMatrices",
            |file| file["accessors"][5]["count"] = json!(1),
            false,
        ),
        (
            "/meshes/0",
            |file| file["meshes"][0]["primitives"] = json!("none"),
            false,
        ),
        (
            "/meshes/0/primitives/0/indices",
            |file| (0..4).for_each(|index| file["accessors"][index]["count"] = json!(4)),
            false,
        ),
        ("/skins/7", |file| file["nodes"][2]["skin"] = json!(7), false),
        (
            "/materials/3",
            |file| file["meshes"][0]["primitives"][0]["material"] = json!(3),
            true,
        ),
        ("/textures/0", |file| file["textures"][0] = json!({}), true),
        (
            "/bufferViews/8",
            |file| file["bufferViews"][8]["byteLength"] = json!(1 << 30),
            true,
        ),
    ];
    let sound = read(&bar());
    for (pointer, edit, is_shown) in edits {
        let mut file = bar();
        edit(&mut file);
        let scene = read(&file);
        assert_eq!(scene.validate(), [], "{pointer}");
        assert_eq!(
            (scene.nodes.len(), &scene.animations),
            (sound.nodes.len(), &sound.animations),
            "{pointer}"
        );
        let warning = scene
            .warnings
            .first()
            .unwrap_or_else(|| panic!("{pointer}: no warning"));
        assert_eq!(warning.code, Code::IgnoredMesh, "{pointer}");
        let at = warning.pointer.as_deref().unwrap_or_default();
        assert!(at.starts_with(pointer), "{pointer}: {warning} at {at}");
        assert_eq!(
            scene.meshes.iter().any(|mesh| !mesh.name.is_empty()),
            is_shown,
            "{pointer}"
        );
    }
}

/// A broken mesh that many nodes show gives one warning.
#[test]
fn a_mesh_left_out_of_many_nodes_is_one_warning() {
    const NODES: u64 = 300;
    let mut file = bar();
    file["skins"][0]["inverseBindMatrices"] = json!(99);
    let shown = file["nodes"][2].clone();
    for _ in 1..NODES {
        let nodes = file["nodes"].as_array_mut().unwrap();
        let index = nodes.len();
        nodes.push(shown.clone());
        file["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(index));
    }
    let scene = read(&file);
    let counts: Vec<_> = scene
        .warnings
        .iter()
        .map(|warning| (warning.code, warning.count))
        .collect();
    // The skipped mesh, and the contents that are not passed through: the index, and everything that needs the index.
    let expected = [
        (Code::IgnoredMesh, NODES),
        (Code::InvalidGltf, 1),
        (Code::InvalidGltf, NODES),
    ];
    assert_eq!(counts, expected, "{:?}", scene.warnings);
    let said = scene.warnings[0].to_string();
    assert!(said.contains("(300 times)"), "{said}");
}

/// The JSON pointers of all numbers in a value.
fn numbers(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(at.to_owned()),
        Value::Array(items) => {
            let items = items.iter().enumerate();
            items.for_each(|(index, item)| numbers(item, &format!("{at}/{index}"), found));
        }
        Value::Object(items) => items
            .iter()
            .for_each(|(key, item)| numbers(item, &format!("{at}/{key}"), found)),
        _ => {}
    }
}

#[test]
fn every_changed_number_is_an_error_or_a_valid_scene_and_a_page() {
    let mut file = bar();
    let mut found = Vec::new();
    numbers(&file, "", &mut found);
    assert!(found.len() > 60);
    let importer = Importer::new().gltf_meshes(true);
    for pointer in found {
        let before = file.pointer(&pointer).unwrap().clone();
        for number in [0.0, 1.0, 2.0, -1.0, 5121.0, 4_294_967_295.0, 1e39] {
            *file.pointer_mut(&pointer).unwrap() = match number {
                whole if (0.0..1e30).contains(&whole) => json!(whole as u64),
                other => json!(other),
            };
            let Ok(scene) = importer.read(file.to_string().as_bytes(), "bar.gltf") else {
                continue;
            };
            assert_eq!(scene.validate(), [], "{pointer} = {number}");
            let clip = Clip {
                name: "bar",
                scene: &scene,
            };
            assert!(
                Page::new(&[PageClip::new(clip)]).html.ends_with("</html>\n"),
                "{pointer} = {number}"
            );
        }
        *file.pointer_mut(&pointer).unwrap() = before;
    }
}

#[test]
fn a_skin_that_is_too_large_is_left_out_of_a_page() {
    let mut scene = read(&bar());
    let clip = |scene: &Scene| Page::new(&[PageClip::new(Clip { name: "bar", scene })]);
    let small = clip(&scene);
    assert!(small.skins > 0 && small.textures > 0 && small.left_out == [Vec::<String>::new()]);
    // The page contains a repeated skin once.
    let shown = Clip {
        name: "bar",
        scene: &scene,
    };
    let both = Page::new(&[PageClip::new(shown), PageClip::new(shown)]);
    assert_eq!((both.skins, both.textures), (small.skins, small.textures));
    let texture = scene.textures[0].bytes.clone();
    scene.textures[0].bytes.resize(9 << 20, 0);
    let report = clip(&scene);
    assert_eq!(report.textures, 0);
    assert!(report.left_out[0][0].contains("9.0 MB"), "{:?}", report.left_out);
    scene.textures[0].bytes = texture;
    let faces = scene.meshes[0].indices.clone();
    scene.meshes[0].indices = faces.repeat(400_000);
    let report = clip(&scene);
    assert_eq!((report.skins, report.textures), (0, 0));
    assert!(
        report.left_out[0][0].contains("the page shows only the skeleton"),
        "{:?}",
        report.left_out
    );
}
