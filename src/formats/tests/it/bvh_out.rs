//! Scenes as BVH. Reading them gives the same keys, and an independent reader sees the same motion.

#![allow(clippy::unwrap_used, reason = "a failed assumption in a test is the test's failure")]

use std::fs;

use crate::cut;
use crate::kinematics::{Capture, Root, distance};
use crate::sample::Sample;
use mocap::bvh::{BvhOptions, Channels};
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Keys, Node, NodeId, NodeKind, RotationOrder, Scene};
use mocap::{Binding, Code, Importer, Pose, SkeletonMesh, Trs};

fn read(bytes: &[u8]) -> Scene {
    Importer::new()
        .skeleton_mesh(SkeletonMesh::None)
        .read(bytes, "written.bvh")
        .unwrap()
}

fn import(path: &str) -> Scene {
    Importer::new().skeleton_mesh(SkeletonMesh::None).import(path).unwrap()
}

fn written(scene: &Scene, options: &BvhOptions) -> String {
    String::from_utf8(options.write(scene).unwrap()).unwrap()
}

/// The longest motion that is written completely.
const WHOLE: usize = 150;

/// Every third BVH file of the fixtures that is not refused. Motions of at most [`WHOLE`] frames are complete. Of
/// longer motions, the test takes [`WHOLE`] frames from a random position.
fn real_files() -> Vec<(String, Scene)> {
    let mut random = Sample::new();
    let mut files = Vec::new();
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let entries = fs::read_dir("../../fixtures/real").unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "bvh"));
    paths.sort();
    assert!(paths.len() > 20);
    for path in random.some(paths, 3) {
        if let Ok(mut scene) = importer.import(&path) {
            let frames = scene.animations.first().map_or(0, Animation::frame_count);
            if frames > WHOLE {
                let first = random.below(frames - WHOLE);
                scene.trim(first as f64, (first + WHOLE - 1) as f64);
            }
            files.push((path.display().to_string(), scene));
        }
    }
    assert!(files.len() > 5);
    files
}

#[test]
fn real_files_read_back_to_identical_keys() {
    for (path, scene) in real_files() {
        let again = read(&BvhOptions::default().write(&scene).unwrap());
        assert_eq!(again.warnings, [], "{path}");
        assert_eq!(again.nodes.len(), scene.nodes.len(), "{path}");
        for (node, again) in scene.nodes.iter().zip(&again.nodes) {
            assert_eq!(
                (&again.name, again.kind, again.parent),
                (&node.name, node.kind, node.parent),
                "{path}"
            );
            assert_eq!(again.transform, node.transform, "{path}: {}", node.name);
            if let Some(order) = node.rotation_order {
                assert_eq!(again.rotation_order, Some(order), "{path}: {}", node.name);
            }
        }
        if scene.animations.is_empty() {
            continue;
        }
        let (animation, again) = (&scene.animations[0], &again.animations[0]);
        assert_eq!(again.ticks_per_second, animation.ticks_per_second, "{path}");
        assert_eq!(again.duration, animation.duration, "{path}");
        for (channel, again) in animation.channels.iter().zip(&again.channels) {
            let name = &channel.node_name;
            assert_eq!(&again.node_name, name, "{path}");
            for tick in (0..animation.frame_count()).map(|frame| frame as f64) {
                let (key, again) = (channel.sample(tick, Trs::IDENTITY), again.sample(tick, Trs::IDENTITY));
                assert_eq!(again.translation, key.translation, "{path}: {name} at {tick}");
                assert_eq!(again.scale, key.scale, "{path}: {name} at {tick}");
                // 1e-14 is the double precision of angles after some turns, and the remainder of half turns near zero.
                // If two components are equal, the sign of the quaternion depends on this rounding. Everything else is
                // equal bit by bit.
                let (key, again) = (key.rotation, again.rotation);
                let same = key.abs_diff_eq(again, 1e-14) || key.abs_diff_eq(-again, 1e-14);
                assert!(same, "{path}: {name} at {tick}: {key} became {again}");
            }
        }
    }
}

#[test]
fn an_independent_reader_sees_the_same_motion() {
    let mut random = Sample::new();
    for name in [
        "cmu_short",
        "perception_neuron_moving_positions",
        "cmu_mixed_rotation_orders",
        "lecture_Test",
    ] {
        let text = cut::some_frames(&mut random, &format!("real/{name}.bvh"), 75);
        let original = Capture::parse(text.as_bytes());
        let height = original.height(Root::Replace);
        for options in [
            BvhOptions::default(),
            BvhOptions::new().channels(Channels::Six),
            BvhOptions::new().order(Some(RotationOrder::Yzx)),
        ] {
            let again = Capture::parse(&options.write(&read(text.as_bytes())).unwrap());
            assert_eq!(
                (again.rows.len(), again.frame_time),
                (original.rows.len(), original.frame_time)
            );
            for frame in 0..original.rows.len() {
                let places = original.placements(frame, Root::Replace);
                for (place, again) in places.iter().zip(again.placements(frame, Root::Replace)) {
                    let error = distance(place.position, again.position);
                    assert!(error < 1e-6 * height, "{name} at {frame}, {options:?}: {error}");
                }
            }
        }
    }
}

#[test]
fn numbers_keep_the_decimals_of_the_file() {
    // This file has at most four decimals in angles, and five in positions and offsets.
    let source = cut::some_frames(&mut Sample::new(), "real/cmu_01_01.bvh", 500);
    let text = written(&read(source.as_bytes()), &BvhOptions::default());
    let (_, rows) = text.split_once("Frame Time:").unwrap();
    let words = rows.lines().skip(1).flat_map(str::split_whitespace);
    let long = words
        .clone()
        .filter(|word| word.split_once('.').is_some_and(|(_, decimals)| decimals.len() > 5))
        .count();
    let all = words.count();
    assert!(long * 1000 < all, "{long} of {all}");
}

#[test]
fn digits_are_what_was_asked_for() {
    let options = BvhOptions::new().digits(Some(2));
    let text = written(&import("../../fixtures/real/lecture_Test.bvh"), &options);
    assert!(text.contains("OFFSET 2.00 0.00 0.00\n"), "{text}");
    assert!(text.contains("\nFrame Time: 0.1\n0.10 0.00 0.00 "), "{text}");
    assert!(!text.contains("-0.00"), "{text}");
}

#[test]
fn channels_are_what_was_asked_for() {
    let counts = |name: &str, channels| {
        let scene = read(cut::first_frames(&format!("real/{name}.bvh"), 75).as_bytes());
        let options = BvhOptions::new().channels(channels);
        let text = written(&scene, &options);
        [3, 6].map(|count| text.matches(&format!("CHANNELS {count} ")).count())
    };
    // In one file all positions differ from the OFFSETs, in the other only the root's positions.
    let (moving, still) = ("perception_neuron_moving_positions", "cmu_short");
    assert_eq!(counts(moving, Channels::Auto), [0, 59]);
    assert_eq!(counts(moving, Channels::Three), [58, 1]);
    assert_eq!(counts(still, Channels::Auto), [30, 1]);
    assert_eq!(counts(still, Channels::Six), [0, 31]);
}

#[test]
fn every_order_turns_alike_and_without_jumps() {
    let scene = import("../../fixtures/real/cmu_short.bvh");
    for order in RotationOrder::ALL {
        let options = BvhOptions::new().order(Some(order));
        let again = read(&options.write(&scene).unwrap());
        for (channel, again) in scene.animations[0].channels.iter().zip(&again.animations[0].channels) {
            for (key, again) in channel.rotation_keys.values.iter().zip(&again.rotation_keys.values) {
                // The chord of two unit quaternions is half of the angle between the rotations.
                let (key, again) = (key.as_dquat(), again.as_dquat());
                let chord = (key - again).length().min((key + again).length());
                assert!(
                    (2.0 * chord).to_degrees() < 1e-4,
                    "{order:?}, {}: {key} {again}",
                    channel.node_name
                );
            }
        }
    }
    // Three turns about z, then back through the gimbal lock of the order.
    let angles = (0..=1080).map(|step| Quat::from_rotation_z(f64::from(step).to_radians() as f32));
    let capture = Capture::parse(&BvhOptions::default().write(&spinner(angles.collect())).unwrap());
    for (step, row) in capture.rows.iter().enumerate() {
        assert!((row[3] - step as f64).abs() < 1e-4, "{row:?} at {step}");
    }
    // Half a turn over the pole of Z X Y. Its middle angle passes 90 degrees, at which the outer two angles act about
    // one axis.
    let angles = (0..=180).map(|step| Quat::from_rotation_x(f64::from(step).to_radians() as f32));
    let capture = Capture::parse(&BvhOptions::default().write(&spinner(angles.collect())).unwrap());
    for (step, row) in capture.rows.iter().enumerate() {
        assert!(
            (row[4] - step as f64).abs() < 1e-3 && row[3].abs() + row[5].abs() < 1e-3,
            "{row:?} at {step}"
        );
    }
}

/// A scene with one rotating joint.
fn spinner(rotations: Vec<Quat>) -> Scene {
    let duration = (rotations.len() - 1) as f64;
    let channel = Channel {
        node_name: "top".to_owned(),
        rotation_keys: Keys::every_tick(rotations),
        ..Channel::default()
    };
    Scene {
        nodes: vec![Node {
            name: "top".to_owned(),
            ..Node::default()
        }],
        animations: vec![Animation {
            duration,
            ticks_per_second: 30.0,
            channels: vec![channel],
            ..Animation::default()
        }],
        ..Scene::default()
    }
}

#[test]
fn rest_rotations_and_constant_scales_change_no_place() {
    let turned = Mat4::from_scale_rotation_translation(
        Vec3::splat(0.5),
        Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
        Vec3::new(1.0, 0.0, 0.0),
    );
    let node = |name: &str, parent, transform| Node {
        name: name.to_owned(),
        parent,
        transform,
        ..Node::default()
    };
    let group = Node {
        kind: NodeKind::Group,
        ..node("group", None, Mat4::IDENTITY)
    };
    let nodes = vec![
        group,
        node("hip {left}", Some(NodeId(0)), turned),
        node(
            "knee",
            Some(NodeId(1)),
            Mat4::from_translation(Vec3::new(4.0, 0.0, 0.0)),
        ),
    ];
    let scene = Scene {
        nodes,
        ..Scene::default()
    };
    let again = read(&BvhOptions::default().write(&scene).unwrap());
    let names: Vec<&str> = again.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["hip _left_", "knee"]);
    // The file has one frame, the rest pose. In it, the link has half of its length, and is rotated from x to y.
    let pose = Pose::at_tick(&again, 0, 0.0).unwrap();
    assert!(pose.position(NodeId(1)).abs_diff_eq(Vec3::new(1.0, 2.0, 0.0), 1e-6));
}

#[test]
fn acclaim_motions_become_bvh() {
    let scene = import("../../fixtures/real/cmu_02_01.amc");
    let animation = &scene.animations[0];
    let capture = Capture::parse(&BvhOptions::default().write(&scene).unwrap());
    let binding = Binding::new(&scene, animation);
    let mut pose = Pose::rest(&scene);
    let tolerance = 1e-5 * capture.height(Root::Replace);
    for frame in 0..animation.frame_count() {
        pose.sample(&binding, animation, frame as f64);
        for (place, matrix) in capture.placements(frame, Root::Replace).iter().zip(&pose.node_to_world) {
            let position = matrix.w_axis.truncate().as_dvec3().to_array();
            assert!(distance(place.position, position) < tolerance, "frame {frame}");
        }
    }
}

#[test]
fn several_roots_are_several_again() {
    let scene = import("../../fixtures/dialects/two_roots.bvh");
    let text = written(&scene, &BvhOptions::default());
    let heads: Vec<&str> = text.lines().filter(|line| line.contains("ROOT")).collect();
    assert_eq!(heads, ["ROOT hip", "ROOT arm"]);
    let again = read(text.as_bytes());
    assert_eq!(again.animations, scene.animations);
    let without_lines = |scene: &Scene| -> Vec<Node> {
        let nodes = scene.nodes.iter().cloned();
        nodes.map(|node| Node { source: None, ..node }).collect()
    };
    assert_eq!(without_lines(&again), without_lines(&scene));
    // The points of a C3D file stay one figure, also after glTF, because most programs read no second ROOT.
    let glb = mocap::gltf::GltfOptions::default().write_glb(&scene).unwrap();
    let between = Importer::new()
        .skeleton_mesh(SkeletonMesh::None)
        .read(&glb, "a.glb")
        .unwrap();
    assert_eq!(written(&between, &BvhOptions::default()).matches("ROOT ").count(), 2);
    let points = written(&import("../../fixtures/real/optotrak.c3d"), &BvhOptions::default());
    assert_eq!(points.matches("ROOT ").count(), 1);
}

#[test]
fn what_bvh_cannot_hold_is_refused() {
    let refused = |scene: &Scene| BvhOptions::default().write(scene).unwrap_err();
    assert_eq!(refused(&Scene::default()).code(), Code::Unrepresentable);
    let error = refused(&spinner(vec![Quat::IDENTITY, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)]));
    assert_eq!(
        error.to_string(),
        "error[unrepresentable]: the rotation in frame 1 is not valid; joint \"top\""
    );
}

#[test]
fn the_way_over_gltf_and_back_keeps_the_motion() {
    for (path, scene) in real_files() {
        let glb = mocap::gltf::GltfOptions::default().write_glb(&scene).unwrap();
        let between = Importer::new()
            .skeleton_mesh(SkeletonMesh::None)
            .read(&glb, "between.glb")
            .unwrap();
        let again = read(&BvhOptions::default().write(&between).unwrap());
        let (Some(animation), Some(animation_again)) = (scene.animations.first(), again.animations.first()) else {
            // In BVH a pose is a motion with one frame.
            assert!(scene.animations.is_empty(), "{path}");
            continue;
        };
        let frames = animation.frame_count();
        assert_eq!(animation_again.frame_count(), frames, "{path}");
        let names = |scene: &Scene| scene.nodes.iter().map(|node| node.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&again), names(&scene), "{path}");
        let (binding, binding_again) = (Binding::new(&scene, animation), Binding::new(&again, animation_again));
        let (mut pose, mut pose_again) = (Pose::rest(&scene), Pose::rest(&again));
        let height = height(&scene, &mut pose, &binding);
        for tick in (0..frames).map(|frame| frame as f64) {
            pose.sample(&binding, animation, tick);
            pose_again.sample(&binding_again, animation_again, tick);
            for (index, node) in scene.nodes.iter().enumerate() {
                let (id, name) = (NodeId::new(index), &node.name);
                let off = pose
                    .position(id)
                    .as_dvec3()
                    .distance(pose_again.position(id).as_dvec3());
                assert!(off <= 1e-6 * height, "{path}: {name} at {tick}: {off}, {height}");
            }
        }
        for (channel, again) in animation.channels.iter().zip(&animation_again.channels) {
            let name = &channel.node_name;
            assert_eq!(&again.node_name, name, "{path}");
            for tick in (0..frames).map(|frame| frame as f64) {
                let rotation = |channel: &Channel| channel.sample(tick, Trs::IDENTITY).rotation.as_dquat();
                let (key, again) = (rotation(channel), rotation(again));
                let chord = (key - again).length().min((key + again).length());
                let degrees = (2.0 * chord).to_degrees();
                assert!(degrees <= 1e-4, "{path}: {name} at {tick}: {degrees} degrees");
            }
        }
    }
}

/// The largest extent of the figure in its first frame.
fn height(scene: &Scene, pose: &mut Pose, binding: &Binding) -> f64 {
    pose.sample(binding, &scene.animations[0], 0.0);
    let places = || (0..scene.nodes.len()).map(|index| pose.position(NodeId::new(index)));
    let (least, most) = (places().reduce(Vec3::min).unwrap(), places().reduce(Vec3::max).unwrap());
    f64::from((most - least).max_element())
}

/// The joint's position differs from its OFFSET, and the joint has only one of three position channels. If all three
/// were written, with values near zero in all frames, a reader could add the values to the OFFSET.
#[test]
fn a_joint_that_stays_at_its_parent_does_so_when_it_is_written() {
    let text = "HIERARCHY\nROOT hip\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nJOINT arm\n{\n\
                OFFSET 1 0 0\nCHANNELS 3 Zrotation Xposition Yrotation\nEnd Site\n{\nOFFSET 3 0 0\n}\n}\n}\n\
                MOTION\nFrames: 2\nFrame Time: 0.1\n0 0 0 0 0 0\n0 0 0 0 0 0\n";
    let scene = read(text.as_bytes());
    let again = read(written(&scene, &BvhOptions::default()).as_bytes());
    for scene in [scene, again] {
        let animation = &scene.animations[0];
        let mut pose = Pose::rest(&scene);
        pose.sample(&Binding::new(&scene, animation), animation, 1.0);
        let arm = scene.nodes.iter().position(|node| node.name == "arm").unwrap();
        assert_eq!(pose.position(NodeId::new(arm)), Vec3::ZERO);
    }
}
