//! Values of characters that are not finite, and pages that stay small.

use crate::at_root;

/// The first byte of an attribute of the first mesh in a `.glb`.
fn first_of(attribute: &str, bytes: &[u8]) -> usize {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let primitive = &json["meshes"][0]["primitives"][0];
    let accessor = &json["accessors"][primitive["attributes"][attribute].as_u64().unwrap() as usize];
    let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let offset = |value: &serde_json::Value| value["byteOffset"].as_u64().unwrap_or(0) as usize;
    28 + length + offset(view) + offset(accessor)
}

#[test]
fn a_mesh_of_a_character_that_is_not_finite_is_said() {
    let folder = crate::program::Folder::of_real(&["cmu_short.bvh"]);
    let whole = std::fs::read(at_root("fixtures/characters/human_default.glb")).unwrap();
    folder.write("hero.glb", &whole);
    let said = folder.succeeds("retarget cmu_short.bvh hero.glb -o out.glb");
    assert!(!said.contains("non-finite-value"), "{said}");
    for (attribute, what) in [
        ("POSITION", "position"),
        ("NORMAL", "normal"),
        ("WEIGHTS_0", "weight of a joint"),
    ] {
        let mut bytes = whole.clone();
        let at = first_of(attribute, &bytes);
        bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        folder.write("hero.glb", &bytes);
        let said = folder.succeeds("retarget cmu_short.bvh hero.glb -o out.glb");
        assert!(said.contains("warning[non-finite-value]"), "{said}");
        assert!(
            said.contains(&format!("the {what} of vertex 0 is not finite")) && said.contains("/meshes/0"),
            "{said}"
        );
    }
}

/// A mesh of 400 vertices, 3,000 times: a file of 838 KB once made a page of 215 MB.
#[test]
fn many_instances_of_a_mesh_make_no_large_page() {
    use base64::Engine;
    const VERTICES: u16 = 600;
    const INSTANCES: usize = 3000;
    let mut bytes: Vec<u8> = Vec::new();
    for vertex in 0..VERTICES {
        let angle = f32::from(vertex);
        let position = [angle.cos(), angle.sin(), angle / 1000.0];
        bytes.extend(position.iter().flat_map(|number| number.to_le_bytes()));
    }
    let corners = (0..VERTICES).flat_map(|vertex| [vertex, (vertex + 1) % VERTICES, (vertex + 2) % VERTICES]);
    bytes.extend(corners.flat_map(u16::to_le_bytes));
    let positions = 12 * usize::from(VERTICES);
    let root = serde_json::json!({"name": "root", "children": (1..=INSTANCES).collect::<Vec<_>>()});
    let instances = (0..INSTANCES).map(|place| serde_json::json!({"mesh": 0, "name": format!("n{place}")}));
    let nodes: Vec<_> = std::iter::once(root).chain(instances).collect();
    let uri = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let gltf = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes,
        "meshes": [{"name": "m", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{uri}")}],
        "bufferViews": [
            {"buffer": 0, "byteLength": positions},
            {"buffer": 0, "byteOffset": positions, "byteLength": bytes.len() - positions},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": VERTICES, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 3 * usize::from(VERTICES), "type": "SCALAR"},
        ],
    });
    let folder = crate::program::Folder::of_real(&[]);
    folder.write("many.gltf", gltf.to_string().as_bytes());
    let said = folder.succeeds("view many.gltf -o many.html");
    assert!(said.contains("the page has no .glb to download"), "{said}");
    let page = folder.read("many.html").len();
    assert!(page < 8 << 20, "{page} bytes");
}
