//! Written files that are read back to a scene, files of other programs, and invalid files.

use mocap::Exporter;
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::gltf::{BufferPlace, GltfOptions};

use mocap::scene::{Node, NodeKind, Scene};
use mocap::{Importer, Pose, SkeletonMesh};

use super::scenes::{node, walker, with_skinned_mesh};

fn read(bytes: &[u8]) -> mocap::Result<Scene> {
    Importer::new().skeleton_mesh(SkeletonMesh::None).read(bytes, "a.glb")
}

fn round_trip(scene: &Scene) -> Scene {
    read(&GltfOptions::new().keep_constant(true).write_glb(scene).unwrap()).unwrap()
}

/// Asserts that nodes have the same names, kinds and parents, and the same positions in every frame.
#[track_caller]
fn assert_same(read: &Scene, written: &Scene) {
    let shape = |node: &Node| (node.name.clone(), node.kind, node.parent);
    let shapes = |scene: &Scene| scene.nodes.iter().map(shape).collect::<Vec<_>>();
    assert_eq!(shapes(read), shapes(written));
    assert_eq!(read.animations.len(), written.animations.len());
    for (ours, theirs) in read.animations.iter().zip(&written.animations) {
        assert_eq!(ours.duration, theirs.duration);
        assert!((ours.ticks_per_second - theirs.ticks_per_second).abs() < 1e-9);
        for frame in 0..theirs.frame_count() {
            let pose = |scene| Pose::at_tick(scene, 0, frame as f64).unwrap();
            for (a, b) in pose(read).node_to_world.iter().zip(&pose(written).node_to_world) {
                assert!(a.abs_diff_eq(*b, 1e-4), "frame {frame}");
            }
        }
    }
    assert_eq!(read.validate(), []);
}

#[test]
fn a_written_scene_reads_as_itself() {
    let scene = with_skinned_mesh(walker(50));
    let read = round_trip(&scene);
    assert_same(&read, &scene);
    assert_eq!(read.nodes[2].kind, NodeKind::EndSite);
    let keys = &read.animations[0].channels[0].rotation_keys;
    assert_eq!((keys.len(), &keys.ticks), (50, &None), "a key a tick");
    assert_eq!(read.metadata.format, Some(mocap::Format::Gltf));
    assert_eq!(read.metadata.metres_per_unit, Some(1.0));
    assert!(read.meshes.is_empty(), "meshes stay behind");
}

#[test]
fn folded_tracks_come_back_from_the_nodes() {
    let scene = walker(50);
    assert_same(
        &read(&GltfOptions::default().write_glb(&scene).unwrap()).unwrap(),
        &scene,
    );
}

#[test]
fn names_that_had_to_change_come_back() {
    let mut scene = with_skinned_mesh(walker(10));
    for (node, name) in scene.nodes.iter_mut().zip(["mixamorig:Hips", "a.b", "a.b", "", ""]) {
        node.name = name.into();
    }
    scene.nodes[2].kind = NodeKind::Joint;
    for (channel, name) in scene.animations[0]
        .channels
        .iter_mut()
        .zip(["mixamorig:Hips", "a.b", ""])
    {
        channel.node_name = name.into();
    }
    for bone in &mut scene.meshes[0].bones {
        bone.name = scene.nodes[bone.node.index()].name.clone();
    }
    assert_same(&round_trip(&scene), &scene);
}

#[test]
fn a_root_joint_and_uneven_keys_come_back() {
    let mut scene = walker(50);
    scene.extract_root_motion();
    let keys = &mut scene.animations[0].channels[2].rotation_keys;
    keys.values = vec![Quat::IDENTITY, Quat::from_rotation_z(0.5), Quat::from_rotation_z(1.0)];
    keys.ticks = Some(vec![0.0, 3.5, 49.0]);
    assert_same(&round_trip(&scene), &scene);
}

#[test]
fn several_roots_get_a_group() {
    let mut scene = walker(2);
    scene.animations.clear();
    scene.nodes = vec![
        Node {
            kind: NodeKind::Group,
            ..node("Roots", None, Vec3::ZERO)
        },
        node("a", Some(0), Vec3::X),
        node("b", Some(1), Vec3::Y),
        node("c", Some(0), Vec3::Z),
    ];
    // The file lacks the group, as in files of other programs.
    let glb = GltfOptions::default().write_glb(&scene).unwrap();
    let text = json_of(&glb)
        .replace(r#""nodes":[0]"#, r#""nodes":[1,3]"#)
        .replace(r#""children":[1,3],"#, "");
    let text = text.replace(r#""skeleton":0"#, r#""skeleton":1"#);
    let read = read(&with_json(&glb, &text)).unwrap();
    assert_eq!(
        read.nodes.iter().map(|node| node.name.as_str()).collect::<Vec<_>>(),
        ["Roots", "a", "b", "c"]
    );
    assert_eq!(read.nodes[0].kind, NodeKind::Group);
    assert_eq!(read.nodes[3].transform, Mat4::from_translation(Vec3::Z));
}

#[test]
fn text_files_bring_their_buffer_along_or_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a take.gltf");
    let scene = walker(20);
    let exporter = Exporter::new().overwrite(true);
    let embedding = exporter.clone().buffer(BufferPlace::Embedded);
    embedding.export(&scene, &path).unwrap();
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    assert_same(&importer.import(&path).unwrap(), &scene);
    exporter.export(&scene, &path).unwrap();
    assert_same(&importer.import(&path).unwrap(), &scene);

    let error = importer
        .read(&std::fs::read(&path).unwrap(), "a take.gltf")
        .unwrap_err();
    assert!(error.to_string().contains("a take.bin"), "{error}");
}

#[test]
fn a_frame_time_is_found_where_none_is_stated() {
    let glb = GltfOptions::default().write_glb(&walker(3000)).unwrap();
    let text = json_of(&glb).replace(r#""mocap""#, r#""other""#);
    let read = read(&with_json(&glb, &text)).unwrap();
    let animation = &read.animations[0];
    assert!(
        (animation.ticks_per_second - 120.0).abs() < 1e-4,
        "{}",
        animation.ticks_per_second
    );
    assert_eq!(animation.frame_count(), 3000);
    assert_eq!(animation.channels[0].rotation_keys.ticks, None);
}

#[test]
fn what_is_wrong_is_said() {
    let glb = GltfOptions::default().write_glb(&walker(5)).unwrap();
    let text = json_of(&glb);
    let changed = [
        // The leg is its own child.
        text.replace(r#""children":[2]"#, r#""children":[1]"#),
        // The output of the last sampler ends two bytes after the buffer.
        text.replace(r#""byteLength":"#, r#""byteOffset":2,"byteLength":"#),
        text.replace(r#""type":"SCALAR""#, r#""type":"VEC3""#),
        text.replace(
            r#""asset":{"#,
            r#""extensionsRequired":["EXT_moves_everything"],"asset":{"#,
        ),
        text.replace(r#""translation":[0,90,0]"#, r#""translation":[0,1e39,0]"#),
    ];
    for changed in changed {
        assert_ne!(changed, text);
        assert_eq!(
            read(&with_json(&glb, &changed)).unwrap_err().code().as_str(),
            "invalid-gltf",
            "{changed}"
        );
    }
    for length in [0_u32, 11, 12, 19, u32::MAX] {
        let mut bytes = glb.clone();
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        assert_eq!(read(&bytes).unwrap_err().code().as_str(), "invalid-gltf", "{length}");
    }
}

/// Every prefix, and every byte set to three other values, gives an error or a valid scene, and never a panic.
#[test]
fn no_bytes_do_harm() {
    let glb = GltfOptions::default().write_glb(&walker(2)).unwrap();
    for end in 0..glb.len() {
        assert!(read(&glb[..end]).is_err(), "{end}");
    }
    for place in 0..glb.len() {
        for flip in [0x01, 0x10, 0xff] {
            let mut bytes = glb.clone();
            bytes[place] ^= flip;
            if let Ok(scene) = read(&bytes) {
                assert_eq!(scene.validate(), [], "byte {place} ^ {flip:#x}");
            }
        }
    }
}

fn json_of(glb: &[u8]) -> String {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    String::from_utf8(glb[20..20 + length].to_vec()).unwrap()
}

fn with_json(glb: &[u8], text: &str) -> Vec<u8> {
    let bin = gltf::binary::Glb::from_slice(glb).unwrap().bin;
    let header = gltf::binary::Header {
        magic: *b"glTF",
        version: 2,
        length: 0,
    };
    gltf::binary::Glb {
        header,
        json: text.as_bytes().into(),
        bin,
    }
    .to_vec()
    .unwrap()
}
