//! The motion of a robot, retargeted to the same robot, and to another robot and back.

use mocap::glam::{DQuat, DVec3};
use mocap::retarget::robot::{Robot, RobotMotion};
use mocap::scene::{Animation, HumanoidBone as Bone};
use mocap::{Binding, Importer, Pose, Scene};
use mocap_figure::robot_bones::moving::scene_of_clips;
use mocap_figure::robot_bones::robot_bones;

use crate::robot_scores::links;
use crate::robot_walk::{on, walk};

pub(crate) fn robot(name: &str) -> Robot {
    Importer::new()
        .import_robot(format!("../../fixtures/robots/{name}"))
        .unwrap()
}

/// The motion as a source in metres with +Y up.
pub(crate) fn source(robot: &Robot, motion: &RobotMotion) -> Scene {
    let mut scene = scene_of_clips(robot, vec![motion.to_animation(robot)]);
    mocap::Conversion::new().apply(&mut scene).unwrap();
    scene
}

/// Unit vectors in every frame: the lines of the hips and of the shoulders, and the shins.
fn directions(robot: &Robot, motion: &RobotMotion) -> Vec<[DVec3; 4]> {
    let (scene, animation): (Scene, Animation) =
        (mocap::retarget::robot::robot_scene(robot), motion.to_animation(robot));
    let bones = robot_bones(robot, None).unwrap();
    let zero = robot.zero_pose();
    let binding = Binding::new(&scene, &animation);
    let mut pose = Pose::rest(&scene);
    let frames = (0..motion.frames()).map(|frame| {
        pose.sample(&binding, &animation, frame as f64);
        // The start of a bone, as a point of the link above its first joint: joints rotate about this point.
        let at = |bone: Bone| {
            let bone = bones.iter().find(|found| found.bone == bone).unwrap();
            let above = robot.links[bone.joints[0]].parent.unwrap();
            let matrix = pose.node_to_world[above].as_dmat4();
            matrix.transform_point3(zero[above].to_inner(bone.at))
        };
        let line = |from: Bone, to: Bone| (at(to) - at(from)).normalize();
        [
            line(Bone::RightUpperLeg, Bone::LeftUpperLeg),
            line(Bone::RightUpperArm, Bone::LeftUpperArm),
            line(Bone::LeftLowerLeg, Bone::LeftFoot),
            line(Bone::RightLowerLeg, Bone::RightFoot),
        ]
    });
    frames.collect()
}

#[test]
fn a_robot_does_its_own_motion_as_it_is() {
    for name in ["g1_29dof_rev_1_0.urdf", "h1.urdf"] {
        let robot = robot(name);
        let (motion, _) = on(&robot, &walk());
        let (again, report) = on(&robot, &source(&robot, &motion));
        for (own, found) in motion.dof_pos.iter().zip(&again.dof_pos) {
            assert!((own - found).abs() < 1e-3, "{name}: {own} {found}");
        }
        for (own, found) in motion.root.iter().zip(&again.root) {
            assert!(own.translation.distance(found.translation) < 1e-3);
            assert!(own.rotation.angle_between(found.rotation) < 1e-3);
        }
        assert!(report.mean_degrees < 0.1, "{name}: {}", report.mean_degrees);
        assert!(report.trunk_degrees.unwrap() < 0.1);
        // Both motions slide at the same points of their soles.
        let [own, source] = [report.skate, report.source_skate].map(Option::unwrap);
        assert!((own - source).abs() < 1e-3, "{name}: {own} {source}");
    }
}

/// Programs look for the links of a robot by name. A node with the name of a link has the coordinate frame of this link
/// in the robot's file.
#[test]
fn links_stand_at_their_frames() {
    for name in ["g1_29dof_rev_1_0.urdf", "h1.urdf"] {
        let robot = robot(name);
        let (motion, _) = on(&robot, &walk());
        let scene = scene_of_clips(&robot, vec![motion.to_animation(&robot)]);
        assert!(
            scene.nodes.len() > robot.links.len(),
            "{name}: no bone begins elsewhere"
        );
        assert_eq!(scene.validate(), []);
        let binding = Binding::new(&scene, &scene.animations[0]);
        let mut pose = Pose::rest(&scene);
        for frame in [0, motion.frames() / 2] {
            pose.sample(&binding, &scene.animations[0], frame as f64);
            for (link, place) in robot.links.iter().zip(links(&robot, &motion, frame)) {
                let node = scene.nodes.iter().position(|node| node.name == link.name).unwrap();
                let found = pose.node_to_world[node].as_dmat4();
                assert!(found.abs_diff_eq(place, 1e-5), "{name}: {}: {found} {place}", link.name);
            }
        }
    }
}

/// The arms of a walk, and a turning trunk, on robots of other proportions.
#[test]
fn robots_face_as_each_other() {
    let (g1, h1) = (robot("g1_29dof_rev_1_0.urdf"), robot("h1.urdf"));
    let (on_g1, _) = on(&g1, &walk());
    let (on_h1, report) = on(&h1, &source(&g1, &on_g1));
    assert!(report.trunk_degrees.unwrap() < 5.0, "{:?}", report.trunk_degrees);
    let (there, here) = (directions(&g1, &on_g1), directions(&h1, &on_h1));
    for index in 0..4 {
        let angles = there
            .iter()
            .zip(&here)
            .map(|(there, here)| there[index].angle_between(here[index]));
        let mean = angles.sum::<f64>().to_degrees() / there.len() as f64;
        assert!(mean < 5.0, "direction {index}: {mean} degrees");
    }
}

/// If the trunk is rotated relative to the source, the motion is not "good", even if every limb agrees relative to the
/// trunk.
#[test]
fn a_turned_trunk_is_measured() {
    let g1 = robot("g1_29dof_rev_1_0.urdf");
    let (mut motion, _) = on(&g1, &walk());
    let waist = g1
        .dof_names()
        .iter()
        .position(|name| name == "waist_yaw_joint")
        .unwrap();
    let joints = motion.dof_names.len();
    for frame in 0..motion.frames() {
        motion.dof_pos[frame * joints + waist] = 1.5;
    }
    let (again, report) = on(&g1, &source(&g1, &motion));
    assert!((again.dof_of(0)[waist] - 1.5).abs() < 1e-3);
    assert!(report.trunk_degrees.unwrap() < 0.1);
    // If the base of the motion is rotated, the whole motion is rotated with it.
    let turn = DQuat::from_rotation_z(1.0);
    for root in &mut motion.root {
        root.rotation = turn * root.rotation;
        root.translation = turn * root.translation;
    }
    let (turned, _) = on(&g1, &source(&g1, &motion));
    for (own, found) in motion.dof_pos.iter().zip(&turned.dof_pos) {
        assert!((own - found).abs() < 1e-3, "{own} {found}");
    }
}
