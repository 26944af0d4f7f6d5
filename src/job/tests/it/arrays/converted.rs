//! Tests of arrays that a job without a target writes, read again. The arrays are compared with kinematics from the
//! source's text, and with the joints of the source's robot.

use std::fs;
use std::path::Path;

use mocap::arrays::robot_npz;
use mocap::glam::{DQuat, DVec3, Vec3};
use mocap::job::Job;
use mocap::retarget::robot::{Placement, RobotMotion};
use mocap::scene::NodeId;
use mocap::{Importer, Pose, Scene};

use super::{TOLERANCE, bytes, floats_in, largest_error};
use crate::kinematics::{Capture, Root, distance};
use crate::robot_walk::{on, points, walk};

const WALK: &str = "../../fixtures/real/cmu_short.bvh";
const G1: &str = "../../fixtures/robots/g1_29dof_rev_1_0.urdf";

/// Joints of CMU's and SMPL's skeletons that are the same bones.
const SAME: [[&str; 2]; 8] = [
    ["LeftUpLeg", "left_hip"],
    ["LeftLeg", "left_knee"],
    ["LeftFoot", "left_ankle"],
    ["RightLeg", "right_knee"],
    ["RightFoot", "right_ankle"],
    ["LeftForeArm", "left_elbow"],
    ["LeftHand", "left_wrist"],
    ["RightHand", "right_wrist"],
];

fn job(input: &Path, body: Option<&str>, write: &str) -> Job {
    let read = body.map_or_else(String::new, |body| format!(r#""read": {{"body": "{body}"}}, "#));
    let input = input.display();
    Job::from_json(&format!(
        r#"{{{read}"source": {{"inputs": ["{input}"], "space": {{"unit": "m", "up": "y"}}}}, "write": {{{write}}}}}"#
    ))
    .unwrap()
}

fn refusal(input: &Path, write: &str) -> String {
    job(input, None, write).make(&[]).unwrap_err().to_string()
}

fn positions(scene: &Scene, frame: usize) -> impl Fn(&str) -> [f64; 3] + use<> {
    let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
    let names: Vec<String> = scene.nodes.iter().map(|node| node.name.clone()).collect();
    move |name| {
        let node = names.iter().position(|own| own == name).unwrap();
        pose.position(NodeId::new(node)).as_dvec3().to_array()
    }
}

#[test]
fn own_arrays_have_the_positions_of_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let capture = Capture::parse(&bytes("cmu_short"));
    for name in ["a.npz", "a.csv"] {
        let output = folder.path().join(name);
        let written = format!(r#""output": "{}""#, output.display());
        job(WALK.as_ref(), None, &written).run_with(&[]).unwrap();
        let back = Importer::new().import(&output).unwrap();
        let joints = |frame| {
            let at = positions(&back, frame);
            let places: Vec<f32> = capture
                .nodes
                .iter()
                .flat_map(|node| at(&node.name))
                .map(|value| value as f32)
                .collect();
            places
        };
        let places: Vec<f32> = (0..capture.rows.len()).flat_map(joints).collect();
        let error = largest_error(&places, &capture, Root::Replace) / capture.height(Root::Replace);
        assert!(error <= TOLERANCE, "{name}: {error:e} of height");
    }
}

#[test]
fn layouts_of_others_have_the_joints_of_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let capture = Capture::parse(&bytes("cmu_short"));
    let height = capture.height(Root::Replace);
    for layout in ["amass", "smplx", "kimodo"] {
        let output = folder.path().join(format!("{layout}.npz"));
        let written = format!(r#""to": "{layout}", "output": "{}""#, output.display());
        job(WALK.as_ref(), None, &written).run_with(&[]).unwrap();
        let back = Importer::new().import(&output).unwrap();
        assert_eq!(back.animations[0].frame_count(), capture.rows.len());
        for frame in (0..capture.rows.len()).step_by(7) {
            let (truth, found) = (capture.placements(frame, Root::Replace), positions(&back, frame));
            for [own, theirs] in SAME {
                let node = capture.nodes.iter().position(|node| node.name == own).unwrap();
                let error = distance(truth[node].position, found(theirs)) / height;
                assert!(
                    error <= TOLERANCE,
                    "{layout}, frame {frame}, {theirs}: {error:e} of height"
                );
            }
        }
    }
}

/// The extension `.npy` means HumanML3D, whose numbers keep the lengths of the body.
#[test]
fn an_npy_has_the_lengths_of_the_source_at_20_frames_a_second() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("a.npy");
    let report = job(WALK.as_ref(), None, &format!(r#""output": "{}""#, output.display())).run_with(&[]);
    let notes = report.unwrap().notes;
    assert!(
        notes
            .iter()
            .any(|note| note == "layout: humanml3d, at 20 frames a second"),
        "{notes:?}"
    );
    let capture = Capture::parse(&bytes("cmu_short"));
    let length = |name: &str| {
        let node = capture.nodes.iter().find(|node| node.name == name).unwrap();
        distance(node.offset, [0.0; 3])
    };
    let back = Importer::new().import(&output).unwrap();
    // 75 frames at 120 per second are 0.617 seconds: 13 frames at 20 per second, with 12 steps between them.
    assert_eq!(back.animations[0].frame_count(), 12);
    for frame in 0..12 {
        let at = positions(&back, frame);
        for (above, joint, own) in [
            ("left_hip", "left_knee", "LeftLeg"),
            ("right_knee", "right_ankle", "RightFoot"),
        ] {
            let error = (distance(at(above), at(joint)) - length(own)).abs() / capture.height(Root::Replace);
            assert!(error <= TOLERANCE, "frame {frame}, {joint}: {error:e} of height");
        }
    }
}

#[test]
fn the_joints_of_a_robot_go_from_layout_to_layout() {
    let folder = tempfile::tempdir().unwrap();
    let robot = Importer::new().import_robot(G1).unwrap();
    let (motion, _) = on(&robot, &walk());
    let input = folder.path().join("walk.npz");
    fs::write(&input, robot_npz(&motion)).unwrap();
    let there = points(&robot, &motion, "left_rubber_hand", &[Vec3::ZERO]);
    for (to, name) in [
        ("npz", "b.npz"),
        ("pkl", "b.pkl"),
        ("qpos", "q.npz"),
        ("dynamics", "d.npz"),
        ("isaaclab", "i.npz"),
        ("protomotions", "p.npz"),
        ("gmr", "g.pkl"),
        ("twist", "t.pkl"),
        ("mimickit", "m.pkl"),
        ("asap", "a.pkl"),
        ("unitree-csv", "u.csv"),
        ("csv", "c.csv"),
    ] {
        let output = folder.path().join(name);
        let written = format!(r#""to": "{to}", "output": "{}""#, output.display());
        job(&input, Some(G1), &written).run_with(&[]).unwrap();
        let back = Importer::new().body(G1).import(&output).unwrap();
        assert_eq!(back.animations[0].frame_count(), motion.frames(), "{to}");
        for (frame, there) in there.iter().enumerate() {
            let here = positions(&back, frame)("left_rubber_hand");
            let error = distance(here, there[0].as_dvec3().to_array());
            assert!(error < 1e-5, "{to}, frame {frame}: {error} m");
        }
    }
    let output = folder.path().join("m.json");
    let written = format!(r#""to": "max", "output": "{}""#, output.display());
    let refused = job(&input, Some(G1), &written).run_with(&[]).unwrap_err();
    assert!(refused.to_string().contains("four legs"), "{refused}");
    // The layout with 30 frames per second has this rate without a request.
    let output = folder.path().join("m.npz");
    let written = format!(r#""to": "mjlab", "output": "{}""#, output.display());
    job(&input, Some(G1), &written).run_with(&[]).unwrap();
    let found = floats_in(&fs::read(&output).unwrap(), "joint_pos");
    assert_eq!(
        found.len(),
        ((motion.frames() - 1) * 50 / 30 + 1) * motion.dof_names.len()
    );
    for (joint, position) in motion.dof_of(0).iter().enumerate() {
        assert!(
            (f64::from(found[joint]) - position).abs() < 1e-5,
            "{}",
            motion.dof_names[joint]
        );
    }
}

const CRANE: &str = r#"<robot name="crane"><link name="base"/><link name="arm"/><link name="hook"/>
    <joint name="turn" type="continuous"><parent link="base"/><child link="arm"/>
        <origin xyz="0 0 1" rpy="0.3 0.2 0.1"/><axis xyz="0.6 0 0.8"/></joint>
    <joint name="lift" type="prismatic"><parent link="arm"/><child link="hook"/>
        <origin xyz="1 0 0" rpy="0 0.5 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
    </joint></robot>"#;

/// A table without a header, as for Unitree's robots.
#[test]
fn a_table_without_a_header_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let robot = folder.path().join("crane.urdf");
    fs::write(&robot, CRANE).unwrap();
    let rows = (0..5).map(|frame| {
        let frame = f64::from(frame);
        let (sine, cosine) = (0.05 * frame).sin_cos();
        let [x, turn, lift] = [0.1 * frame, 0.4 * frame, 0.2 - 0.02 * frame];
        format!("{x},0,0.5,0,0,{sine},{cosine},{turn},{lift}\n")
    });
    let table = folder.path().join("crane.csv");
    fs::write(&table, rows.collect::<String>()).unwrap();
    let output = folder.path().join("out.npz");
    let written = format!(r#""to": "protomotions", "output": "{}""#, output.display());
    job(&table, robot.to_str(), &written).run_with(&[]).unwrap();
    let archive = fs::read(&output).unwrap();
    let (joints, base) = (
        floats_in(&archive, "joint_angles"),
        floats_in(&archive, "base_frame_pos"),
    );
    assert_eq!(joints.len(), 10);
    for frame in 0..5_u8 {
        let (row, frame) = (usize::from(frame), f32::from(frame));
        for (found, expected) in [
            (joints[2 * row], 0.4 * frame),
            (joints[2 * row + 1], 0.2 - 0.02 * frame),
            (base[3 * row], 0.1 * frame),
            (base[3 * row + 2], 0.5),
        ] {
            assert!(
                (found - expected).abs() < 1e-5,
                "{}: {found} {expected}",
                table.display()
            );
        }
    }
}

/// BeyondMimic has joints and bodies breadth-first: both legs and the waist begin before their second joints.
#[test]
fn beyond_mimic_has_joints_breadth_first() {
    let folder = tempfile::tempdir().unwrap();
    let robot = Importer::new().import_robot(G1).unwrap();
    let (motion, _) = on(&robot, &walk());
    let input = folder.path().join("walk.npz");
    fs::write(&input, robot_npz(&motion)).unwrap();
    let output = folder.path().join("b.npz");
    let written = format!(r#""to": "beyondmimic", "output": "{}""#, output.display());
    job(&input, Some(G1), &written).run_with(&[]).unwrap();
    let found = floats_in(&fs::read(&output).unwrap(), "joint_pos");
    let first = [
        "left_hip_pitch_joint",
        "right_hip_pitch_joint",
        "waist_yaw_joint",
        "left_hip_roll_joint",
    ];
    for (found, name) in found.iter().zip(first) {
        let joint = motion.dof_names.iter().position(|other| other == name).unwrap();
        assert!((f64::from(*found) - motion.dof_of(0)[joint]).abs() < 1e-5, "{name}");
    }
    // The names in the file state the order, so the file is read in the order in which it was written.
    let back = Importer::new().body(G1).import(&output).unwrap();
    let there = points(&robot, &motion, "left_rubber_hand", &[Vec3::ZERO]);
    assert!(
        distance(
            positions(&back, 0)("left_rubber_hand"),
            there[0][0].as_dvec3().to_array()
        ) < 1e-5
    );
}

/// A hinge that rotates by more than half a turn and has a rotated origin, and a slide joint.
#[test]
fn a_hinge_is_followed_beyond_half_a_turn() {
    let folder = tempfile::tempdir().unwrap();
    let robot = folder.path().join("crane.urdf");
    fs::write(&robot, CRANE).unwrap();
    let mut motion = RobotMotion::default();
    motion.fps = 30.0;
    motion.dof_names = vec!["turn".to_owned(), "lift".to_owned()];
    for frame in 0..20_i32 {
        let frame = f64::from(frame);
        motion.root.push(Placement {
            rotation: DQuat::from_rotation_z(0.1 * frame),
            translation: DVec3::new(0.1 * frame, 0.0, 0.5),
        });
        motion.dof_pos.extend([0.4 * frame, 0.2 - 0.02 * frame]);
    }
    let input = folder.path().join("crane.npz");
    fs::write(&input, robot_npz(&motion)).unwrap();
    let output = folder.path().join("out.npz");
    let written = format!(r#""to": "protomotions", "output": "{}""#, output.display());
    job(&input, robot.to_str(), &written).run_with(&[]).unwrap();
    let archive = fs::read(&output).unwrap();
    let joints = floats_in(&archive, "joint_angles");
    assert_eq!(joints.len(), motion.dof_pos.len());
    for (found, position) in joints.iter().zip(&motion.dof_pos) {
        assert!((f64::from(*found) - position).abs() < 1e-5, "{found} {position}");
    }
    for (found, position) in floats_in(&archive, "base_frame_pos").iter().zip(motion.root_pos()) {
        assert!((f64::from(*found) - position).abs() < 1e-6, "{found} {position}");
    }
}

#[test]
fn what_a_layout_cannot_have_is_refused() {
    let walk = Path::new(WALK);
    for (write, said) in [
        (
            r#""output": "a.pkl""#,
            "if the input is the motion of a robot, name this robot in `body`",
        ),
        (
            r#""output": "a.npz", "to": "gmr""#,
            "the format gmr contains the joint positions of a robot",
        ),
        (
            r#""output": "a.csv", "to": "amass""#,
            "the name of a file with arrays of amass must end in .npz",
        ),
        (
            r#""output": "a.glb", "to": "humanml3d""#,
            "the name of a file with arrays of humanml3d must end in .npy",
        ),
        (
            r#""output": "a.npz", "smaller": {"max-error": "1mm"}"#,
            "`max_error` has no effect on arrays",
        ),
        (
            r#""output": "a.npz", "to": "amass", "space": {"out-up": "z"}"#,
            "`out_up` has no effect on arrays",
        ),
        (
            r#""output": "a.xyz""#,
            "or .vmd, or for arrays .npz, .npy, .csv, .parquet or .pkl",
        ),
    ] {
        let error = refusal(walk, write);
        assert!(error.contains(said), "{write}: {error}");
    }
    for (to, frames, said) in [
        ("amass", "{}", "`verify` compares joints by their names"),
        (
            "npz",
            r#"{"root": "extract"}"#,
            "for arrays, `verify` cannot repeat steps or changes of the root or the rest pose",
        ),
        (
            "amass",
            r#"{"root": "extract"}"#,
            "`root_motion` has no effect on arrays",
        ),
    ] {
        let text = format!(
            r#"{{"source": {{"inputs": ["{WALK}"], "frames": {frames}}}, "verify": true,
                "write": {{"output": "a.npz", "to": "{to}"}}}}"#
        );
        let error = Job::from_json(&text).unwrap().make(&[]).unwrap_err().to_string();
        assert!(error.contains(said), "{to}: {error}");
    }
}
