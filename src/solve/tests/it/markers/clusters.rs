//! Clusters on thighs and shanks, as of running trials, planted on a body whose joints are known.

use mocap::glam::Vec3;
use mocap::scene::NodeId;
use mocap::{Importer, Pose, Scene};

use super::lower_body::Markers;

/// Millimetres in a unit of CMU's BVH files: an inch, scaled by 1 / 0.45.
const MILLIMETRES: f32 = 25.4 / 0.45;

/// Every so many frames of the walk, which are 24 a second then.
const EVERY: usize = 5;

/// A marker: the joint that moves it, the joint that it is beside, and millimetres from there: outwards, up, forward.
const PLANTED: &[(&str, &str, &str, [f32; 3])] = &[
    ("ASI", "Hips", "UpLeg", [30.0, 90.0, 90.0]),
    ("PSI", "Hips", "UpLeg", [-40.0, 90.0, -110.0]),
    ("TH1", "UpLeg", "UpLeg", [80.0, -180.0, 30.0]),
    ("TH2", "UpLeg", "UpLeg", [80.0, -280.0, 40.0]),
    ("TH3", "UpLeg", "UpLeg", [70.0, -230.0, -40.0]),
    ("TB1", "Leg", "Leg", [50.0, -150.0, 30.0]),
    ("TB2", "Leg", "Leg", [50.0, -250.0, 30.0]),
    ("TB3", "Leg", "Leg", [45.0, -200.0, -30.0]),
    ("CAL", "Foot", "Foot", [0.0, -50.0, -60.0]),
    ("TOE", "Foot", "ToeBase", [-20.0, 20.0, 0.0]),
    ("MT5", "Foot", "ToeBase", [40.0, 10.0, -20.0]),
];

fn sided(side: &str, joint: &str) -> String {
    if joint == "Hips" {
        joint.to_owned()
    } else {
        format!("{side}{joint}")
    }
}

/// Position and rotation of a joint in a pose.
fn joint(scene: &Scene, pose: &Pose, name: &str) -> (Vec3, mocap::glam::Quat) {
    let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
    let (_, rotation, position) = pose.node_to_world[NodeId::new(node).index()].to_scale_rotation_translation();
    (position, rotation)
}

/// The walk, and the markers on it.
fn planted() -> (Scene, Markers) {
    let scene = Importer::new()
        .import("../../fixtures/real/cmu_12_01_walk.bvh")
        .unwrap();
    let rest = Pose::rest(&scene);
    let mut markers = Markers {
        labels: Vec::new(),
        frames: Vec::new(),
    };
    // The first frame is a T-pose.
    for frame in (1..scene.animations[0].frame_count()).step_by(EVERY) {
        let pose = Pose::at_tick(&scene, 0, frame as f64).unwrap();
        let mut row = Vec::new();
        for (side, letter, sign) in [("Left", "L", 1.0), ("Right", "R", -1.0)] {
            for (label, moved, beside, [outwards, up, forward]) in PLANTED {
                let [moved, beside] = [moved, beside].map(|name| sided(side, name));
                let at_rest = joint(&scene, &rest, &beside).0 - joint(&scene, &rest, &moved).0;
                let (position, rotation) = joint(&scene, &pose, &moved);
                row.push(
                    (position + rotation * at_rest) * MILLIMETRES
                        + rotation * Vec3::new(sign * outwards, *up, *forward),
                );
                if markers.frames.is_empty() {
                    markers.labels.push(format!("{letter}{label}"));
                }
            }
        }
        markers.frames.push(row);
    }
    (scene, markers)
}

#[test]
fn clusters_alone_tell_knees_and_ankles() {
    let (truth, markers) = planted();
    let solved = markers.solved();
    let said = |words: &str| {
        solved
            .metadata
            .assumptions
            .iter()
            .any(|said| said.choice.contains(words))
    };
    assert!(
        said("where the markers of both segments turn about"),
        "{:?}",
        solved.metadata.assumptions
    );
    for side in ["Left", "Right"] {
        let mut angles = Vec::new();
        for frame in 0..markers.frames.len() {
            let own = Pose::at_tick(&solved, 0, frame as f64).unwrap();
            let other = Pose::at_tick(&truth, 0, (1 + frame * EVERY) as f64).unwrap();
            let bend = |[hip, knee, ankle]: [Vec3; 3]| (knee - hip).angle_between(ankle - knee).to_degrees();
            let places = ["UpperLeg", "LowerLeg", "Foot"]
                .map(|bone| joint(&solved, &own, &format!("{}{bone}", side.to_lowercase())).0);
            let true_places =
                ["UpLeg", "Leg", "Foot"].map(|name| joint(&truth, &other, &sided(side, name)).0 * MILLIMETRES);
            for (place, true_place) in places.iter().zip(true_places) {
                // Half of the width of a knee: where it is on its axis the motion does not tell.
                assert!(
                    place.distance(true_place) < 30.0,
                    "{side}, frame {frame}: {places:?}, {true_places:?}"
                );
            }
            angles.push(bend(places) - bend(true_places));
        }
        let rms = (angles.iter().map(|angle| angle * angle).sum::<f32>() / angles.len() as f32).sqrt();
        assert!(rms < 3.0, "{side} knee: {rms} degrees RMS");
    }
    // Two markers of a thigh do not tell how it turns.
    let mut few = planted().1;
    let third = few.labels.iter().position(|label| label == "LTH3").unwrap();
    few.labels.remove(third);
    for frame in &mut few.frames {
        frame.remove(third);
    }
    assert!(
        few.read()
            .unwrap_err()
            .to_string()
            .contains("do not tell where the legs are")
    );
}
