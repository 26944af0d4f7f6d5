//! Compressed files keep their error bound. `verify` reads every file back and compares it with its source in double
//! precision, by its own forward kinematics.

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use crate::sample::{Sample, is_all};
use mocap::compress::ErrorBound;
use mocap::glam::{Mat4, Vec3};
use mocap::gltf::report::Deviation;
use mocap::gltf::{Compression, Document, GltfOptions};

use mocap::scene::{Keys, Node, NodeId, Scene};
use mocap::verify::report::Verification;
use mocap::{Code, Conversion, Importer, Pose, SkeletonMesh};

/// The kinds of compression that this build can write.
fn compressions() -> Vec<Compression> {
    let mut all = vec![Compression::None, Compression::Int16];
    if cfg!(feature = "meshopt") {
        all.extend([Compression::Meshopt, Compression::MeshoptKhr]);
    }
    all
}

fn import(path: &str) -> Scene {
    let path = format!("../../fixtures/real/{path}");
    Importer::new().skeleton_mesh(SkeletonMesh::None).import(path).unwrap()
}

/// The scene in metres, as `mocap convert` converts it.
fn in_metres(source: &Scene) -> Scene {
    let mut scene = source.clone();
    Conversion::new().apply(&mut scene).unwrap();
    scene
}

fn options(compression: Compression, max_error: f64) -> GltfOptions {
    GltfOptions::new()
        .compression(compression)
        .error_bound(Some(max_error.into()))
}

/// The longest motion that is tested completely.
const WHOLE: usize = 300;

/// Every `parts`th real motion. Of motions with more than [`WHOLE`] frames, takes [`WHOLE`] frames from a random
/// position.
fn real_motions(random: &mut Sample, parts: usize) -> Vec<(String, Scene)> {
    let folder = PathBuf::from("../../fixtures/real");
    let mut paths: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    paths.sort();
    let is_motion = |path: &PathBuf| path.extension().is_some_and(|e| e == "bvh" || e == "amc" || e == "c3d");
    let read = |path: PathBuf| {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let scene = Importer::new().skeleton_mesh(SkeletonMesh::None).import(path).ok()?;
        Some((name, scene))
    };
    paths.retain(is_motion);
    assert!(paths.len() > 30, "{}", paths.len());
    let mut motions: Vec<_> = random.some(paths, parts).into_iter().filter_map(read).collect();
    for (_, scene) in &mut motions {
        let frames = scene.animations.first().map_or(0, mocap::scene::Animation::frame_count);
        if frames > WHOLE && !is_all() {
            let first = random.below(frames - WHOLE + 1);
            scene.trim(first as f64, (first + WHOLE - 1) as f64);
            // This part is compressed and compared, so `verify` must not trim it again.
            scene.metadata.steps.clear();
        }
    }
    motions
}

/// Files with links of 5 m and 2 m, in the inferred unit. At such lengths, a step of 16 bits is more than 0.1 mm.
const TOO_LONG_FOR_A_TENTH: [&str; 2] = ["repeated_offset_lines.bvh", "lecture_Test.bvh"];

/// Every fourth file in each container with one of four bounds; `tools/interop/check bounds` tests all files.
#[test]
fn the_bound_holds_on_every_real_file() {
    let mut random = Sample::new();
    let motions = real_motions(&mut random, 4);
    assert!(motions.len() > 5, "{}", motions.len());
    for (name, source) in &motions {
        let scene = in_metres(source);
        for compression in compressions() {
            let millimetres = [0.1, 1.0, 5.0, 20.0][random.below(4)];
            let what = format!("{name}, {compression:?}, {millimetres} mm");
            let bound = millimetres / 1000.0;
            let document = match Document::new(&scene, &options(compression, bound)) {
                Ok(document) => document,
                Err(error) => {
                    assert_eq!(error.code(), Code::ErrorBound, "{what}: {error}");
                    assert!(
                        millimetres == 0.1 && TOO_LONG_FOR_A_TENTH.contains(&&**name),
                        "{what}: {error}"
                    );
                    continue;
                }
            };
            let verified = Verification::of(source, &document.to_glb().unwrap()).unwrap();
            assert!(verified.max_error <= bound, "{what}: {verified:?}");
            assert!(
                verified.missing.is_empty() && verified.missing_end_sites.is_empty(),
                "{what}"
            );
            let frames = source
                .animations
                .first()
                .map_or(verified.frames, mocap::scene::Animation::frame_count);
            assert_eq!(verified.frames, frames, "{what}");
            if let Some(achieved) = &document.report().achieved {
                // The reported error is never below the real error. The difference is at most the difference between
                // decoders.
                assert!(
                    verified.max_error <= achieved.max_error + 2e-6,
                    "{what}: {verified:?}, {achieved:?}"
                );
            }
        }
    }
}

/// The largest distance of points from their expected positions. The points are attached to the nodes, `distance`
/// metres away.
fn shell_error(source: &Scene, compressed: &Scene, distance: f32) -> f32 {
    let points = |scene: &Scene, frame: usize| -> Vec<Vec3> {
        let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
        let of_node = |index| Vec3::AXES.map(|axis| pose.point_to_world(NodeId::new(index), axis * distance));
        (0..source.nodes.len()).flat_map(of_node).collect()
    };
    let error_at = |frame| {
        let (expected, found) = (points(source, frame), points(compressed, frame));
        std::iter::zip(expected, found)
            .map(|(a, b)| a.distance(b))
            .fold(0.0, f32::max)
    };
    (0..source.animations[0].frame_count())
        .map(error_at)
        .fold(0.0, f32::max)
}

/// The points that represent the skin are ACL's points, on the axes of every node.
#[test]
fn the_bound_holds_for_a_shell_where_one_is_asked_for() {
    const ROUNDING: f32 = 3e-6;
    for (file, bound, distance) in [("cmu_short.bvh", 0.001, 0.03), ("z_up_dab.bvh", 0.005, 0.1)] {
        let mut scene = in_metres(&import(file));
        scene.trim(0.0, 149.0);
        for compression in compressions() {
            let of_shell = |shell_distance| {
                let mut options = options(compression, bound);
                options.error_bound = Some(ErrorBound::new(bound).shell_distance(shell_distance));
                let document = Document::new(&scene, &options).unwrap();
                let glb = document.to_glb().unwrap();
                let achieved = document.report().achieved.clone().unwrap();
                let error = shell_error(&scene, &Importer::new().read(&glb, "a.glb").unwrap(), distance as f32);
                (error, achieved, glb.len())
            };
            let what = format!("{file}, {compression:?}");
            let (without, _, smaller) = of_shell(0.0);
            let (with, achieved, larger) = of_shell(distance);
            assert!(without > 1.2 * bound as f32 && smaller < larger, "{what}: {without}");
            assert!(with <= bound as f32 + ROUNDING, "{what}: {with}");
            assert!(achieved.max_error >= f64::from(with - ROUNDING), "{what}: {achieved:?}");
            assert!(
                scene.nodes.iter().any(|node| node.name == achieved.joint),
                "{what}: {achieved:?}"
            );
        }
    }
}

#[test]
fn a_shell_distance_is_a_length() {
    let scene = in_metres(&import("cmu_short.bvh"));
    for shell_distance in [-0.01, f64::NAN, f64::INFINITY, 1e300] {
        let mut options = options(Compression::Int16, 0.001);
        options.error_bound = Some(ErrorBound::new(0.001).shell_distance(shell_distance));
        assert_eq!(options.write_glb(&scene).unwrap_err().code(), Code::InvalidValue);
    }
    // At this length, no rotation keeps the bound.
    let mut options = options(Compression::Int16, 0.001);
    options.error_bound = Some(ErrorBound::new(0.001).shell_distance(1e30));
    assert_eq!(options.write_glb(&scene).unwrap_err().code(), Code::ErrorBound);
}

#[test]
fn sizes_are_what_they_are_meant_to_be() {
    let scene = in_metres(&import("cmu_01_01.bvh"));
    let mut limits = vec![(Compression::Int16, 1.0, 560_000)];
    if cfg!(feature = "meshopt") {
        limits.extend([
            (Compression::Meshopt, 1.0, 140_000),
            (Compression::Meshopt, 5.0, 80_000),
        ]);
    }
    let plain = GltfOptions::default().write_glb(&scene).unwrap().len();
    assert!(plain > 1_200_000);
    for (compression, millimetres, limit) in limits {
        let glb = options(compression, millimetres / 1000.0).write_glb(&scene).unwrap();
        assert!(glb.len() <= limit, "{compression:?}, {millimetres} mm: {}", glb.len());
    }
}

/// A joint has its own keys, unless shared keys of the whole pose are smaller: shared keys store their times once.
#[test]
fn keys_are_shared_where_that_is_smaller() {
    for (file, is_shared) in [
        ("mocopi_jump_six_channels.bvh", true),
        ("motionbuilder_vicon_walk.bvh", false),
    ] {
        let scene = in_metres(&import(file));
        let document = Document::new(&scene, &options(Compression::Int16, 0.025)).unwrap();
        let glb = document.to_glb().unwrap();
        assert_eq!(document.glb_len().unwrap(), glb.len());
        let read = gltf::Gltf::from_slice(&glb).unwrap();
        let samplers = read
            .animations()
            .flat_map(|animation| animation.samplers().collect::<Vec<_>>());
        // Counts only moving tracks. A track with one key has its own time.
        let moving = samplers.filter(|sampler| sampler.input().count() > 1);
        let clocks: BTreeSet<usize> = moving.map(|sampler| sampler.input().index()).collect();
        assert_eq!(clocks.len() == 1, is_shared, "{file}: {clocks:?}");
    }
}

/// The node does not move, has no parent and carries nothing.
#[test]
fn a_node_by_itself_stays_where_it_is() {
    let mut source = import("rokoko_dance.bvh");
    source.trim(0.0, 99.0);
    source.nodes.push(Node {
        name: "Marker".into(),
        transform: Mat4::from_translation(Vec3::new(100.0, 200.0, 300.0)),
        ..Node::default()
    });
    let scene = in_metres(&source);
    for compression in compressions() {
        let glb = options(compression, 0.005).write_glb(&scene).unwrap();
        let verified = Verification::of(&source, &glb).unwrap();
        assert!(verified.max_error <= 0.005, "{compression:?}: {verified:?}");
    }
}

#[test]
fn what_cannot_be_kept_is_an_error() {
    let mut scene = in_metres(&import("cmu_short.bvh"));
    scene.trim(0.0, 9.0);
    for compression in compressions() {
        let error = options(compression, 1e-8).write_glb(&scene).unwrap_err();
        assert_eq!(error.code(), Code::ErrorBound, "{compression:?}: {error}");
        assert!(error.joint().is_some());
        assert_eq!(error.diagnostic().expected.as_deref(), Some("0.000010 mm"), "{error}");
    }
}

/// The bones of this file are metres long. An earlier version of the writer kept bounds of 0.5 mm and 2 mm with 16
/// bits, but exceeded a bound of 1 mm.
#[test]
fn a_bound_is_kept_where_a_smaller_one_is() {
    let source = import("huesitos.fbx");
    let scene = in_metres(&source);
    for compression in compressions() {
        for millimetres in [0.5, 1.0, 2.0] {
            let bound = millimetres / 1000.0;
            let glb = options(compression, bound).write_glb(&scene).unwrap();
            let verified = Verification::of(&source, &glb).unwrap();
            assert!(
                verified.max_error <= bound,
                "{compression:?}, {millimetres} mm: {verified:?}"
            );
        }
    }
}

/// The first frame of CMU's conversions is a T-pose. The second frame belongs to the motion, and no pose lies between
/// the two frames.
#[test]
fn a_cut_stays_between_its_two_frames() {
    let source = import("cmu_short.bvh");
    let scene = in_metres(&source);
    for compression in compressions() {
        let glb = options(compression, 0.02).write_glb(&scene).unwrap();
        let read = Importer::new().read(&glb, "cut.glb").unwrap();
        let arm = |channel: &&mocap::scene::Channel| channel.node_name == "LeftArm";
        let keys = &read.animations[0].channels.iter().find(arm).unwrap().rotation_keys;
        assert!(
            (keys.tick(0), keys.tick(1)) == (0.0, 1.0),
            "{compression:?}: {}, {}",
            keys.tick(0),
            keys.tick(1)
        );
        // Frame 1 is the second frame of the motion itself, and is not interpolated from the T-pose.
        let mut motion_alone = in_metres(&source);
        motion_alone.trim(1.0, f64::INFINITY);
        let (here, there) = (
            Pose::at_tick(&read, 0, 1.0).unwrap(),
            Pose::at_tick(&motion_alone, 0, 0.0).unwrap(),
        );
        for index in 0..motion_alone.nodes.len() {
            let (a, b) = (here.position(NodeId::new(index)), there.position(NodeId::new(index)));
            assert!(a.distance(b) < 0.02, "{compression:?}, node {index}");
        }
    }
}

#[test]
fn the_report_says_how_far_and_where() {
    let source = import("z_up_dab.bvh");
    let scene = in_metres(&source);
    let document = Document::new(&scene, &options(Compression::Int16, 0.005)).unwrap();
    let Deviation {
        max_error,
        rms_error,
        joint,
        tick,
        keys,
        ..
    } = document.report().achieved.clone().unwrap();
    let verified = Verification::of(&source, &document.to_glb().unwrap()).unwrap();
    // `verify` normalizes quaternions. The reported error is the largest error of readers that normalize and readers
    // that do not.
    let is_nearly = |reported: f64, verified: f64| reported >= verified - 1e-7 && reported < verified * 1.02;
    assert!(is_nearly(max_error, verified.max_error), "{verified:?}, {max_error}");
    assert!(is_nearly(rms_error, verified.rms_error), "{verified:?}, {rms_error}");
    assert!(scene.nodes.iter().any(|node| node.name == joint));
    assert!(tick <= scene.animations[0].duration && keys > 100);
    assert_eq!(
        Document::new(&scene, &GltfOptions::default())
            .unwrap()
            .report()
            .achieved,
        None
    );
}

#[test]
fn a_scene_with_fewer_keys_stands_where_it_stood() {
    let before = in_metres(&import("rokoko_dance.bvh"));
    let mut after = before.clone();
    let error = mocap::compress::reduce_keys(&mut after, 0.002).unwrap();
    assert!(error <= 0.002);
    assert!(after.validate().is_empty());
    for frame in 0..before.animations[0].frame_count() {
        let [a, b] = [&before, &after].map(|scene| Pose::at_tick(scene, 0, frame as f64).unwrap());
        for index in 0..before.nodes.len() {
            let (a, b) = (a.position(NodeId::new(index)), b.position(NodeId::new(index)));
            assert!(
                a.distance(b) < 0.00201,
                "frame {frame}, node {index}: {}",
                a.distance(b)
            );
        }
    }
}

/// The JSON of a `.glb`.
fn json(glb: &[u8]) -> serde_json::Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

#[test]
fn a_small_file_leaves_out_what_a_reader_knows() {
    let path = "../../fixtures/real/cmu_short.bvh".to_owned();
    let with_mesh = in_metres(&Importer::new().import(path).unwrap());
    let bare = in_metres(&import("cmu_short.bvh"));
    for (scene, compression, has_matrices) in [
        (&bare, Compression::None, true),
        (&bare, Compression::Int16, false),
        (&with_mesh, Compression::Int16, true),
    ] {
        let json = json(&options(compression, 0.001).write_glb(scene).unwrap());
        let animation = &json["animations"][0];
        let samplers = animation["samplers"].as_array().unwrap();
        assert!(samplers.iter().all(|sampler| sampler.as_object().unwrap().len() == 2));
        assert_eq!(samplers.len(), animation["channels"].as_array().unwrap().len());
        // The file states the joints, although no mesh is bound to them.
        if let Some(skin) = json["skins"].get(0) {
            assert_eq!(skin["joints"].as_array().unwrap().len(), scene.nodes.len());
            assert_eq!(
                skin.get("inverseBindMatrices").is_some(),
                has_matrices,
                "{compression:?}"
            );
        }
        // Every decision is recorded. A small file omits the reasons.
        let assumptions = &json["asset"]["extras"]["mocap"]["assumptions"];
        let topics: Vec<_> = scene.metadata.assumptions.iter().map(|a| a.topic.to_string()).collect();
        let written: Vec<_> = assumptions.as_array().unwrap().iter().collect();
        assert_eq!(
            written.iter().map(|a| a["topic"].as_str().unwrap()).collect::<Vec<_>>(),
            topics
        );
        assert!(
            written
                .iter()
                .all(|a| a.get("reason").is_some() == (compression == Compression::None))
        );
    }
}

#[test]
fn a_scale_that_is_one_but_for_rounding_is_no_track() {
    let mut scene = in_metres(&import("cmu_short.bvh"));
    let frames = scene.animations[0].duration as usize + 1;
    let noise = |frame: usize| Vec3::new(1.0 + 1e-7 * (frame % 3) as f32, 1.0, 1.0 - 2e-7 * (frame % 2) as f32);
    let paths = |scene: &Scene| -> BTreeSet<String> {
        let json = json(&options(Compression::Int16, 0.001).write_glb(scene).unwrap());
        let channels = json["animations"][0]["channels"].as_array().unwrap();
        channels
            .iter()
            .map(|channel| channel["target"]["path"].as_str().unwrap().to_owned())
            .collect()
    };
    scene.animations[0].channels[3].scaling_keys = Keys::every_tick((0..frames).map(noise).collect());
    assert!(!paths(&scene).contains("scale"));
    let larger = |frame: usize| Vec3::ONE + 20.0 * (noise(frame) - Vec3::ONE);
    scene.animations[0].channels[3].scaling_keys = Keys::every_tick((0..frames).map(larger).collect());
    assert!(paths(&scene).contains("scale"));
}

#[test]
fn constant_rotations_of_a_small_file_have_few_decimals() {
    // If a skin keeps the rest pose, nodes take constant tracks.
    let importer = mocap::Importer::new().skeleton_mesh(mocap::SkeletonMesh::Skinned);
    let scene = in_metres(&importer.import("../../fixtures/real/rokoko_dance.bvh").unwrap());
    let json = json(&options(Compression::Int16, 0.001).write_glb(&scene).unwrap());
    let mut rotations = 0;
    for rotation in json["nodes"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|node| node["rotation"].as_array())
    {
        let numbers: Vec<f64> = rotation.iter().map(|number| number.as_f64().unwrap()).collect();
        let length = numbers.iter().map(|number| number * number).sum::<f64>().sqrt();
        assert!((length - 1.0).abs() < 1e-5, "{numbers:?}");
        assert!(
            numbers
                .iter()
                .all(|number| (number * 1e6 - (number * 1e6).round()).abs() < 1e-6),
            "{numbers:?}"
        );
        rotations += 1;
    }
    assert!(rotations > 20, "{rotations}");
}

/// Generated skeletons and motions that no capture has: short and long links, fast rotations, sliding joints.
#[test]
fn the_bound_holds_on_generated_motions() {
    use mocap::glam::{Mat4, Quat, Vec3};
    use mocap::scene::{Animation, Channel, Keys, Node, NodeKind};
    let mut seed = 7u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f32 / f32::from(1u16 << 15) / 256.0 - 1.0
    };
    for round in 0..40 {
        let joints = 1 + round % 9;
        let frames = [1, 2, 3, 17, 120][round % 5];
        let mut scene = Scene::default();
        let mut channels = Vec::new();
        for index in 0..joints {
            let length = [0.0, 0.02, 0.3, 1.5][(round + index) % 4];
            scene.nodes.push(Node {
                name: format!("j{index}"),
                kind: NodeKind::Joint,
                parent: index.checked_sub(1 + index % 2).map(NodeId::new),
                transform: Mat4::from_translation(Vec3::new(random(), random(), random()) * length),
                ..Node::default()
            });
            let speed = [0.0, 0.001, 0.05, 1.0][(round / 3 + index) % 4];
            let mut rotation = Quat::from_xyzw(random(), random(), random(), random()).normalize();
            let rotations = (0..frames).map(|_| {
                rotation = (rotation + Quat::from_xyzw(random(), random(), random(), random()) * speed).normalize();
                if random() < 0.0 { -rotation } else { rotation }
            });
            let rotation_keys = Keys::every_tick(rotations.collect());
            let mut position = scene.nodes[index].transform.w_axis.truncate();
            let slides = index == 0 || (round + index) % 5 == 0;
            let positions = (0..frames).map(|_| {
                position += Vec3::new(random(), random(), random()) * speed;
                position
            });
            channels.push(Channel {
                node_name: format!("j{index}"),
                position_keys: if slides {
                    Keys::every_tick(positions.collect())
                } else {
                    Keys::default()
                },
                rotation_keys,
                ..Channel::default()
            });
        }
        // A node may come before its parent's last child. Scenes have depth-first order.
        if !scene.validate().is_empty() {
            for index in 1..joints {
                scene.nodes[index].parent = Some(NodeId::new(index - 1));
            }
        }
        scene.animations.push(Animation {
            ticks_per_second: 60.0,
            duration: frames as f64 - 1.0,
            channels,
            ..Animation::default()
        });
        for compression in compressions() {
            for bound in [0.002, 0.02] {
                let what = format!("round {round}, {compression:?}, {bound} m");
                let glb = options(compression, bound)
                    .write_glb(&scene)
                    .unwrap_or_else(|error| panic!("{what}: {error}"));
                let verified = Verification::of(&scene, &glb).unwrap();
                assert!(verified.max_error <= bound, "{what}: {verified:?}");
            }
        }
    }
}

/// Three clips in one file, with a key at every frame. The second is shorter than the first, and the third is as long.
#[test]
fn clips_with_the_same_frames_share_their_times() {
    let mut source = import("z_up_dab.bvh");
    let first = source.animations[0].clone();
    let mut short = source.clone();
    short.trim(0.0, 100.0);
    let named = |animation: &mocap::scene::Animation, name: &str| mocap::scene::Animation {
        name: name.to_owned(),
        ..animation.clone()
    };
    source.animations.push(named(&short.animations[0], "short"));
    source.animations.push(named(&first, "twin"));
    let scene = in_metres(&source);
    // Without a bound, and within such a small bound, every frame has keys if keys are shared.
    let streams = |kind: &Compression| matches!(kind, Compression::Meshopt | Compression::MeshoptKhr);
    let bounded = compressions()
        .into_iter()
        .filter(streams)
        .map(|kind| options(kind, 2e-4));
    for options in std::iter::once(GltfOptions::default()).chain(bounded) {
        let (glb, compression) = (options.write_glb(&scene).unwrap(), options.compression);
        let json = json(&glb);
        let times = |animation: usize| -> BTreeSet<u64> {
            let samplers = json["animations"][animation]["samplers"].as_array().unwrap();
            samplers
                .iter()
                .map(|sampler| sampler["input"].as_u64().unwrap())
                .collect()
        };
        assert_eq!(times(0), times(2), "{compression:?}");
        let place = |animation: usize| {
            let longest = times(animation)
                .into_iter()
                .map(|accessor| &json["accessors"][accessor as usize])
                .max_by_key(|accessor| accessor["count"].as_u64())
                .unwrap();
            (
                longest["bufferView"].clone(),
                longest["byteOffset"].clone(),
                longest["count"].clone(),
            )
        };
        let (whole, beginning) = (place(0), place(1));
        assert_eq!((&whole.0, &whole.1), (&beginning.0, &beginning.1), "{compression:?}");
        let frames = first.duration.round() as u64 + 1;
        assert_eq!((whole.2, beginning.2), (frames.into(), 101.into()), "{compression:?}");
        let verified = Verification::of(&source, &glb).unwrap();
        assert!(verified.max_error <= 2e-4, "{compression:?}: {verified:?}");
    }
}

/// Nothing moves, so nothing is compressed, and every reader can open the file.
#[test]
fn a_clip_without_motion_needs_no_extension() {
    let scene = in_metres(&import("slimevr_headset_root.bvh"));
    for compression in compressions() {
        let json = json(&options(compression, 0.001).write_glb(&scene).unwrap());
        assert_eq!(json["animations"].as_array().unwrap().len(), 1, "{compression:?}");
        assert_eq!(json["extensionsRequired"], serde_json::Value::Null, "{compression:?}");
    }
}

#[test]
fn a_build_without_meshopt_says_so() {
    let text = br#"{"asset":{"version":"2.0"},"extensionsUsed":["EXT_meshopt_compression"],
        "extensionsRequired":["EXT_meshopt_compression"],"nodes":[{}],"scenes":[{"nodes":[0]}],"scene":0,
        "buffers":[{"byteLength":32,"extensions":{"EXT_meshopt_compression":{"fallback":true}}},
            {"byteLength":8,"uri":"data:application/octet-stream;base64,AAAAAAAAAAA="}],
        "bufferViews":[{"buffer":0,"byteLength":32,"extensions":{"EXT_meshopt_compression":
            {"buffer":1,"byteLength":8,"byteStride":4,"count":8,"mode":"ATTRIBUTES"}}}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR"},
            {"bufferView":0,"byteOffset":8,"componentType":5126,"count":2,"type":"VEC3"}],
        "animations":[{"samplers":[{"input":0,"output":1}],
            "channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}]}"#;
    let read = Importer::new().read(text, "needs_meshopt.gltf");
    let scene = in_metres(&import("cmu_short.bvh"));
    let written = options(Compression::Meshopt, 0.001).write_glb(&scene);
    if cfg!(feature = "meshopt") {
        assert!(written.is_ok());
    } else {
        for error in [read.unwrap_err(), written.unwrap_err()] {
            assert_eq!(error.code(), Code::MissingFeature, "{error}");
            assert!(
                error
                    .diagnostic()
                    .help
                    .as_ref()
                    .is_some_and(|help| help.contains("the feature `meshopt`"))
            );
        }
    }
}

#[cfg(feature = "meshopt")]
mod streams {
    use serde_json::Value;

    use super::*;

    /// The JSON text of a `.glb`, and its buffer.
    fn parts(glb: &[u8]) -> (Value, Vec<u8>) {
        let glb = gltf::binary::Glb::from_slice(glb).unwrap();
        (
            serde_json::from_slice(&glb.json).unwrap(),
            glb.bin.unwrap().into_owned(),
        )
    }

    fn glb(json: &Value, bin: &[u8]) -> Vec<u8> {
        let glb = gltf::binary::Glb {
            header: gltf::binary::Header {
                magic: *b"glTF",
                version: 2,
                length: 0,
            },
            json: serde_json::to_vec(json).unwrap().into(),
            bin: Some(bin.into()),
        };
        glb.to_vec().unwrap()
    }

    fn small(compression: Compression) -> (Value, Vec<u8>) {
        let mut scene = in_metres(&import("cmu_short.bvh"));
        scene.trim(0.0, 40.0);
        parts(&options(compression, 0.001).write_glb(&scene).unwrap())
    }

    #[test]
    fn they_are_what_the_extension_asks_for() {
        for (compression, name, header) in [
            (Compression::Meshopt, "EXT_meshopt_compression", 0xa0),
            (Compression::MeshoptKhr, "KHR_meshopt_compression", 0xa1),
        ] {
            let (json, bin) = small(compression);
            assert_eq!(json["extensionsUsed"], serde_json::json!([name]));
            assert_eq!(json["extensionsRequired"], serde_json::json!([name]));
            let buffers = json["buffers"].as_array().unwrap();
            assert_eq!(buffers.len(), 2);
            assert!(buffers[1].get("uri").is_none());
            assert_eq!(buffers[1]["extensions"][name]["fallback"], true);
            let mut filters = Vec::new();
            for view in json["bufferViews"].as_array().unwrap() {
                let length = view["byteLength"].as_u64().unwrap();
                let start = view["byteOffset"].as_u64().unwrap_or(0);
                let Some(stream) = view["extensions"].get(name) else {
                    assert_eq!(view["buffer"], 0);
                    continue;
                };
                assert_eq!((&view["buffer"], &stream["buffer"]), (&1.into(), &0.into()));
                assert!(view.get("byteStride").is_none(), "tracks of an animation have none");
                assert!(start + length <= buffers[1]["byteLength"].as_u64().unwrap());
                let number = |key: &str| stream[key].as_u64().unwrap();
                assert_eq!(length, number("byteStride") * number("count"));
                assert_eq!((number("byteStride") % 4, start % 4), (0, 0));
                assert!(number("byteOffset") + number("byteLength") <= bin.len() as u64);
                assert_eq!(stream["mode"], "ATTRIBUTES");
                assert_eq!(bin[number("byteOffset") as usize], header, "the version of the stream");
                filters.push((number("byteStride"), stream.get("filter").cloned()));
            }
            filters.sort_by_key(|(stride, _)| *stride);
            // Times have no filter, so they lose nothing.
            let expected = [
                (4, None),
                (8, Some("QUATERNION".into())),
                (12, Some("EXPONENTIAL".into())),
            ];
            assert_eq!(filters, expected);
            for accessor in json["accessors"].as_array().unwrap() {
                assert_eq!(accessor["byteOffset"].as_u64().unwrap_or(0) % 4, 0);
            }
        }
    }

    #[test]
    fn damaged_ones_are_an_error_or_another_motion() {
        let (json, bin) = small(Compression::Meshopt);
        let read = |json: &Value, bin: &[u8]| Importer::new().read(&glb(json, bin), "damaged.glb");
        assert!(read(&json, &bin).is_ok());
        // The first bytes of each stream are always tested, and every eighth of the others.
        let views = json["bufferViews"].as_array().unwrap().iter();
        let starts: Vec<u64> = views
            .filter_map(|view| view["extensions"]["EXT_meshopt_compression"]["byteOffset"].as_u64())
            .collect();
        assert!(starts.len() > 2, "{json}");
        let heads = starts.iter().flat_map(|start| *start as usize..*start as usize + 4);
        for place in heads.chain(Sample::new().some(0..bin.len(), 8)) {
            for change in [0x01, 0x80, 0xff] {
                let mut damaged = bin.clone();
                damaged[place] ^= change;
                if let Ok(scene) = read(&json, &damaged) {
                    assert!(scene.validate().is_empty(), "byte {place}");
                }
            }
        }
    }

    #[test]
    fn false_claims_about_them_are_errors() {
        let (json, bin) = small(Compression::MeshoptKhr);
        let place = json["bufferViews"]
            .as_array()
            .unwrap()
            .iter()
            .position(|view| view["extensions"]["KHR_meshopt_compression"]["filter"] == "QUATERNION")
            .unwrap();
        let claims: [(&str, Value); 14] = [
            ("count", 0.into()),
            ("count", 1.into()),
            ("count", (1u64 << 40).into()),
            ("count", u64::MAX.into()),
            ("count", (-1).into()),
            ("byteStride", 0.into()),
            ("byteStride", 7.into()),
            ("byteStride", 16.into()),
            ("byteLength", 0.into()),
            ("byteLength", u64::MAX.into()),
            ("byteOffset", (1u64 << 33).into()),
            ("buffer", 1.into()),
            ("filter", "OCTAHEDRAL".into()),
            ("mode", "TRIANGLES".into()),
        ];
        for (key, value) in claims {
            let mut json = json.clone();
            json["bufferViews"][place]["extensions"]["KHR_meshopt_compression"][key] = value.clone();
            let error = Importer::new().read(&glb(&json, &bin), "false.glb").unwrap_err();
            assert_eq!(error.code(), Code::InvalidGltf, "{key}: {value}: {error}");
        }
    }
}
