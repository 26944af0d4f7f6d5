//! What must hold for any bytes at all. A panic is a finding.

use std::collections::BTreeSet;

use mocap::process::validate;
use mocap::scene::Warning;
use mocap::{Importer, Pose, Scene, SkeletonMesh, gltf};

/// An error, or a scene that keeps every rule and can be posed at any tick, with each kind of skeleton mesh.
pub fn import(bytes: &[u8]) {
    for mesh in [SkeletonMesh::None, SkeletonMesh::Segmented, SkeletonMesh::Skinned] {
        if let Some(scene) = read(bytes, mesh) {
            for tick in [0.0, 0.5, f64::MAX, f64::NAN] {
                // No rule says where the nodes then are, only that this ends without a panic.
                let _ = Pose::at_tick(&scene, 0, tick);
            }
        }
    }
}

/// An error, or a scene whose export is a glTF file that holds the same nodes.
pub fn import_export(bytes: &[u8]) {
    for mesh in [SkeletonMesh::None, SkeletonMesh::Segmented, SkeletonMesh::Skinned] {
        let Some(scene) = read(bytes, mesh) else { return };
        // Not every scene can be written: links of 1e38 add up to infinity. An error is an answer.
        if let Ok(glb) = gltf::write_glb(&scene, &gltf::Options::default()) {
            let file = ::gltf::Gltf::from_slice(&glb).expect("what was exported is valid glTF");
            assert!(file.nodes().len() >= scene.nodes.len());
            let written = file.animations().len();
            assert!(written <= scene.animations.len() && (written == 1 || !moves(&scene)));
        }
    }
}

/// What an input is told apart by: the codes of what is said about it.
pub fn outcome(bytes: &[u8]) -> BTreeSet<&'static str> {
    let codes = |warnings: &[Warning]| warnings.iter().map(|warning| warning.code.as_str()).collect();
    match importer(SkeletonMesh::None).read(bytes, "fuzz.bvh") {
        Ok(scene) => codes(&scene.warnings),
        Err(error) => {
            let mut codes: BTreeSet<_> = codes(error.warnings());
            // A code may be a warning in one file and the error of another.
            codes.extend(["error", error.code().as_str()]);
            codes
        }
    }
}

fn importer(mesh: SkeletonMesh) -> Importer {
    Importer::new().format("bvh").skeleton_mesh(mesh)
}

fn read(bytes: &[u8], mesh: SkeletonMesh) -> Option<Scene> {
    let scene = importer(mesh).read(bytes, "fuzz.bvh").ok()?;
    let violations = validate(&scene);
    assert!(violations.is_empty(), "{mesh:?}: {violations:?}");
    Some(scene)
}

/// Whether any track has more than one key: glTF stores the others in their nodes.
fn moves(scene: &Scene) -> bool {
    scene
        .animations
        .iter()
        .flat_map(|animation| &animation.channels)
        .any(|channel| {
            channel.position_keys.len() > 1 || channel.rotation_keys.len() > 1 || channel.scaling_keys.len() > 1
        })
}
