//! Tests of robot motion in files for training, read again with the robot.

use mocap::arrays::{robot_npz, robot_pickle, robot_qpos_npz};
use mocap::glam::Vec3;
use mocap::{Binding, Importer, Pose};

use crate::robot_walk::{on, points, walk};

#[test]
fn the_motion_of_a_robot_is_read_with_its_robot() {
    let g1 = "../../fixtures/robots/g1_29dof_rev_1_0.urdf";
    let robot = Importer::new().import_robot(g1).unwrap();
    let (motion, _) = on(&robot, &walk());
    let importer = Importer::new().body(g1);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.npz");
    for bytes in [robot_pickle(&motion), robot_qpos_npz(&motion), robot_npz(&motion)] {
        std::fs::write(&path, bytes).unwrap();
        let scene = importer.import(&path).unwrap();
        assert_eq!(scene.animations[0].ticks_per_second, 30.0);
        // The links keep their positions.
        let hand = scene
            .nodes
            .iter()
            .position(|node| node.name == "left_rubber_hand")
            .unwrap();
        let binding = Binding::new(&scene, &scene.animations[0]);
        let mut pose = Pose::rest(&scene);
        pose.sample(&binding, &scene.animations[0], 20.0);
        let there = points(&robot, &motion, "left_rubber_hand", &[Vec3::ZERO])[20][0];
        let here = pose.node_to_world[hand].w_axis.truncate();
        assert!(here.distance(there) < 1e-4, "{here} {there}");
    }
    let scene = importer.import(&path).unwrap();
    let (again, report) = on(&robot, &scene);
    let apart = motion.dof_pos.iter().zip(&again.dof_pos).map(|(a, b)| (a - b).abs());
    let mean = apart.sum::<f64>() / motion.dof_pos.len() as f64;
    // A robot's motion on the same robot keeps the steps and the limbs.
    assert!((report.scale - 1.0).abs() < 0.01, "{}", report.scale);
    assert!(report.mean_degrees < 5.0, "{mean} rad, {} degrees", report.mean_degrees);
    let without = Importer::new().import(&path).unwrap_err();
    assert!(without.to_string().contains("`body` robot.urdf"), "{without}");
    let wrong = Importer::new()
        .body("../../fixtures/robots/h1.urdf")
        .import(&path)
        .unwrap_err();
    assert!(
        wrong.to_string().contains("differ from the joints of the robot"),
        "{wrong}"
    );
}
