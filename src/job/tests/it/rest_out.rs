//! Tests of the T-pose as the rest pose of an output, and as its first frame. The poses of BVH are read here from its
//! text: if all rotations are zero, joints are at the sums of their OFFSETs.

use std::collections::HashMap;

use mocap::convert::RestPoseSource;
use mocap::edit::{EditStep, StepInput};
use mocap::glam::Vec3;
use mocap::gltf::report::Provenance;
use mocap::scene::Format;
use mocap::verify::Verifier;
use mocap::{Code, Conversion, Exporter, Importer, Pose, Scene};

use crate::cut;
use crate::sample::Sample;

/// A rest pose with most bones along +X, a standing rest pose with +Z up, a rest pose that is no pose of a person, and
/// CMU's rest pose.
const FILES: [(&str, [&str; 6]); 4] = [
    (
        "real/rokoko_dance.bvh",
        ["LeftArm", "LeftHand", "RightArm", "RightHand", "LeftUpLeg", "LeftFoot"],
    ),
    (
        "real/z_up_dab.bvh",
        ["LeftArm", "LeftHand", "RightArm", "RightHand", "LeftUpLeg", "LeftFoot"],
    ),
    (
        "skeletons/accad_run_turn.bvh",
        ["LeftArm", "LeftHand", "RightArm", "RightHand", "LeftUpLeg", "LeftFoot"],
    ),
    (
        "real/cmu_01_01.bvh",
        ["LeftArm", "LeftHand", "RightArm", "RightHand", "LeftUpLeg", "LeftFoot"],
    ),
];

/// The frames of each file that are tried: more than a second, in which hinges show the roll of limbs.
const FRAMES: usize = 150;

fn converted(bytes: &[u8], conversion: &Conversion) -> Scene {
    let mut scene = Importer::new().read(bytes, "take.bvh").unwrap();
    conversion.apply(&mut scene).unwrap();
    scene
}

/// A scene as BVH text: the joint positions if every rotation is zero, and the rotations of the first frame.
fn zero_pose(scene: &Scene) -> (HashMap<String, Vec3>, Vec<f32>) {
    let written = Exporter::new().write(scene, Format::Bvh).unwrap();
    let text = String::from_utf8(written.files[0].bytes().into_owned()).unwrap();
    let (mut joints, mut channels) = (HashMap::new(), Vec::new());
    let mut open: Vec<Vec3> = Vec::new();
    let mut name = String::new();
    let mut lines = text.lines();
    for line in &mut lines {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.as_slice() {
            ["ROOT" | "JOINT", joint] => name = (*joint).to_owned(),
            ["End", "Site"] => name.clear(),
            ["OFFSET", x, y, z] => {
                let offset = Vec3::new(x.parse().unwrap(), y.parse().unwrap(), z.parse().unwrap());
                let at = open.last().copied().unwrap_or(Vec3::ZERO) + offset;
                open.push(at);
                joints.insert(name.clone(), at);
            }
            ["CHANNELS", _, names @ ..] => channels.extend(names.iter().map(|name| (*name).to_owned())),
            ["}"] => {
                open.pop();
            }
            ["Frame", "Time:", _] => break,
            _ => {}
        }
    }
    let first = lines
        .next()
        .unwrap_or_default()
        .split_whitespace()
        .map(|value| value.parse().unwrap());
    let rotations = std::iter::zip(first, &channels).filter(|(_, channel)| channel.ends_with("rotation"));
    (joints, rotations.map(|(value, _): (f32, _)| value).collect())
}

fn angle(from: Vec3, to: Vec3) -> f32 {
    from.angle_between(to).to_degrees()
}

#[test]
fn zero_rotations_are_the_t_pose_or_the_a_pose() {
    let half = 0.5_f32.sqrt();
    let mut random = Sample::new();
    for (name, [left_arm, left_hand, right_arm, right_hand, thigh, foot]) in FILES {
        let take = cut::some_frames(&mut random, name, FRAMES);
        for (rest, arms) in [
            (RestPoseSource::TPose, [Vec3::X, Vec3::NEG_X]),
            (
                RestPoseSource::APose,
                [Vec3::new(half, -half, 0.0), Vec3::new(-half, -half, 0.0)],
            ),
        ] {
            let scene = converted(take.as_bytes(), &Conversion::new().rest(rest));
            let (joints, _) = zero_pose(&scene);
            let way = |from: &str, to: &str| joints[to] - joints[from];
            let facing_forward = [
                (way(left_arm, left_hand), arms[0]),
                (way(right_arm, right_hand), arms[1]),
                (way(thigh, foot), Vec3::NEG_Y),
            ];
            for (found, expected) in facing_forward {
                let off = angle(found, expected);
                assert!(off < 0.1, "{name} {rest:?}: {found} is {off} degrees off {expected}");
            }
        }
    }
}

#[test]
fn the_first_frame_has_no_rotation_and_stands() {
    for (name, _) in FILES {
        let conversion = Conversion::new().rest(RestPoseSource::TPose).t_pose_first(true);
        let scene = converted(cut::first_frames(name, FRAMES).as_bytes(), &conversion);
        let (_, rotations) = zero_pose(&scene);
        assert!(rotations.len() > 50, "{name}");
        assert!(rotations.iter().all(|angle| angle.abs() < 0.1), "{name}: {rotations:?}");
        let lowest = |tick: f64| {
            let pose = Pose::at_tick(&scene, 0, tick).unwrap();
            pose.node_to_world
                .iter()
                .map(|node| node.w_axis.y)
                .fold(f32::INFINITY, f32::min)
        };
        assert!(
            (lowest(0.0) - lowest(1.0)).abs() < 0.15,
            "{name}: it stands at {}",
            lowest(0.0)
        );
    }
}

/// `verify` has separate kinematics.
#[test]
fn the_motion_is_unchanged_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Sample::new();
    for (name, _) in FILES {
        let source = folder.path().join("source.bvh");
        std::fs::write(&source, cut::some_frames(&mut random, name, FRAMES)).unwrap();
        for (rest, is_first) in [
            (RestPoseSource::TPose, false),
            (RestPoseSource::APose, false),
            (RestPoseSource::TPose, true),
            (RestPoseSource::APose, true),
        ] {
            let conversion = Conversion::new().rest(rest).t_pose_first(is_first);
            let scene = converted(&std::fs::read(&source).unwrap(), &conversion);
            for extension in ["bvh", "glb", "fbx"] {
                let path = folder.path().join(format!("out.{extension}"));
                Exporter::new().overwrite(true).export(&scene, &path).unwrap();
                let verifier = Verifier::new().provenance(Provenance::of(&scene));
                let found = verifier.files(&source, &path).unwrap();
                assert!(found.max_error < 1e-5, "{name} {rest:?} {extension}: {found:?}");
                assert!(
                    found.rotation_error.unwrap_or(0.0) < 1e-4,
                    "{name} {extension}: {found:?}"
                );
                assert!(found.findings.is_empty(), "{name} {extension}: {:?}", found.findings);
                // A BVH file alone does not record that its joints have other axes.
                if extension == "bvh" && !is_first {
                    let found = Verifier::new().files(&source, &path).unwrap();
                    assert!(found.is_within(1e-4), "{name} {rest:?}: {found:?}");
                }
            }
        }
    }
}

#[test]
fn steps_do_what_a_conversion_does() {
    let take = cut::first_frames("real/rokoko_dance.bvh", FRAMES);
    let mut scene = Importer::new().read(take.as_bytes(), "take.bvh").unwrap();
    let mut same = scene.clone();
    for step in ["rest:pose=a-pose", "t-pose-first"] {
        let step: EditStep = step.parse().unwrap();
        step.apply(&mut scene, &StepInput::new()).unwrap();
    }
    Conversion::new()
        .keep_units(true)
        .rest(RestPoseSource::APose)
        .apply(&mut same)
        .unwrap();
    assert_eq!(scene.nodes, same.nodes);
    assert_eq!(scene.animations[0].frame_count(), same.animations[0].frame_count() + 1);
}

#[test]
fn what_is_no_humanoid_has_no_t_pose() {
    for conversion in [
        Conversion::new().rest(RestPoseSource::TPose),
        Conversion::new().t_pose_first(true),
    ] {
        let mut scene = Importer::new().import("../../fixtures/real/lecture_Test.bvh").unwrap();
        let before = scene.clone();
        let error = conversion.keep_units(true).apply(&mut scene).unwrap_err();
        assert_eq!(error.code(), Code::NotHumanoid);
        assert!(error.to_string().contains("there is no T-pose"), "{error}");
        assert_eq!((&scene.nodes, &scene.animations), (&before.nodes, &before.animations));
    }
}
