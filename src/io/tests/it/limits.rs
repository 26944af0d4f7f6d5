//! Readers accept all outputs of the writers, and a small file never becomes a huge page.

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::gltf::BufferPlace;
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, UpAxis};
use mocap::{Code, Conversion, Exporter, Format, FormatInfo, Importer, Scene};

/// A chain of joints, each with a name and an offset, in metres with +Y up.
fn chain(joints: usize, name: &dyn Fn(usize) -> String, offset: f32) -> Scene {
    let mut scene = Scene::default();
    let node = |joint: usize| Node {
        name: name(joint),
        parent: joint.checked_sub(1).map(NodeId::new),
        transform: Mat4::from_translation(Vec3::new(0.0, offset, 0.0)),
        ..Node::default()
    };
    scene.nodes = (0..joints).map(node).collect();
    scene.metadata.metres_per_unit = Some(1.0);
    scene.metadata.up = Some(UpAxis::Y);
    scene
}

/// A clip in which each joint turns, with two keys that are `frames` apart.
fn sparse(scene: &Scene, frames: usize, rate: f64) -> Animation {
    let last = (frames - 1) as f64;
    let ends = [Quat::IDENTITY, Quat::from_rotation_x(0.5)].to_vec();
    let channels = scene.nodes.iter().map(|node| Channel {
        node_name: node.name.clone(),
        position_keys: Keys::constant(node.transform.w_axis.truncate()),
        rotation_keys: Keys::at_ticks(ends.clone(), vec![0.0, last]),
        scaling_keys: Keys::constant(Vec3::ONE),
        ..Channel::default()
    });
    Animation {
        name: "sparse".to_owned(),
        ticks_per_second: rate,
        duration: last,
        channels: channels.collect(),
    }
}

/// Scenes at and beyond the limits, each with a description.
fn scenes() -> Vec<(&'static str, Scene)> {
    let plain = |joint: usize| format!("j{joint}");
    let mut all = vec![
        (
            "a long name",
            chain(3, &|joint| format!("{joint}{}", "n".repeat(255)), 1.0),
        ),
        ("long equal names", chain(3, &|_| "n".repeat(256), 1.0)),
        (
            "a longer name",
            chain(3, &|joint| format!("{joint}{}", "n".repeat(400)), 1.0),
        ),
        ("a deep chain", chain(1024, &plain, 0.1)),
        ("a deeper chain", chain(1025, &plain, 0.1)),
        ("a far joint", chain(3, &plain, 9e17)),
        ("a farther joint", chain(3, &plain, 2e18)),
    ];
    for (what, frames, rate) in [
        ("a long take", 608_331, 30.0),
        ("few frames a second", 3, 1e-4),
        ("many frames a second", 3, 1e6),
        ("more frames a second", 3, 1e7),
    ] {
        let mut scene = chain(3, &plain, 0.1);
        scene.animations.push(sparse(&scene, frames, rate));
        all.push((what, scene));
    }
    for far in [9.9e17_f32, 1.4e18] {
        let mut scene = chain(2, &plain, 0.1);
        let mut clip = sparse(&scene, 2, 30.0);
        clip.channels[0].position_keys = Keys::every_tick(vec![Vec3::ZERO, Vec3::new(far, 0.0, far)]);
        scene.animations.push(clip);
        all.push(("a far key", scene));
    }
    all
}

#[test]
fn what_a_writer_writes_its_reader_reads() {
    let (mut written, mut refused) = (0, 0);
    for (what, scene) in scenes() {
        // Other formats store a value for every frame, so a small file cannot contain a long take.
        let is_tried = |format: Format| what != "a long take" || format == Format::Gltf;
        for row in FormatInfo::ALL
            .iter()
            .filter(|row| row.writes() && is_tried(row.format))
        {
            let name = format!("out.{}", row.extensions[0]);
            let exporter = Exporter::new().buffer(BufferPlace::Embedded);
            match exporter.write_as(&scene, &name) {
                Err(error) => {
                    refused += 1;
                    assert_ne!(error.code(), Code::Io, "{what}: {name}: {error}");
                }
                Ok(files) => {
                    written += 1;
                    let read = Importer::new().read(&files.into_bytes().unwrap(), &name);
                    assert!(read.is_ok(), "{what}: {name}: {}", read.unwrap_err());
                }
            }
        }
    }
    assert!(written > 20 && refused > 20, "{written} written, {refused} refused");
}

/// A caller can build scenes that no reader returns.
#[test]
fn no_format_writes_a_take_without_end() {
    let mut scene = chain(3, &|joint| format!("j{joint}"), 0.1);
    let clip = sparse(&scene, 2, 30.0);
    scene.animations.push(clip);
    for end in [1e20, 1e12, f64::INFINITY, f64::NAN, -1.0] {
        let clip = &mut scene.animations[0];
        clip.duration = end;
        clip.channels[1].rotation_keys.ticks = Some(vec![0.0, end]);
        let expected = match end >= 1e12 && end.is_finite() {
            true => Code::LimitExceeded,
            false => Code::InvalidValue,
        };
        let error = Conversion::new().apply(&mut scene.clone()).unwrap_err();
        assert_eq!(error.code(), expected, "{end}: {error}");
        for row in FormatInfo::ALL.iter().filter(|row| row.writes()) {
            let error = Exporter::new().write(&scene, row.format).unwrap_err();
            assert_eq!(error.code(), expected, "{end}: {}: {error}", row.name);
        }
    }
}

/// A chain is not a humanoid, so the scenes above cannot be VRM animations.
#[test]
fn hips_far_from_the_floor_are_refused_or_read_again_in_a_vrm_animation() {
    for (far, is_written) in [(1e3_f32, true), (1.4e18, false)] {
        let mut scene = Importer::new().import("../../fixtures/real/cmu_short.bvh").unwrap();
        Conversion::new().apply(&mut scene).unwrap();
        let keys = &mut scene.animations[0].channels[0].position_keys;
        *keys.values.last_mut().unwrap() = Vec3::new(far, 1.0, far);
        match Exporter::new().write(&scene, Format::Vrma) {
            Ok(files) => {
                let read = Importer::new().read(&files.into_bytes().unwrap(), "out.vrma");
                assert!(is_written && read.is_ok(), "{far}: {:?}", read.err());
            }
            Err(error) => {
                assert!(!is_written, "{far}: {error}");
                let said = error.to_string();
                assert!(said.contains("the reader would refuse the file"), "{said}");
            }
        }
    }
}

#[test]
fn a_character_with_a_take_that_cannot_be_read_is_not_written() {
    let character = Importer::new()
        .import_character("../../fixtures/characters/human_default.glb")
        .unwrap();
    let read = |bytes: &[u8]| Importer::new().read(bytes, "out.glb");
    for (frames, is_written) in [(100, true), (6_083_310, false)] {
        let clip = sparse(character.scene(), frames, 30.0);
        match character.with_animations(&[clip], false) {
            Ok(bytes) => assert!(is_written && read(&bytes).is_ok(), "{frames}"),
            Err(error) => {
                assert!(!is_written, "{frames}: {error}");
                assert_eq!(error.code(), Code::LimitExceeded);
                let said = error.to_string();
                assert!(said.contains("the reader would refuse the file"), "{said}");
            }
        }
    }
}
