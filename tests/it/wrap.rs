//! The wrapping of textures beyond their edges, from glTF to FBX and back.

use mocap::scene::Wrap;
use mocap::{Code, Exporter, Format, Importer, Scene, SkeletonMesh};
use serde_json::{Value, json};

fn with_sampler(wrap_s: u32, wrap_t: u32) -> Scene {
    let text = std::fs::read("fixtures/made/two_bones_textured.gltf").unwrap();
    let mut file: Value = serde_json::from_slice(&text).unwrap();
    file["samplers"] = json!([{ "wrapS": wrap_s, "wrapT": wrap_t }]);
    for texture in file["textures"].as_array_mut().unwrap() {
        texture["sampler"] = json!(0);
    }
    read(&serde_json::to_vec(&file).unwrap(), "a.gltf")
}

fn read(bytes: &[u8], name: &str) -> Scene {
    let importer = Importer::new().gltf_meshes(true).skeleton_mesh(SkeletonMesh::Own);
    importer.read(bytes, name).unwrap()
}

fn wrap_of(scene: &Scene) -> [Wrap; 2] {
    let mut surfaces = scene.materials.iter().filter_map(|material| material.surface);
    surfaces.find(|surface| surface.texture.is_some()).unwrap().wrap
}

#[test]
fn fbx_keeps_what_it_can_say() {
    let mut scene = with_sampler(33_071, 10_497);
    assert_eq!(wrap_of(&scene), [Wrap::Clamp, Wrap::Repeat]);
    scene.original = None;
    let fbx = Exporter::new()
        .write(&scene, Format::Fbx)
        .unwrap()
        .into_bytes()
        .unwrap();
    let again = read(&fbx, "a.fbx");
    assert_eq!(wrap_of(&again), [Wrap::Clamp, Wrap::Repeat]);
    let glb = Exporter::new()
        .write(&again, Format::Gltf)
        .unwrap()
        .into_bytes()
        .unwrap();
    let file: Value = serde_json::from_slice(&gltf::Glb::from_slice(&glb).unwrap().json).unwrap();
    let sampler = &file["samplers"][file["textures"][0]["sampler"].as_u64().unwrap() as usize];
    assert_eq!(sampler["wrapS"], 33_071);
    assert_eq!(sampler["wrapT"].as_u64().unwrap_or(10_497), 10_497);
}

#[test]
fn a_mirror_image_repeats_in_fbx_with_a_warning() {
    let scene = with_sampler(33_648, 33_071);
    assert_eq!(wrap_of(&scene), [Wrap::Mirror, Wrap::Clamp]);
    let written = Exporter::new().write(&scene, Format::Fbx).unwrap();
    let is_it = |warning: &&mocap::Diagnostic| warning.message.contains("mirrored repeat");
    assert_eq!(written.warnings.iter().find(is_it).unwrap().code, Code::IgnoredMesh);
    assert_eq!(
        wrap_of(&read(&written.into_bytes().unwrap(), "a.fbx")),
        [Wrap::Repeat, Wrap::Clamp]
    );
}
