//! Tests of joints whose markers are hidden for a while.

use mocap::Pose;
use mocap::glam::Vec3;

use super::landmarks::GUIDES;
use super::planted::{MILLIMETRES, joint, planted, walk};
use super::sets::markers;

/// The stride between the used frames of the walk, which leaves 24 frames per second.
const EVERY: usize = 5;

/// A third of a second, in which the arm swings forward.
const GAP: std::ops::Range<usize> = 40..48;

/// A gap of 1.7 s.
const LONG_GAP: std::ops::Range<usize> = 30..71;

/// The markers of the left arm below the shoulder.
const ARM: [&str; 6] = ["LUPA", "LELB", "LFRM", "LWRA", "LWRB", "LFIN"];

#[test]
fn an_arm_swings_on_while_its_markers_are_not_seen() {
    let whole = planted(&walk(), EVERY, &markers(GUIDES[0].1));
    let mut gap = planted(&walk(), EVERY, &markers(GUIDES[0].1));
    for label in ARM {
        let marker = gap.labels.iter().position(|own| own == label).unwrap();
        gap.frames[GAP].iter_mut().for_each(|frame| frame[marker] = Vec3::NAN);
    }
    let [whole, gap] = [whole.solved(), gap.solved()];
    let warned = gap
        .warnings
        .iter()
        .filter(|warning| warning.code == mocap::Code::Gap)
        .count();
    assert_eq!(warned, 6, "{:?}", gap.warnings);
    let filled = |scene: &mocap::Scene| {
        let said = scene.metadata.assumptions.iter();
        said.map(|said| said.choice.clone())
            .find(|choice| choice.starts_with("rotations were filled"))
    };
    assert_eq!(filled(&whole), None);
    assert!(
        filled(&gap).is_some_and(|note| note.contains("leftUpperArm 40 to 47")),
        "{:?}",
        filled(&gap)
    );
    for frame in GAP {
        let [own, other] = [&gap, &whole].map(|scene| {
            let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
            joint(scene, &pose, "leftHand").0
        });
        // The positions are in millimetres.
        assert!(own.distance(other) < 30.0, "frame {frame}: {} mm", own.distance(other));
    }
}

/// The walk with some markers hidden in a range of frames.
fn hidden(labels: &[&str], frames: std::ops::Range<usize>) -> mocap::Scene {
    let mut walk = planted(&walk(), EVERY, &markers(GUIDES[0].1));
    for marker in 0..walk.labels.len() {
        if labels.is_empty() || labels.contains(&walk.labels[marker].as_str()) {
            walk.frames[frames.clone()]
                .iter_mut()
                .for_each(|frame| frame[marker] = Vec3::NAN);
        }
    }
    walk.solved()
}

#[test]
fn filled_frames_are_marked_in_the_report_the_table_and_the_provenance() {
    let scene = hidden(&ARM, GAP);
    let solved = scene.metadata.solved.as_ref().unwrap();
    let arm = solved
        .filled
        .iter()
        .find(|filled| filled.joint == "leftUpperArm")
        .unwrap();
    assert_eq!((arm.first, arm.last), (40, 47));
    let angles = mocap::biomechanics::JointAngles::of(&scene).unwrap();
    let filled: Vec<f64> = angles.column("filled_joints").unwrap().collect();
    for (frame, count) in filled.iter().enumerate() {
        assert_eq!(*count > 0.0, GAP.contains(&frame), "frame {frame}: {count}");
    }
    let whole = planted(&walk(), EVERY, &markers(GUIDES[0].1)).solved();
    let angles = mocap::biomechanics::JointAngles::of(&whole).unwrap();
    assert!(angles.column("filled_joints").is_none());
}

#[test]
fn an_elbow_that_is_never_seen_changes_nothing_but_its_arm() {
    let whole = planted(&walk(), EVERY, &markers(GUIDES[0].1)).solved();
    let without = hidden(&["LELB"], 0..planted(&walk(), EVERY, &[]).frames.len());
    for frame in [0, 30, 60] {
        for name in ["hips", "chest", "head", "rightHand", "leftFoot"] {
            let [own, other] = [&without, &whole].map(|scene| {
                let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
                joint(scene, &pose, name).0
            });
            assert!(
                own.distance(other) < 15.0,
                "{name} in frame {frame}: {}",
                own.distance(other)
            );
        }
    }
    let said = |words: &str| without.warnings.iter().any(|warning| warning.message.contains(words));
    assert!(said("seen in no frame"), "{:?}", without.warnings);
    assert!(said("segment (4): LFRM, LWRA, LWRB, LFIN"), "{:?}", without.warnings);
}

#[test]
fn knees_with_exchanged_labels_in_the_whole_take_are_named() {
    let mut walk_of_labels = planted(&walk(), EVERY, &markers(GUIDES[0].1));
    let whole = planted(&walk(), EVERY, &markers(GUIDES[0].1)).solved();
    for label in &mut walk_of_labels.labels {
        match label.as_str() {
            "LKNE" => "RKNE".clone_into(label),
            "RKNE" => "LKNE".clone_into(label),
            _ => {}
        }
    }
    let scene = walk_of_labels.solved();
    let solved = scene.metadata.solved.as_ref().unwrap();
    let swap = &solved.swaps[0];
    assert_eq!((solved.swaps.len(), swap.first), (1, 0));
    assert_eq!(swap.last + 1, walk_of_labels.frames.len());
    for name in ["leftLowerLeg", "rightLowerLeg"] {
        let [own, other] = [&scene, &whole].map(|scene| {
            let pose = Pose::at_tick(scene, 0, 20.0).unwrap();
            joint(scene, &pose, name).0
        });
        assert!(own.distance(other) < 1.0, "{name}: {}", own.distance(other));
    }
}

/// The largest distance of a solved joint from the true joint in some frames, in millimetres.
fn worst(solved: &mocap::Scene, names: [&str; 2], frames: std::ops::Range<usize>) -> f32 {
    let truth = walk();
    let distance = |frame: usize| {
        let own = Pose::at_tick(solved, 0, frame as f64).unwrap();
        let other = Pose::at_tick(&truth, 0, (1 + frame * EVERY) as f64).unwrap();
        let place = joint(&truth, &other, names[1]).0 * MILLIMETRES;
        joint(solved, &own, names[0]).0.distance(place)
    };
    frames.map(distance).fold(0.0, f32::max)
}

#[test]
fn a_head_without_markers_for_a_long_time_rotates_smoothly() {
    let solved = hidden(&["LFHD", "RFHD", "LBHD", "RBHD"], LONG_GAP);
    let truth = walk();
    // Rotations since the first frame do not depend on the axes of the bone.
    let since = |scene: &mocap::Scene, name: &str, [first, frame]: [usize; 2]| {
        let [first, frame] = [first, frame].map(|frame| {
            let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
            joint(scene, &pose, name).1
        });
        frame * first.inverse()
    };
    for frame in LONG_GAP {
        let own = since(&solved, "head", [0, frame]);
        let other = since(&truth, "Head", [1, 1 + frame * EVERY]);
        let off = own.angle_between(other).to_degrees();
        assert!(off < 10.0, "frame {frame}: {off} degrees");
    }
}

#[test]
fn a_leg_without_markers_for_a_long_time_is_off_by_a_step_at_most() {
    let leg = ["LTHI", "LKNE", "LSHN", "LANK", "LHEE", "LTOE", "LMT5"];
    let off = worst(&hidden(&leg, LONG_GAP), ["leftFoot", "LeftFoot"], LONG_GAP);
    // A step of this walk, which nobody sees in the gap.
    assert!(off < 600.0, "{off} mm");
}

#[test]
fn an_arm_that_is_hidden_at_an_end_of_the_take_hangs_as_before() {
    let frames = planted(&walk(), EVERY, &[]).frames.len();
    for gap in [0..20, frames - 20..frames] {
        let off = worst(&hidden(&ARM, gap.clone()), ["leftHand", "LeftHand"], gap.clone());
        assert!(off < 200.0, "{gap:?}: {off} mm");
    }
}

#[test]
fn a_person_walks_on_while_no_marker_is_seen() {
    for (gap, most) in [(GAP, 30.0), (LONG_GAP, 120.0)] {
        let off = worst(&hidden(&[], gap.clone()), ["leftUpperLeg", "LeftUpLeg"], gap.clone());
        assert!(off < most, "{gap:?}: {off} mm");
    }
}
