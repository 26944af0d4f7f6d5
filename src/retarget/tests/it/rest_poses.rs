//! Rest poses of any kind, and the evidence of a motion if the rest pose shows nothing.

use mocap::figure::report::TPoseSource;
use mocap::figure::{Axis, Figure, HumanoidBone as Bone};
use mocap::glam::Mat4;
use mocap::retarget::report::Verdict;
use mocap::retarget::{PoseRetargetOptions, PoseRetargeter};
use mocap::{Pose, Scene};

use crate::characters::{character, motion};
use crate::roll::{assert_alike, rotations, with_other_frames};

/// A character whose arms are lowered by this angle at rest, in degrees.
fn with_arms_down(scene: &Scene, degrees: f32) -> Scene {
    let figure = Figure::new(scene);
    let pose = figure.t_pose(scene).unwrap().with_lowered_arms(scene, degrees);
    let mut lowered = scene.clone();
    for (node, transform) in lowered.nodes.iter_mut().zip(&pose.node_to_parent) {
        node.transform = *transform;
    }
    lowered
}

/// Whatever its arms do, a body that stands at rest shows the rotation of trunk, head and feet.
#[test]
fn a_rest_pose_stands_with_its_arms_at_any_angle() {
    let scene = character("human_vrm0");
    let head = |scene: &Scene| {
        let figure = Figure::new(scene);
        let t_pose = figure.t_pose(scene).unwrap();
        assert_eq!(t_pose.source, TPoseSource::RestPose);
        let head = figure.humanoid.joint(Bone::Head).unwrap();
        t_pose.pose.node_to_world[head.index()]
            .to_scale_rotation_translation()
            .1
    };
    let expected = head(&scene);
    for degrees in [-60.0, 30.0, 62.0, 69.0, 74.0, 85.0] {
        let off = head(&with_arms_down(&scene, degrees))
            .angle_between(expected)
            .to_degrees();
        assert!(off < 1.0, "{degrees} degrees down: the head is {off} degrees off");
    }
}

/// If all bones lie along one axis, the right arm may cross the body. Such a pose is not a T-pose.
#[test]
fn an_arm_across_the_body_is_no_t_pose() {
    let mut scene = character("human_vrm0");
    let arm = Figure::new(&scene).humanoid.joint(Bone::RightUpperArm).unwrap();
    let node = &mut scene.nodes[arm.index()];
    node.transform *= Mat4::from_rotation_z(std::f32::consts::PI);
    assert_eq!(Figure::new(&scene).rest_pose.value.as_str(), "other");
}

/// The same motion with the pose of one tick as its rest pose, as in files whose skeleton was bound in this pose.
fn bound_at(scene: &Scene, tick: f64) -> Scene {
    let bound = Pose::at_tick(scene, 0, tick).unwrap();
    let mut made = scene.clone();
    for (node, transform) in made.nodes.iter_mut().zip(&bound.node_to_parent) {
        node.transform = *transform;
    }
    made
}

/// In the middle of a walk, arms may hang as in an I-pose, and limbs have any roll. The left and the right side are not
/// mirror images, so the hinges of the motion determine the roll.
#[test]
fn a_moment_of_a_motion_is_no_pose_to_believe() {
    let target = character("human_game_engine");
    let limbs = [
        Bone::LeftUpperArm,
        Bone::RightUpperArm,
        Bone::LeftUpperLeg,
        Bone::RightUpperLeg,
    ];
    let source = motion("skeletons/bvhtoolbox_walk01.bvh");
    let ticks = [0.0, 10.0, 20.0];
    let expected = rotations(&source, &target, &limbs, &ticks);
    for tick in [30.0, 46.0, 60.0] {
        let bound = bound_at(&source, tick);
        assert_eq!(Figure::new(&bound).rest_pose.value.as_str(), "other", "tick {tick}");
        let found = rotations(&bound, &target, &limbs, &ticks);
        for (was, is) in expected.iter().flatten().zip(found.iter().flatten()) {
            // The T-pose and the hinges of a motion differ by up to 30 degrees.
            let off = was.angle_between(*is).to_degrees();
            assert!(off < 30.0, "tick {tick}: {off} degrees");
        }
    }
}

/// A walking body may be near the origin along any axis. This does not mean that the body lies on the floor.
#[test]
fn a_body_that_walks_does_not_lie_on_the_floor() {
    let scene = mocap::import("../../fixtures/real/hip_knee_ankle_names.bvh").unwrap();
    let figure = Figure::new(&with_other_frames(&scene, 0.0));
    assert_eq!(figure.up.value, Axis::Y, "{}", figure.up.reason);
}

/// Two files of one motion that differ only in the coordinate frames of all joints. By chance, some axes of these
/// coordinate frames lie along the bones, which is no evidence.
#[test]
fn other_frames_of_all_joints_are_the_same_motion() {
    let target = character("human_game_engine");
    let bones = [
        Bone::Hips,
        Bone::Spine,
        Bone::Chest,
        Bone::UpperChest,
        Bone::Neck,
        Bone::Head,
        Bone::LeftUpperArm,
        Bone::RightLowerArm,
        Bone::LeftUpperLeg,
        Bone::RightLowerLeg,
    ];
    for file in [
        "skeletons/vicon_sword_attack.bvh",
        "skeletons/accad_run_turn.bvh",
        "skeletons/bvhtoolbox_walk01.bvh",
    ] {
        let source = motion(file);
        let ticks = [0.0, 10.0, 20.0];
        let of = |start: f32| rotations(&with_other_frames(&source, start), &target, &bones, &ticks);
        let first = of(0.0);
        for start in [1.0, 2.0, 3.0] {
            assert_alike(&first, &of(start), &bones, &format!("{file}, frames {start}"));
        }
    }
}

/// If the figure does not stand in the rest pose, its axes are averages over the motion. A few frames give no average,
/// and the report says so.
#[test]
fn few_frames_are_said_to_be_few() {
    let target = character("human_game_engine");
    for file in ["skeletons/accad_run_turn.bvh", "real/nan_tokens.bvh"] {
        let mut source = motion(file);
        source.trim(10.0, 30.0);
        let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
        let (_, report) = retargeter.clip(&source, 0, &target, false).unwrap();
        let said = |bone: Bone| report.guessed.iter().any(|guess| guess.bone == bone);
        assert!(said(Bone::Hips) && said(Bone::LeftFoot), "{file}: {:?}", report.guessed);
        assert_ne!(report.verdict, Verdict::Good, "{file}");
    }
}

/// A part of a motion without evidence in its rest pose has other averages. The report lists the bones that depend on
/// these averages as guessed.
#[test]
fn a_part_is_as_the_whole_or_says_that_it_is_guessed() {
    let target = character("human_game_engine");
    let bones = [
        Bone::Neck,
        Bone::Head,
        Bone::LeftUpperArm,
        Bone::LeftLowerArm,
        Bone::LeftHand,
        Bone::RightUpperArm,
        Bone::RightLowerArm,
        Bone::RightHand,
        Bone::LeftUpperLeg,
        Bone::LeftLowerLeg,
        Bone::RightUpperLeg,
        Bone::RightLowerLeg,
    ];
    let mut guesses = 0;
    for file in ["vicon_sword_attack", "accad_run_turn"] {
        let source = motion(&format!("skeletons/{file}.bvh"));
        for [first, last] in [[0.0, 20.0], [20.0, 60.0]] {
            let mut part = source.clone();
            part.trim(first, last);
            let ticks: Vec<f64> = (0..5).map(|step| f64::from(step) * (last - first) / 5.0).collect();
            let of_whole: Vec<f64> = ticks.iter().map(|tick| first + tick).collect();
            let whole = rotations(&source, &target, &bones, &of_whole);
            let cut = rotations(&part, &target, &bones, &ticks);
            let mut retargeter = PoseRetargeter::new(&part, &target, &PoseRetargetOptions::default()).unwrap();
            let (_, report) = retargeter.clip(&part, 0, &target, false).unwrap();
            for (index, bone) in bones.into_iter().enumerate() {
                let angles = std::iter::zip(&whole, &cut).map(|(was, is)| was[index].angle_between(is[index]));
                let mean = angles.sum::<f32>().to_degrees() / whole.len() as f32;
                let is_guessed = report.guessed.iter().any(|guess| guess.bone == bone);
                guesses += usize::from(is_guessed);
                assert!(
                    is_guessed || mean < 2.0,
                    "{file} from {first} on: {} is {mean} degrees off",
                    bone.as_str()
                );
            }
        }
    }
    assert!(guesses > 0);
}

/// If the source lacks a hand, the hand follows its forearm, with the palm down in the T-pose. A character whose palms
/// face up at rest is no exception.
#[test]
fn a_hand_that_the_source_lacks_goes_with_its_forearm() {
    let source = motion("skeletons/blender_rigify_names.bvh");
    let target = character("human_vrm1");
    let mut retargeter = PoseRetargeter::new(&source, &target, &PoseRetargetOptions::default()).unwrap();
    let (animation, report) = retargeter.clip(&source, 0, &target, false).unwrap();
    let hand = report.unmapped.iter().find(|unmapped| unmapped.bone == Bone::LeftHand);
    assert!(hand.unwrap().reason.contains("follows its parent bone"), "{hand:?}");
    let moved = Scene {
        animations: vec![animation],
        ..target.clone()
    };
    let figure = Figure::new(&target);
    let t_pose = figure.t_pose(&target).unwrap();
    let pose = Pose::at_tick(&moved, 0, 5.0).unwrap();
    let since = |bone: Bone| {
        let joint = figure.humanoid.joint(bone).unwrap().index();
        let rotation = |pose: &Pose| pose.node_to_world[joint].to_scale_rotation_translation().1;
        rotation(&pose) * rotation(&t_pose.pose).inverse()
    };
    let off = since(Bone::LeftHand)
        .angle_between(since(Bone::LeftLowerArm))
        .to_degrees();
    assert!(off < 1.0, "{off} degrees");
}
