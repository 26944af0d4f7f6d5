//! Tests the names, the containers and the refused scenes of glTF files.

use std::collections::HashMap;

use mocap::Exporter;
use mocap::glam::{Quat, Vec3};
use mocap::gltf::report::Provenance;
use mocap::gltf::{BufferPlace, Document, GltfOptions};
use mocap::scene::Scene;

use super::read::{Read, text_of};
use super::scenes::{node, walker, with_skinned_mesh};

#[test]
fn bounds_are_the_exact_stored_numbers() {
    let read = Read::scene(&with_skinned_mesh(walker(50)));
    let mut bounded = 0;
    for accessor in read.document.accessors() {
        let (Some(min), Some(max)) = (accessor.min(), accessor.max()) else {
            continue;
        };
        let columns = accessor.dimensions().multiplicity();
        let floats = read.floats(&accessor);
        for column in 0..columns {
            let values = || floats.iter().skip(column).step_by(columns).copied();
            assert_eq!(min[column].as_f64(), values().reduce(f32::min).map(f64::from));
            assert_eq!(max[column].as_f64(), values().reduce(f32::max).map(f64::from));
        }
        bounded += 1;
    }
    assert_eq!(bounded, 2, "the times and the vertices");
}

#[test]
fn names_stay_but_equal_ones_and_separators_and_are_reported() {
    let mut scene = walker(4);
    let names = ["a/b[c]", "", "a_bc", " ", "a b"];
    for (node, name) in scene.nodes.iter_mut().zip(names) {
        node.name = name.into();
    }
    for name in ["a_b", "mixamorig:Hips", "mixamorigHips", "spine.001"] {
        scene.nodes.push(node(name, Some(0), Vec3::ONE));
    }
    scene.animations.clear();
    let document = Document::new(&scene, &GltfOptions::default()).unwrap();
    let read = Read::glb(&document.to_glb().unwrap());
    assert_eq!(
        read.names(),
        [
            "a_b[c]",
            "Joint",
            "a_bc_2",
            "Joint_2",
            "a b",
            "a_b_2",
            "mixamorig:Hips",
            "mixamorigHips_2",
            "spine.001"
        ]
    );
    let renamed: Vec<_> = document
        .report()
        .renamed
        .iter()
        .map(|change| (change.node, change.from.as_str()))
        .collect();
    assert_eq!(
        renamed,
        [
            (0, "a/b[c]"),
            (1, ""),
            (2, "a_bc"),
            (3, " "),
            (5, "a_b"),
            (7, "mixamorigHips")
        ]
    );
    let extras = read.document.nodes().next().unwrap().extras().as_ref().unwrap().get();
    assert_eq!(extras, r#"{"source_name":"a/b[c]"}"#);
}

#[test]
fn a_scene_without_frames_has_no_animations() {
    let scene = Scene {
        animations: vec![],
        ..with_skinned_mesh(walker(2))
    };
    let read = Read::scene(&scene);
    assert_eq!(read.document.animations().len(), 0);
    assert!(!text_of(&scene).contains("animations"));
}

#[test]
fn nothing_empty_is_written() {
    let empty = Scene::default();
    let flat = Scene {
        nodes: vec![node("a", None, Vec3::ZERO), node("b", Some(0), Vec3::ZERO)],
        ..Scene::default()
    };
    let collapsed = {
        let mut scene = with_skinned_mesh(flat.clone());
        scene.meshes[0].vertices.fill(Vec3::ZERO);
        scene
    };
    // A mesh without any area becomes a marker in the file.
    for (scene, nodes) in [(empty, 0), (flat, 2), (collapsed, 3)] {
        let text = text_of(&scene);
        assert!(!text.contains("[]") && !text.contains("{}"), "{text}");
        assert_eq!(Read::scene(&scene).document.nodes().len(), nodes);
    }
}

#[test]
fn what_is_not_finite_is_refused_by_name_and_no_file_is_left() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    for value in [
        Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0),
        Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
    ] {
        let mut scene = walker(3);
        scene.animations[0].channels[1].rotation_keys.values[2] = value;
        let error = Exporter::new().export(&scene, &path).unwrap_err();
        assert_eq!((error.code().as_str(), error.joint()), ("unrepresentable", Some("Leg")));
    }
    let mut scene = walker(3);
    scene.animations[0].ticks_per_second = 0.0;
    assert_eq!(
        GltfOptions::default().write_glb(&scene).unwrap_err().code().as_str(),
        "frame-time"
    );
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[test]
fn the_three_containers_hold_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let scene = with_skinned_mesh(walker(10));
    let glb_path = folder.path().join("a take.glb");
    std::fs::write(&glb_path, "an older file").unwrap();
    assert_eq!(
        Exporter::new().export(&scene, &glb_path).unwrap_err().code().as_str(),
        "output-exists"
    );
    let exporter = Exporter::new().overwrite(true);
    let written = exporter.export(&scene, &glb_path).unwrap();
    let glb = std::fs::read(&glb_path).unwrap();
    assert_eq!(written.len(), glb.len());
    let glb = Read::glb(&glb);

    let text_path = folder.path().join("a take.gltf");
    exporter.export(&scene, &text_path).unwrap();
    let beside = gltf::Gltf::open(&text_path).unwrap();
    let uri = beside.document.buffers().next().unwrap();
    assert!(matches!(uri.source(), gltf::buffer::Source::Uri("a%20take.bin")));
    assert_eq!(std::fs::read(folder.path().join("a take.bin")).unwrap(), glb.bin);

    let embedding = exporter.buffer(BufferPlace::Embedded);
    embedding.export(&scene, &text_path).unwrap();
    let embedded = gltf::Gltf::open(&text_path).unwrap();
    let buffer = embedded.document.buffers().next().unwrap();
    let gltf::buffer::Source::Uri(uri) = buffer.source() else {
        panic!("a data URI")
    };
    let data = uri.strip_prefix("data:application/octet-stream;base64,").unwrap();
    assert_eq!(data.len(), buffer.length().div_ceil(3) * 4);
    assert_eq!(beside.document.nodes().len(), embedded.document.nodes().len());
}

#[test]
fn provenance_is_in_the_file() {
    let mut scene = walker(50);
    scene.metadata.format = Some(mocap::Format::Bvh);
    let read = Read::scene(&scene);
    let extras = read.document.into_json().asset.extras.unwrap();
    let mut extras: HashMap<String, Provenance> = serde_json::from_str(extras.get()).unwrap();
    let provenance = extras.remove("mocap").unwrap();
    assert_eq!((provenance.frames, provenance.frame_time), (50, 1.0 / 120.0));
    assert_eq!(provenance.format, Some(mocap::Format::Bvh));
}

#[test]
fn equal_scenes_give_equal_bytes() {
    let scene = with_skinned_mesh(walker(20));
    let options = GltfOptions::default();
    assert_eq!(
        options.write_glb(&scene).unwrap(),
        options.write_glb(&scene.clone()).unwrap()
    );
}
