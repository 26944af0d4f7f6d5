//! A scene that `serde` wrote is unchanged after reading.

use std::fs;

use mocap::{Importer, Scene};

#[test]
fn every_scene_is_read_back_but_for_what_serde_leaves_out() {
    for folder in ["real", "made", "characters"] {
        let mut files = 0;
        for path in fs::read_dir(format!("fixtures/{folder}"))
            .unwrap()
            .map(|entry| entry.unwrap().path())
        {
            let Ok(mut scene) = Importer::new().gltf_meshes(true).import(&path) else {
                continue;
            };
            files += 1;
            let text = serde_json::to_string(&scene).unwrap();
            let found: Scene =
                serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            scene.original = None;
            scene.metadata.file_space = Default::default();
            (scene.metadata.recorded, scene.metadata.solved, scene.metadata.fbx) = (None, None, None);
            scene.textures.iter_mut().for_each(|texture| texture.bytes.clear());
            assert!(found == scene, "{} is another scene", path.display());
        }
        assert!(files > 0, "no scene of {folder} was read");
    }
}

#[test]
fn a_name_of_no_diagnostic_is_refused() {
    let found = serde_json::from_str::<mocap::Code>("\"no-such-code\"");
    assert!(
        found
            .unwrap_err()
            .to_string()
            .contains("no diagnostic is called `no-such-code`")
    );
}
