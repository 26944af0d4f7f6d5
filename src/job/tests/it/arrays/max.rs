//! Tests of the JSON of robots with four legs.

use std::fs;
use std::path::Path;

use mocap::job::Job;
use mocap::scene::NodeId;
use mocap::{Importer, Pose, Scene};

use crate::kinematics::distance;

const WALK: &str = "../../fixtures/made/dog_walk_max.json";
const MAX: &str = "../../fixtures/robots/max.urdf";
const G1: &str = "../../fixtures/robots/g1_29dof_rev_1_0.urdf";

/// Positions of feet in metres: the frame, the link and x, y, z. A short program computed them from the values of the
/// JSON and of the URDF, without this library.
const FEET: [(usize, &str, [f64; 3]); 8] = [
    (0, "link_FR4", [1.154_657, -0.282_439, 0.015_502]),
    (0, "link_FL4", [1.500_37, -0.026_764, 0.055_465]),
    (0, "link_HR4", [0.788_218, -0.155_285, 0.044_272]),
    (0, "link_HL4", [1.005_749, 0.072_697, 0.032_734]),
    (19, "link_FR4", [3.466_453, -0.782_349, 0.059_944]),
    (19, "link_FL4", [3.394_243, -0.471_223, 0.026_216]),
    (19, "link_HR4", [3.206_271, -0.710_662, 0.044_446]),
    (19, "link_HL4", [2.926_724, -0.385_984, 0.050_793]),
];

fn check(scene: &Scene, file: &Path) {
    assert_eq!(scene.animations[0].frame_count(), 20, "{}", file.display());
    assert!((scene.animations[0].ticks_per_second - 10.0).abs() < 1e-9);
    for (frame, link, expected) in FEET {
        let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
        let node = scene.nodes.iter().position(|node| node.name == link).unwrap();
        let found = pose.position(NodeId::new(node)).as_dvec3().to_array();
        let error = distance(found, expected);
        assert!(error < 1e-5, "{}: frame {frame}, {link}: {error} m", file.display());
    }
}

fn read(text: &str, robot: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("motion.json");
    fs::write(&file, text).unwrap();
    Importer::new()
        .body(robot)
        .import(&file)
        .map_err(|error| error.to_string())
}

#[test]
fn a_motion_of_four_legs_is_read_and_written() {
    check(&Importer::new().body(MAX).import(WALK).unwrap(), WALK.as_ref());
    let folder = tempfile::tempdir().unwrap();
    for (to, name) in [("max", "m.json"), ("npz", "m.npz")] {
        let output = folder.path().join(name);
        let job = format!(
            r#"{{"read": {{"body": "{MAX}"}}, "source": {{"inputs": ["{WALK}"], "space": {{"unit": "m", "up": "y"}}}},
                "write": {{"to": "{to}", "output": "{}"}}}}"#,
            output.display()
        );
        Job::from_json(&job).unwrap().run_with(&[]).unwrap();
        check(&Importer::new().body(MAX).import(&output).unwrap(), &output);
    }
}

/// Unitree names the hind legs RR and RL.
#[test]
fn legs_are_found_by_their_names() {
    let text = fs::read_to_string(WALK).unwrap();
    let rear = text.replace("\"HR\", \"HL\"", "\"RR\", \"RL\"");
    assert_ne!(text, rear);
    check(&read(&rear, MAX).unwrap(), "rear".as_ref());
}

#[test]
fn broken_motions_of_four_legs_are_refused() {
    let text = fs::read_to_string(WALK).unwrap();
    let without_robot = Importer::new().import(WALK).unwrap_err().to_string();
    assert!(without_robot.contains("do not state which robot"), "{without_robot}");
    for (text, robot, expected) in [
        (text.clone(), G1, "four legs"),
        (text[..text.len() / 2].to_owned(), MAX, "ends inside"),
        (text.replacen("\"HR\"", "\"FR\"", 1), MAX, "LegOrder"),
        (text.replacen("[1.11693, ", "[", 1), MAX, "19 numbers"),
        (text.replacen("1.11693", "\"x\"", 1), MAX, "line 2"),
        (text.replacen("1.11693", "1e999", 1), MAX, "line 2"),
        (text.replacen("0.1,", "0,", 1), MAX, "rate"),
        (text.replacen("0.1,", "-1e300,", 1), MAX, "rate"),
    ] {
        let refused = read(&text, robot).unwrap_err();
        assert!(refused.contains(expected), "{expected}: {refused}");
    }
    let empty = format!("{}\n]}}", text.lines().next().unwrap());
    let refused = read(&empty, MAX).unwrap_err();
    assert!(refused.contains("no frames"), "{refused}");
}
