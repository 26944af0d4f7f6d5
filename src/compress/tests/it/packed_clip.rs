//! Packed clips: the bound at every frame, poses between frames, and broken bytes.

use mocap::compress::{ErrorBound, PackedClip};
use mocap::glam::{DQuat, DVec3, Mat4, Quat, Vec3};
use mocap::scene::{Animation, Channel, Format, Keys, Node, NodeId, Scene, UpAxis};
use mocap::{Binding, Code, Conversion, Importer, Limits, SkeletonMesh, Trs};

use crate::sample::Sample;

fn import(file: &str) -> Scene {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
    let mut scene = importer.import(format!("../../fixtures/real/{file}")).unwrap();
    Conversion::new().apply(&mut scene).unwrap();
    scene
}

/// The position of every node, in double precision.
fn places(scene: &Scene, pose: &[Trs]) -> Vec<DVec3> {
    world(scene, pose).into_iter().map(|(place, _)| place).collect()
}

/// The position and the rotation of every node, in double precision.
fn world(scene: &Scene, pose: &[Trs]) -> Vec<(DVec3, DQuat)> {
    let mut world: Vec<(DVec3, DQuat)> = Vec::new();
    for (node, local) in std::iter::zip(&scene.nodes, pose) {
        let (translation, rotation) = (local.translation.as_dvec3(), local.rotation.as_dquat().normalize());
        world.push(match node.parent.map(|parent| world[parent.index()]) {
            None => (translation, rotation),
            Some((place, turn)) => (place + turn * translation, turn * rotation),
        });
    }
    world
}

/// The pose of the source.
fn expected(scene: &Scene, tick: f64) -> Vec<Trs> {
    let animation = &scene.animations[0];
    let mut pose: Vec<Trs> = scene
        .nodes
        .iter()
        .map(|node| Trs::from_matrix(node.transform))
        .collect();
    Binding::new(scene, animation).sample(animation, tick, |node, trs| pose[node.index()] = trs);
    pose
}

fn sampled(clip: &PackedClip<'_>, tick: f64) -> Vec<Trs> {
    let mut pose = vec![Trs::IDENTITY; clip.node_count()];
    clip.sample(tick, &mut pose);
    pose
}

/// The largest distance of a joint from its expected position at a tick.
fn error_at(scene: &Scene, clip: &PackedClip<'_>, tick: f64) -> f64 {
    let [expected, found] = [expected(scene, tick), sampled(clip, tick)].map(|pose| places(scene, &pose));
    std::iter::zip(expected, found)
        .map(|(a, b)| a.distance(b))
        .fold(0.0, f64::max)
}

#[test]
fn no_joint_is_farther_from_its_place_than_the_bound() {
    for (file, frames) in [
        ("cmu_12_01_walk.bvh", 524),
        ("additive_root_walk.bvh", 0),
        ("rotation_before_position.bvh", 0),
        ("kinect_openni.bvh", 0),
    ] {
        let scene = import(file);
        let mut bytes = usize::MAX;
        for bound in [0.0001, 0.002] {
            let clip = PackedClip::encode(&scene, 0, bound).unwrap();
            assert!(frames == 0 || clip.frame_count() == frames);
            let mut largest = 0.0;
            for frame in 0..scene.animations[0].frame_count() {
                largest = f64::max(largest, error_at(&scene, &clip, frame as f64));
            }
            assert!(largest <= bound, "{file}: {largest} m at {bound} m");
            assert!((largest - clip.max_error()).abs() < 0.05 * bound, "{file}: {largest}");
            // In a clip with a few frames, tables take most of the bytes.
            assert!(
                clip.bytes().len() < bytes.saturating_add(16),
                "{file}: a larger error takes more bytes"
            );
            bytes = clip.bytes().len();
            // The statements of the clip about the skeleton.
            for (index, node) in scene.nodes.iter().enumerate() {
                assert_eq!(clip.name(index), node.name);
                assert_eq!(clip.parent(index), node.parent.map(NodeId::index));
            }
        }
    }
}

#[test]
fn a_shell_keeps_the_bound_too() {
    let scene = import("z_up_dab.bvh");
    let error = |shell_distance: f64| {
        let bound = ErrorBound::new(0.001).shell_distance(shell_distance);
        let clip = PackedClip::encode(&scene, 0, bound).unwrap();
        let points = |pose: Vec<Trs>| -> Vec<DVec3> {
            let of_node = |(place, turn): (DVec3, DQuat)| DVec3::AXES.map(|axis| place + turn * axis * 0.03);
            world(&scene, &pose).into_iter().flat_map(of_node).collect()
        };
        let error_at = |frame| {
            let tick = frame as f64;
            let [expected, found] = [expected(&scene, tick), sampled(&clip, tick)].map(points);
            std::iter::zip(expected, found)
                .map(|(a, b)| a.distance(b))
                .fold(0.0, f64::max)
        };
        let largest = (0..clip.frame_count()).map(error_at).fold(0.0, f64::max);
        (largest, clip.max_error())
    };
    let (without, _) = error(0.0);
    let (with, said) = error(0.03);
    assert!(
        without > 0.0012 && with <= 0.001 && with <= said + 1e-6,
        "{without}, {with}, {said}"
    );
}

/// A pose between two frames lies between the poses of these frames. Sampling in any order gives the same poses.
#[test]
fn any_tick_can_be_sampled_in_any_order() {
    let scene = import("cmu_12_01_walk.bvh");
    let clip = PackedClip::encode(&scene, 0, 0.0001).unwrap();
    let last = clip.duration();
    assert_eq!(last, 523.0);
    let mut order = Sample::new();
    for _ in 0..500 {
        // The first frame is a T-pose, far from the next.
        let tick = 1.0 + order.below(522 * 4) as f64 / 4.0;
        let error = error_at(&scene, &clip, tick);
        // The source is interpolated along the arc, and the clip component by component. The difference is far below
        // this limit.
        assert!(error <= 0.00015, "{tick}: {error}");
    }
    for (tick, same) in [
        (-1.0, 0.0),
        (f64::NAN, 0.0),
        (f64::NEG_INFINITY, 0.0),
        (1e300, last),
        (f64::INFINITY, last),
    ] {
        assert_eq!(sampled(&clip, tick), sampled(&clip, same), "{tick}");
    }
    // A list that is too short is extended.
    let mut short = [Trs::IDENTITY; 3];
    clip.sample(77.0, &mut short);
    assert_eq!(short[..], sampled(&clip, 77.0)[..3]);
}

/// A chain of joints with keys at the given ticks.
fn chain(ticks: &[f64], turn: impl Fn(usize, f64) -> Quat) -> Scene {
    let mut scene = Scene::default();
    let mut animation = Animation {
        ticks_per_second: 50.0,
        duration: ticks.last().copied().unwrap_or(0.0),
        ..Animation::default()
    };
    for index in 0usize..11 {
        let name = format!("joint {index}");
        scene.nodes.push(Node {
            name: name.clone(),
            parent: index.checked_sub(1).map(NodeId::new),
            transform: Mat4::from_translation(Vec3::new(0.1, 0.02, 0.0)),
            ..Node::default()
        });
        let values: Vec<Quat> = ticks.iter().map(|tick| turn(index, *tick)).collect();
        animation.channels.push(Channel {
            node_name: name,
            node: None,
            position_keys: Keys::default(),
            rotation_keys: Keys {
                values,
                ticks: Some(ticks.to_vec()),
            },
            scaling_keys: Keys::default(),
        });
    }
    scene.metadata.metres_per_unit = Some(1.0);
    scene.animations.push(animation);
    scene
}

/// Joints that rotate by full turns, so that the dropped component changes within a block.
#[test]
fn joints_that_turn_round_and_keys_at_any_tick_keep_the_bound() {
    let turning = |index: usize, tick: f64| Quat::from_rotation_y((tick * 0.07 * (1.0 + index as f64)) as f32);
    let mut ticks: Vec<f64> = (0..300).map(f64::from).collect();
    for between in [false, true] {
        if between {
            ticks.extend([0.25, 17.5, 280.125]);
            ticks.sort_unstable_by(f64::total_cmp);
        }
        let scene = chain(&ticks, turning);
        for bound in [0.0001, 0.02] {
            let clip = PackedClip::encode(&scene, 0, bound).unwrap();
            for tick in &ticks {
                let error = error_at(&scene, &clip, *tick);
                assert!(error <= bound, "{tick}: {error}");
            }
        }
    }
}

#[test]
fn a_clip_without_motion_has_its_pose() {
    let scene = chain(&[0.0, 1.0, 2.0], |_, _| Quat::from_rotation_x(0.5));
    let clip = PackedClip::encode(&scene, 0, 0.001).unwrap();
    assert!(error_at(&scene, &clip, 1.5) < 1e-6);
    assert_eq!((clip.duration(), clip.ticks_per_second()), (2.0, 50.0));
    let missing = PackedClip::encode(&scene, 1, 0.001).unwrap_err();
    assert_eq!(missing.code(), Code::Unrepresentable);
}

/// Whether the bytes give an error, or a clip that can be sampled.
fn survives(bytes: &[u8]) -> bool {
    let Ok(clip) = PackedClip::new(bytes) else { return false };
    for tick in [0.0, 1.3, 63.9, 64.0, f64::MAX, f64::NAN, clip.duration()] {
        sampled(&clip, tick);
    }
    (0..clip.node_count()).all(|node| clip.parent(node).is_none_or(|parent| parent < node))
}

#[test]
fn broken_bytes_are_refused_or_harmless() {
    let ticks: Vec<f64> = (0..150).map(f64::from).collect();
    let waving = |index: usize, tick: f64| Quat::from_rotation_y((tick * 0.05 + index as f64).sin() as f32);
    let mut random = Sample::new();
    for bound in [0.0005, 0.01] {
        let clip = PackedClip::encode(&chain(&ticks, waving), 0, bound).unwrap();
        let whole = clip.bytes();
        assert!(survives(whole));
        for end in 0..whole.len() {
            assert_eq!(
                PackedClip::new(&whole[..end]).unwrap_err().code(),
                Code::InvalidClip,
                "{end} bytes"
            );
        }
        let mut longer = whole.to_vec();
        longer.push(0);
        assert!(!survives(&longer));
        for byte in 0..whole.len() {
            for change in [1, 0xff] {
                let mut changed = whole.to_vec();
                changed[byte] ^= change;
                survives(&changed);
            }
        }
        for _ in 0..500 {
            let mut changed = whole.to_vec();
            for _ in 0..3 {
                let place = random.below(changed.len());
                changed[place] = random.below(256) as u8;
            }
            survives(&changed);
        }
    }
    assert_eq!(
        PackedClip::new(&b"HIERARCHY"[..]).unwrap_err().code(),
        Code::InvalidClip
    );
}

/// A clip is read like any other file: it has the same skeleton, and every frame has the pose that is sampled from the
/// clip.
#[test]
fn a_packed_clip_is_an_input() {
    for (file, bound) in [("cmu_12_01_walk.bvh", 0.001), ("kinect_openni.bvh", 0.00002)] {
        let source = import(file);
        let clip = PackedClip::encode(&source, 0, bound).unwrap();
        // The bytes determine the format, whatever the name of the file is.
        let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
        let read = importer.read(clip.bytes(), "walk").unwrap();
        assert_eq!(read.metadata.format, Some(Format::Mclip));
        assert_eq!(
            (read.metadata.metres_per_unit, read.metadata.up),
            (Some(1.0), Some(UpAxis::Y))
        );
        assert_eq!(read.nodes.len(), source.nodes.len());
        for (a, b) in std::iter::zip(&read.nodes, &source.nodes) {
            assert_eq!((&a.name, a.parent, a.kind), (&b.name, b.parent, b.kind));
        }
        let (a, b) = (&read.animations[0], &source.animations[0]);
        assert_eq!((a.ticks_per_second, a.duration), (b.ticks_per_second, b.duration));
        for tick in (0..b.frame_count()).map(|frame| frame as f64) {
            let [here, there] = [expected(&source, tick), expected(&read, tick)].map(|pose| places(&source, &pose));
            let farthest = std::iter::zip(here, there)
                .map(|(a, b)| a.distance(b))
                .fold(0.0, f64::max);
            assert!(farthest <= bound, "{file}, {tick}: {farthest}");
        }
    }
}

/// A clip of a chain, small enough to damage every byte.
fn small_clip() -> Vec<u8> {
    let mut ticks: Vec<f64> = (0..70).map(f64::from).collect();
    ticks.insert(3, 2.5);
    let waving = |index: usize, tick: f64| Quat::from_rotation_y((tick * 0.05 + index as f64).sin() as f32);
    let clip = PackedClip::encode(&chain(&ticks, waving), 0, 0.02).unwrap();
    clip.bytes().to_vec()
}

#[test]
fn a_damaged_file_is_an_error_or_a_valid_scene() {
    let importer = Importer::new().skeleton_mesh(SkeletonMesh::None).hash(false);
    let read = |bytes: &[u8]| importer.read(bytes, "damaged");
    let whole = small_clip();
    assert_eq!(read(&whole).unwrap().animations[0].channels.len(), 11);
    for end in 0..whole.len() {
        let error = read(&whole[..end]).unwrap_err();
        let code = if end < 4 {
            Code::UnknownFormat
        } else {
            Code::InvalidClip
        };
        assert_eq!(error.code(), code, "{end} bytes: {error}");
    }
    for place in 0..whole.len() {
        for change in [1, 0x10, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[place] ^= change;
            if let Ok(scene) = read(&bytes) {
                assert_eq!(scene.validate(), [], "byte {place} ^ {change}");
            }
        }
    }
}

/// The header may state any number of frames, nodes, tracks and bytes.
#[test]
fn a_count_that_is_not_there_is_refused() {
    let still = PackedClip::encode(&chain(&[0.0, 1.0], |_, _| Quat::IDENTITY), 0, 0.001).unwrap();
    for bytes in [small_clip(), still.bytes().to_vec()] {
        let place = |of: &str| {
            [
                ("nodes", 8),
                ("frames", 12),
                ("rotations", 36),
                ("translations", 40),
                ("names", 44),
            ]
            .into_iter()
            .find(|(name, _)| *name == of)
            .unwrap()
            .1
        };
        for what in ["nodes", "frames", "rotations", "translations", "names"] {
            let mut bytes = bytes.clone();
            bytes[place(what)..][..4].copy_from_slice(&1_000_000_000u32.to_le_bytes());
            if what == "frames" {
                bytes[24..32].copy_from_slice(&999_999_999f64.to_le_bytes());
            }
            let error = Importer::new().read(&bytes, "lies.mclip").unwrap_err();
            assert!(
                matches!(error.code(), Code::InvalidClip | Code::LimitExceeded),
                "{what}: {error}"
            );
        }
    }
    let tight = Limits::new().max_depth(5);
    let error = Importer::new()
        .limits(tight)
        .read(&small_clip(), "deep.mclip")
        .unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded);
}

#[test]
fn what_a_damaged_file_says_names_the_place() {
    let whole = small_clip();
    let said = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = whole.clone();
        change(&mut bytes);
        Importer::new().read(&bytes, "walk.mclip").unwrap_err().to_string()
    };
    assert_eq!(
        said(&|bytes| bytes[4] = 3),
        "walk.mclip: error[invalid-clip]: this version of packed clips cannot be read; expected 1 or 2; found 3"
    );
    assert_eq!(
        said(&|bytes| bytes.truncate(100)),
        "walk.mclip: error[invalid-clip]: a table is longer than the file; \
         expected at most 48 bytes from byte 52; found 11 entries of 5 bytes"
    );
    // The second node.
    assert_eq!(
        said(&|bytes| bytes[57] = 7),
        "walk.mclip: error[invalid-clip]: the nodes are not in depth-first order; \
         expected node 1 as a child of the previous node or of its ancestors; found parent 7"
    );
    assert_eq!(
        said(&|bytes| bytes[24..32].copy_from_slice(&1e9f64.to_le_bytes())),
        "walk.mclip: error[invalid-clip]: the duration does not match the frames; \
         expected at least 69, and less than 1 above it; found 1000000000"
    );
}
