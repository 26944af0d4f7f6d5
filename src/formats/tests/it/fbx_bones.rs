//! The nodes of written FBX files that are bones, as ufbx reads them.

use mocap::fbx::{FbxOptions, FbxTarget};
use mocap::{Conversion, Importer};
use serde_json::{Value, json};

/// Two bones of a skin below a group. This group is below another group, which has a mesh without a skin.
fn nested() -> Value {
    let text = std::fs::read_to_string("../../fixtures/made/two_bones_textured.gltf").unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    let nodes = file["nodes"].as_array_mut().unwrap();
    assert_eq!(nodes.len(), 3);
    nodes.push(json!({"name": "Armature", "children": [0]}));
    nodes.push(json!({"name": "Prop", "mesh": 0, "children": [3]}));
    file["scenes"][0]["nodes"] = json!([4, 2]);
    file
}

/// Blender's Python importer fails with `KeyError: None` if a bone of a cluster is below a `Null` that is below a bone.
#[test]
fn what_is_between_bones_is_a_bone() {
    let importer = Importer::new().gltf_meshes(true);
    let mut scene = importer.read(nested().to_string().as_bytes(), "nested.gltf").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    for options in [FbxOptions::default(), FbxOptions::of_target(FbxTarget::Unreal)] {
        let (bytes, report) = options.write(&scene).unwrap();
        let file = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).unwrap();
        let bones: Vec<_> = file.nodes.iter().filter(|node| node.bone.is_some()).collect();
        assert_eq!(report.bones, bones.len());
        let is_bone = |name: &str| bones.iter().any(|node| &*node.element.name == name);
        assert!(is_bone("Prop") && is_bone("Armature"));
        assert!(
            file.skin_clusters.len() >= 3,
            "two bones, and the group of the other mesh"
        );
        for cluster in &file.skin_clusters {
            let mut chain = Vec::new();
            let mut above = cluster.bone_node.as_deref();
            while let Some(node) = above {
                chain.push(node.bone.is_some());
                above = node.parent.as_deref();
            }
            assert!(chain[0], "a cluster refers to what is no bone");
            // From the bone to the root: first bones, then the nodes above all bones.
            assert!(chain.is_sorted_by(|below, above| below >= above), "{chain:?}");
        }
    }
}
