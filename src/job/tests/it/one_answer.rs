//! Tests that repeated questions about a file get the same answer from every command: bones, T-pose, ground and
//! contacts.

use mocap::arrays::{ArrayOptions, Arrays, Contacts};
use mocap::edit::ContactOptions;
use mocap::edit::report::DetectedContacts;
use mocap::figure::{Figure, HumanoidBone as Bone, Side, vrm_humanoid};
use mocap::glam::Vec3;
use mocap::retarget::robot::{RobotOptions, RobotRetargeter};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::{NodeId, UpAxis};
use mocap::{Conversion, Importer, Scene};

use crate::sample::{Sample, is_all};

/// Rest poses of every kind, several units and up axes, feet with and without toes.
const FILES: [&str; 8] = [
    "real/cmu_12_01_walk.bvh",
    "real/rokoko_dance.bvh",
    "real/motionbuilder_vicon_walk.bvh",
    "real/mocopi_jump_six_channels.bvh",
    "real/biovision_example1.bvh",
    "real/z_up_dab.bvh",
    "skeletons/accad_run_turn.bvh",
    "real/cmu_02_01.amc",
];

/// The frames of each file that are tried.
const FRAMES: usize = 200;

fn import(file: &str) -> Scene {
    mocap::import(format!("../../fixtures/{file}")).unwrap()
}

/// Some frames from anywhere in a file.
fn part(random: &mut Sample, file: &str) -> Scene {
    let mut scene = import(file);
    let frames = scene.animations[0].frame_count();
    if frames > FRAMES && !is_all() {
        let first = random.below(frames - FRAMES + 1);
        scene.trim(first as f64, (first + FRAMES - 1) as f64);
    }
    scene
}

/// Compares the contacts of `edit` and of the arrays for the same joints and frames, and the rest height.
#[test]
fn a_foot_is_on_the_ground_or_is_not() {
    let (mut seen, mut random) = (0, Sample::new());
    for file in FILES {
        let scene = part(&mut random, file);
        let of_edit = ContactOptions::default().detect(&scene, 0, None).unwrap();
        let options = ArrayOptions::new().contacts(Contacts::new());
        let of_arrays = Arrays::of(&scene, &options).unwrap();
        let columns = of_arrays.contacts.as_ref().unwrap();
        let (frames, joints) = (of_arrays.frames, of_arrays.joints().len());
        assert_eq!(frames, of_edit.frames, "{file}");
        let mut in_contact = 0;
        for point in &of_edit.points {
            let joint = of_arrays
                .joints()
                .iter()
                .position(|joint| joint.name == point.name)
                .unwrap();
            let column: Vec<bool> = columns.iter().skip(joint).step_by(joints).copied().collect();
            assert_eq!(column, point.at_rest, "{file}: {}", point.name);
            in_contact += point.at_rest.iter().filter(|rests| **rests).count();
        }
        assert_eq!(columns.iter().filter(|rests| **rests).count(), in_contact, "{file}");
        seen += in_contact;
    }
    assert!(seen > 300, "{seen}");
}

/// Compares the bones and the T-pose of a figure with the bones and the T-pose of its VRM animation.
#[test]
fn bones_and_t_pose_are_those_of_the_vrm_animation() {
    let mut random = Sample::new();
    for file in FILES {
        let mut scene = part(&mut random, file);
        Conversion::new().apply(&mut scene).unwrap();
        assert_eq!(
            (scene.metadata.metres_per_unit, scene.metadata.up),
            (Some(1.0), Some(UpAxis::Y))
        );
        let figure = Figure::new(&scene);
        let t_pose = figure.t_pose(&scene).unwrap();
        let made = vrm_humanoid(&scene, None).unwrap();
        let world = mocap::Pose::rest(&made);
        let node = |bone: Bone| made.nodes.iter().position(|node| node.humanoid_bone == Some(bone));
        let at = |bone: Bone| node(bone).map(|node| world.position(NodeId::new(node)));
        let left = at(Bone::LeftUpperArm).unwrap() - at(Bone::RightUpperArm).unwrap();
        assert!(left.x > 0.1, "{file}: {left}");
        let shoulders = |bone: Bone| t_pose.pose.position(t_pose.bones[&bone].joint);
        let across = shoulders(Bone::LeftUpperArm) - shoulders(Bone::RightUpperArm);
        // The rotation from the facing in the file to +Z.
        let turn = mocap::glam::Quat::from_rotation_y((across.z).atan2(across.x) - left.z.atan2(left.x));
        for (bone, found) in &t_pose.bones {
            let Some(index) = node(*bone) else { continue };
            assert_eq!(
                made.nodes[index].name,
                scene.nodes[found.joint.index()].name,
                "{file}: {bone:?}"
            );
            if *bone == Bone::Hips {
                continue;
            }
            let hips = t_pose.bones[&Bone::Hips].joint;
            let here: Vec3 = turn * (t_pose.pose.position(found.joint) - t_pose.pose.position(hips));
            let there = at(*bone).unwrap() - at(Bone::Hips).unwrap();
            assert!(
                here.distance(there) < 2e-3,
                "{file}: {bone:?} is at {here} and at {there}"
            );
        }
    }
}

/// The joints of both feet at rest, as a robot gets them: a side rests if one of its points rests.
fn sides_at_rest(found: &DetectedContacts) -> Vec<[bool; 2]> {
    let rests = |side: Side, frame: usize| {
        let mut points = found.points.iter().filter(|point| point.bone.side() == Some(side));
        points.any(|point| point.at_rest[frame])
    };
    (0..found.frames)
        .map(|frame| Side::ALL.map(|side| rests(side, frame)))
        .collect()
}

/// The contacts in which `retarget` and `robot` lock feet, and in which they measure foot sliding.
#[test]
fn retarget_and_robot_hold_the_contacts_that_edit_finds() {
    /// Files that are also retargeted to a robot.
    const WITH_ROBOT: usize = 3;
    let mut random = Sample::new();
    let with_robot = random.some(FILES, WITH_ROBOT);
    for file in FILES {
        let hero = import("skeletons/human_default.gltf");
        let retargeting = Retargeter::new(part(&mut random, file), hero, RetargetOptions::new()).unwrap();
        let source = &retargeting.sources().next().unwrap().scene();
        let found = ContactOptions::default().detect(source, 0, None).unwrap();
        let held = |points: [Bone; 2]| -> usize {
            let points: Vec<_> = points.iter().filter_map(|bone| found.point(*bone)).collect();
            let stays = |frame: &usize| {
                points
                    .iter()
                    .any(|point| point.at_rest[*frame] && point.at_rest[frame + 1])
            };
            (0..found.frames.saturating_sub(1)).filter(stays).count()
        };
        let expected = held([Bone::LeftFoot, Bone::LeftToes]) + held([Bone::RightFoot, Bone::RightToes]);
        let feet = retargeting.clips()[0].report.body().unwrap().feet.unwrap();
        assert_eq!(feet.contact_frames, expected, "{file}");
        // The robot takes longest.
        if !with_robot.contains(&file) {
            continue;
        }
        let robot = Importer::new()
            .import_robot("../../fixtures/robots/g1_29dof_rev_1_0.urdf")
            .unwrap();
        let mut robot = RobotRetargeter::new(source, &robot, &RobotOptions::default()).unwrap();
        let (motion, _) = robot.clip(source, 0).unwrap();
        assert_eq!(motion.contacts, sides_at_rest(&found), "{file}");
    }
}
