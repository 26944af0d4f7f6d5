//! Tests of losses that the format does not cause: joints and faces without a place in the output.

use mocap::Code;
use mocap::job::Job;
use mocap::scene::report::{DataKind, DataLoss};
use serde_json::{Value, json};

const FINGERS: &str = "../../fixtures/real/rokoko_dance.bvh";

fn job(input: &str, onto: &Value, output: &str, strict: bool) -> mocap::Result<Vec<DataLoss>> {
    let source = json!({"inputs": [input], "frames": {"trim": "0f..30f"}});
    let mut job = json!({"source": source, "read": {"strict": strict}, "write": {"output": output}});
    if !onto.is_null() {
        job["target"] = onto.clone();
    }
    // A VMD file has a fixed rate, which is a loss of its own.
    if output.ends_with(".vmd") {
        job["read"]["retime"] = json!(30);
    }
    losses(&job)
}

fn losses(job: &Value) -> mocap::Result<Vec<DataLoss>> {
    let (_, report) = Job::from_json(&job.to_string())?.make(&[])?;
    Ok(report.losses)
}

/// Positions that the user does not write, and frames that a format's fixed rate drops, are losses too: strict jobs
/// refuse them. In the columns of the first file, the positions of `JOINTS` joints below the root change. Of the second
/// file, every fourth frame remains.
#[test]
fn positions_and_frames_that_are_left_out_are_counted() {
    const JOINTS: u64 = 20;
    const POSITIONS: &str = "../../fixtures/real/perception_neuron_moving_positions.bvh";
    const WALK: &str = "../../fixtures/real/cmu_short.bvh";
    let three = json!({"output": "a.bvh", "bvh": {"channels": "3"}});
    let positions = [DataLoss::new(DataKind::PositionCurves, JOINTS)];
    // 75 frames at 120 per second. The joints of hands have no bones in MMD.
    let times = [
        DataLoss::new(DataKind::Frames, 56),
        DataLoss::new(DataKind::FrameRates, 1),
        DataLoss::new(DataKind::Durations, 1),
        DataLoss::new(DataKind::MovingJoints, 4),
    ];
    for (input, write, lost) in [
        (POSITIONS, three, &positions[..]),
        (WALK, json!({"output": "a.vmd"}), &times[..]),
    ] {
        let mut job = json!({"source": {"inputs": [input]}, "write": write});
        assert_eq!(losses(&job).unwrap(), lost, "{input}");
        job["read"] = json!({"strict": true});
        assert_eq!(losses(&job).unwrap_err().code(), Code::NotCarriedOver, "{input}");
    }
}

/// A performer with fingers is retargeted to bodies without fingers. The columns of the file show that 17 of the 30
/// finger joints move in these frames.
#[test]
fn joints_without_a_place_are_counted_and_strict_jobs_refuse_them() {
    let without_fingers = json!({"skeleton": {"file": "../../fixtures/skeletons/accad_run_turn.bvh"}});
    let with_fingers = json!({"skeleton": {"file": FINGERS}});
    let none = Value::Null;
    for (onto, output, lost) in [
        (&without_fingers, "a.bvh", true),
        (&without_fingers, "a.glb", true),
        (&with_fingers, "a.bvh", false),
        (&none, "a.bvh", false),
        (&none, "a.glb", false),
    ] {
        let losses = job(FINGERS, onto, output, false).unwrap();
        let moving = losses.iter().find(|loss| loss.kind == DataKind::MovingJoints);
        assert_eq!(moving.is_some(), lost, "{onto} {output}: {losses:?}");
        if let Some(moving) = moving {
            assert_eq!(moving.count, 17, "{onto} {output}");
        }
        match job(FINGERS, onto, output, true) {
            Err(error) => assert!(lost && error.code() == Code::NotCarriedOver, "{error}"),
            Ok(_) => assert!(!lost, "{onto} {output}"),
        }
    }
}

/// The joints of a palm rotate the fingers below them. The palm joints of CMU's hands have no bone below them.
#[test]
fn a_format_of_certain_bones_counts_the_joints_that_are_none() {
    const HANDS: &str = "../../fixtures/real/cmu_12_01_walk.bvh";
    for output in ["a.vrma", "a.vmd"] {
        assert_eq!(job(FINGERS, &Value::Null, output, true).unwrap(), [], "{output}");
        let losses = job(HANDS, &Value::Null, output, false).unwrap();
        assert_eq!(losses, [DataLoss::new(DataKind::MovingJoints, 4)], "{output}");
        let error = job(HANDS, &Value::Null, output, true).unwrap_err();
        assert_eq!(error.code(), Code::NotCarriedOver, "{output}: {error}");
    }
}

/// Marker gaps are no fault of a file, but a strict job refuses an output that would fill them.
#[test]
fn a_strict_job_keeps_gaps_of_markers() {
    const HAND: &str = "../../fixtures/real/hand_take.c3d";
    let strict = |steps: Value, output: &str| {
        losses(&json!({
            "source": {"inputs": [HAND]},
            "read": {"strict": true},
            "steps": steps,
            "write": {"output": output},
        }))
    };
    for steps in [json!([]), json!(["reverse"]), json!(["smooth:cut-off=6"])] {
        assert_eq!(strict(steps.clone(), "a.trc").unwrap(), [], "{steps}");
        let lost = strict(steps, "a.glb").unwrap_err();
        assert_eq!(lost.code(), Code::NotCarriedOver);
        assert!(lost.to_string().contains("with gaps"), "{lost}");
    }
    let filled = strict(json!(["in-between:every=5"]), "a.trc").unwrap_err();
    assert_eq!(filled.code(), Code::Gap, "{filled}");
    let arrays = losses(&json!({"source": {"inputs": [HAND]}, "read": {"strict": true}, "write": {"output": "a.csv"}}));
    assert_eq!(arrays.unwrap(), []);
}

/// Arrays only hold joints.
#[test]
fn a_face_alone_is_no_array() {
    const FACE: &str = "../../fixtures/made/face_alone.gltf";
    for output in ["a.npz", "a.csv"] {
        let refused = job(FACE, &Value::Null, output, false).unwrap_err();
        assert_eq!(refused.code(), Code::Unrepresentable, "{output}");
        assert!(refused.to_string().contains("4 face curves"), "{refused}");
    }
}
