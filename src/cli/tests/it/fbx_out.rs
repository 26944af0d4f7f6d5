//! The options of FBX in each command that writes it.

use std::fs;
use std::path::{Path, PathBuf};

use mocap::{Conversion, Importer, Scene, SkeletonMesh};

use crate::at_root;
use crate::program::Folder;

fn import(path: impl AsRef<Path>) -> mocap::Result<Scene> {
    let mut scene = Importer::new()
        .skeleton_mesh(SkeletonMesh::Own)
        .gltf_meshes(true)
        .import(path)?;
    Conversion::new().apply(&mut scene)?;
    Ok(scene)
}

/// Each command that writes FBX has the same options for it.
#[test]
fn every_command_takes_the_options_of_fbx() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let plain = folder.succeeds("convert cmu_short.bvh plain.fbx --verify");
    assert!(!plain.contains("keys in"), "{plain}");
    for command in [
        "convert cmu_short.bvh out.fbx --verify",
        "retarget cmu_short.bvh cmu_short.bvh -o out.fbx",
        "edit cmu_short.bvh -o out.fbx --step mirror",
    ] {
        let words = folder.succeeds(&format!(
            "{command} --target motionbuilder --fbx-version 7.4 --fbx-rest pre-rotation --max-error 2mm"
        ));
        assert!(
            words.contains(" curves; error 1.") && words.contains(" mm at most"),
            "{words}"
        );
        let bytes = folder.read("out.fbx");
        assert!(
            5 * bytes.len() < 4 * folder.read("plain.fbx").len(),
            "{command}: {}",
            bytes.len()
        );
        let file = ufbx::load_memory(&bytes, ufbx::LoadOpts::default()).unwrap();
        assert_eq!(
            (file.metadata.version, file.settings.frames_per_second),
            (7400, 120.0),
            "{command}"
        );
        let has = |name: &str| file.nodes.iter().any(|node| &*node.element.name == name);
        assert!(has("Reference"), "{command}");
        let arm = file.nodes.iter().find(|node| &*node.element.name == "LeftArm").unwrap();
        assert!(
            arm.element.props.find_prop("PreRotation").is_some() || arm.euler_rotation.x == 0.0,
            "{command}"
        );
        folder.refuses(&format!("{command} --max-error 0"), 2, "--max-error 0: ");
    }
    folder.succeeds("edit cmu_short.bvh -o out.fbx --step mirror --max-error 2mm --force");
    folder.succeeds("verify cmu_short.bvh out.fbx --max-error 2mm");
    folder.refuses("verify cmu_short.bvh out.fbx --max-error 0.5mm", 1, "");
    let refused = folder.run("convert cmu_short.bvh new.fbx --max-error 1mm --compress int16");
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn textures_stand_beside_the_file_by_choice() {
    let folder = Folder::of_real(&[]);
    let character = fs::canonicalize(at_root("fixtures/made/two_bones_textured.gltf")).unwrap();
    let convert = format!("convert {} out.fbx --textures beside", character.display());
    folder.succeeds(&convert);
    let embedded = import(&character).unwrap();
    let images = |folder: &Folder| -> Vec<PathBuf> {
        let names = folder.contents().into_iter().map(|(path, _)| path);
        names
            .filter(|path| path.extension().is_some_and(|extension| extension == "png"))
            .collect()
    };
    let [image] = images(&folder).try_into().unwrap();
    assert_eq!(fs::read(&image).unwrap(), embedded.textures[0].bytes);
    let again = import(folder.path("out.fbx")).unwrap();
    assert_eq!((again.warnings.len(), again.textures.len()), (0, 1));
    assert_eq!(again.textures[0].bytes, embedded.textures[0].bytes);
    assert!(!folder.read("out.fbx").windows(4).any(|bytes| bytes == b"IHDR"));
    // A second run succeeds, because the bytes are equal. If an image differs, nothing is replaced.
    folder.succeeds(&convert);
    fs::write(&image, b"of somebody else").unwrap();
    folder.refuses(&convert, 1, "output-exists");
    folder.refuses(&convert.replace("out.fbx", "other.fbx"), 1, "output-exists");
    folder.succeeds(&format!("{convert} --force"));
    assert_eq!(fs::read(&image).unwrap(), embedded.textures[0].bytes);
    folder.refuses(&convert.replace("out.fbx", "- --to fbx"), 2, "--textures beside: ");
    folder.refuses(
        &convert.replace("out.fbx", "-o many --to fbx"),
        2,
        "--textures beside: ",
    );
}
