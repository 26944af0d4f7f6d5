//! What a writer writes, its reader reads and `verify` accepts: the law that `tools/fuzz` holds for changed files. Here
//! are files that broke it.

use mocap::process::convert_units;
use mocap::scene::UpAxis;
use mocap::verify::verify;
use mocap::vrma::{self, VrmaOptions};
use mocap::{Conversion, Exporter, Format, Importer, Scene};
use serde_json::{Value, json};

/// The distance that a right file may be off, in metres.
const CLOSE: f64 = 1e-5;

/// A file of a scene in metres, which `verify` accepts.
#[track_caller]
fn accepted(source: &Scene, format: Format) -> Vec<u8> {
    let mut scene = source.clone();
    Conversion::new().apply(&mut scene).unwrap();
    let bytes = Exporter::new().write(&scene, format).unwrap().into_bytes().unwrap();
    let verified = verify(source, &bytes).unwrap();
    assert!(verified.is_within(CLOSE), "{format}: {verified:?}");
    bytes
}

/// Markers that are hidden in the first frame stand in one point there, which says nothing about the unit.
#[test]
fn the_unit_is_found_in_later_frames_where_all_joints_start_in_one_point() {
    let text = "HIERARCHY\nROOT Markers\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n\
                JOINT A\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n\
                JOINT B\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n}\n\
                MOTION\nFrames: 4\nFrame Time: 0.01\n\
                0 0 0 5 5 -5 5 5 -5\n0 0 0 10 20 30 40 100 60\n0 0 0 11 20 30 40 101 60\n0 0 0 12 20 30 40 102 60\n";
    let source = Importer::new().read(text.as_bytes(), "markers.bvh").unwrap();
    let mut scene = source.clone();
    convert_units(&mut scene, 0.01, UpAxis::Y);
    let bytes = Exporter::new()
        .write(&scene, Format::Bvh)
        .unwrap()
        .into_bytes()
        .unwrap();
    let verified = verify(&source, &bytes).unwrap();
    assert!(verified.is_within(CLOSE), "{verified:?}");
    // One that is no unit is still found.
    convert_units(&mut scene, 1.07, UpAxis::Y);
    let bytes = Exporter::new()
        .write(&scene, Format::Bvh)
        .unwrap()
        .into_bytes()
        .unwrap();
    assert!(!verify(&source, &bytes).unwrap().is_within(CLOSE));
}

/// A scene does not have the node of a mesh with a skin, whose transform has no meaning. It stays in the file.
#[test]
fn the_node_of_a_mesh_may_stand_beyond_all_positions() {
    let path = format!("{}/fixtures/made/two_bones_textured.gltf", env!("CARGO_MANIFEST_DIR"));
    let mut file: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let nodes = file["nodes"].as_array_mut().unwrap();
    let node = nodes.iter_mut().find(|node| node.get("mesh").is_some()).unwrap();
    for (field, value) in [
        ("translation", json!([3e38, 1, 3e38])),
        ("scale", json!([3e38, 1e-30, 1])),
    ] {
        node[field] = value;
    }
    let bytes = serde_json::to_vec(&file).unwrap();
    let source = Importer::new().gltf_meshes(true).read(&bytes, "a.gltf").unwrap();
    let written = accepted(&source, Format::Gltf);
    assert!(Importer::new().read(&written, "a.glb").is_ok());
}

/// The rest pose of a VRM animation is the T-pose, also where its legs do not point down in it.
#[test]
fn a_vrm_animation_is_written_with_the_t_pose_that_it_has() {
    let mut scene = mocap::import("fixtures/real/cmu_short.bvh").unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    let (bytes, _) = vrma::write(&scene, &VrmaOptions::default()).unwrap();
    let mut glb = gltf::Glb::from_slice(&bytes).unwrap();
    let mut file: Value = serde_json::from_slice(&glb.json).unwrap();
    for node in file["nodes"].as_array_mut().unwrap() {
        match node["name"].as_str() {
            Some("LeftLeg") => node["translation"] = json!([0.1, -0.3, -0.1]),
            Some("RightForeArm") => node["translation"] = json!([-0.2, -0.05, 0.03]),
            _ => (),
        }
    }
    glb.json = serde_json::to_vec(&file).unwrap().into();
    let source = Importer::new().read(&glb.to_vec().unwrap(), "a.vrma").unwrap();
    accepted(&source, Format::Vrma);
}
