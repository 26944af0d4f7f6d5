//! Motions of ASAP and PBHC in files that joblib wrote. `tools/arrays/make_joblib.py` has the formulas of their
//! numbers.

use mocap::Importer;
use mocap::glam::{DQuat, DVec3};
use mocap::retarget::robot::RobotMotion;

const G1: &str = "../../fixtures/robots/g1_29dof_rev_1_0.urdf";

/// The motion has the numbers of the script.
fn assert_is_made(motion: &RobotMotion, frames: usize, turn: f64, fps: f64) {
    assert_eq!((motion.frames(), motion.dof_names.len(), motion.fps), (frames, 29, fps));
    for frame in 0..frames {
        let root = motion.root[frame];
        let place = DVec3::new(0.1 * frame as f64, 0.0, 0.8);
        assert!(root.translation.distance(place) < 1e-6, "{frame}: {}", root.translation);
        let heading = DQuat::from_rotation_z(turn * frame as f64);
        assert!(
            heading.angle_between(root.rotation) < 1e-5,
            "{frame}: {}",
            root.rotation
        );
        for (joint, position) in motion.dof_of(frame).iter().enumerate() {
            let expected = 0.01 * frame as f64 + 0.002 * joint as f64;
            assert!((position - expected).abs() < 1e-5, "{frame}, {joint}: {position}");
        }
    }
}

/// Imports bytes from a file, because the robot is a second file.
fn imported(bytes: &[u8], name: &str) -> mocap::Result<mocap::Scene> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    Importer::new().body(G1).import(path)
}

#[test]
fn a_file_of_joblib_is_read() {
    let robot = Importer::new().import_robot(G1).unwrap();
    let path = "../../fixtures/arrays/asap_joblib.pkl";
    let scene = Importer::new().body(G1).import(path).unwrap();
    assert_eq!(scene.animations[0].name, "step");
    assert_is_made(&RobotMotion::of_arrays(&robot, &scene).unwrap(), 4, 0.1, 50.0);
    // The contents decide, not the name.
    let unnamed = imported(&std::fs::read(path).unwrap(), "motion").unwrap();
    assert_eq!(unnamed.animations, scene.animations);
}

#[test]
fn each_motion_of_a_file_is_a_clip() {
    let robot = Importer::new().import_robot(G1).unwrap();
    let path = "../../fixtures/arrays/asap_joblib_two.pkl";
    let mut scene = Importer::new().body(G1).import(path).unwrap();
    let names: Vec<&str> = scene.animations.iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["left", "right"]);
    assert_is_made(&RobotMotion::of_arrays(&robot, &scene).unwrap(), 3, 0.2, 30.0);
    scene.animations.remove(0);
    assert_is_made(&RobotMotion::of_arrays(&robot, &scene).unwrap(), 5, -0.2, 30.0);
    let error = Importer::new().import(path).unwrap_err().to_string();
    assert!(error.contains("do not state which robot"), "{error}");
}

/// Every shorter file is refused, and every changed byte gives an error or a valid scene.
#[test]
fn broken_files_of_joblib_are_refused() {
    let bytes = std::fs::read("../../fixtures/arrays/asap_joblib.pkl").unwrap();
    for length in (0..bytes.len()).step_by(37) {
        assert!(imported(&bytes[..length], "motion.pkl").is_err(), "{length}");
    }
    let shape = bytes.windows(5).position(|five| five == b"shape").unwrap() + 5;
    for at in (shape..shape + 60).chain((0..bytes.len()).step_by(41)) {
        let mut changed = bytes.clone();
        changed[at] = changed[at].wrapping_add(113);
        if let Ok(scene) = imported(&changed, "motion.pkl") {
            assert_eq!(scene.validate(), [], "{at}");
        }
    }
}
