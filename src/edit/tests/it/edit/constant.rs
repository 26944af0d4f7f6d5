//! Laws of keys for every step. A track with one key keeps one key, unless the step moves its joint. A motion of
//! constant speed keeps its speed if a step interpolates it.

use std::fs;

use mocap::convert::{AlongBone, FirstFrame, Moment, RestPoseSource, RootMotion};
use mocap::edit::{InBetween, Reverse, Step, StepInput};
use mocap::glam::{EulerRot, Vec3};
use mocap::scene::{Channel, Keys, NodeKind, UpAxis};
use mocap::{Binding, Conversion, Exporter, Format, Scene};

use super::import;
use super::laws::{apply, steps};
use crate::sample::Sample;
use crate::still::still_joints;

/// The frames of each fixture. They suffice for every step to change something.
const FRAMES: f64 = 60.0;

/// The least difference of positions of a moving joint, as a fraction of the longest offset of its skeleton.
const MOVES: f32 = 1e-4;

/// The files of motion that are read here, by their names.
fn fixtures() -> Vec<(String, Scene)> {
    let entries = fs::read_dir("../../fixtures/real").unwrap();
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let read = |path: std::path::PathBuf| {
        let mut scene = mocap::import(&path).ok().filter(|scene| !scene.animations.is_empty())?;
        scene.trim(0.0, FRAMES);
        Some((path.file_name()?.to_string_lossy().into_owned(), scene))
    };
    files.into_iter().filter_map(read).collect()
}

/// Whether a track had one key and now has several keys with the same value.
fn is_blurred<T: Copy>(before: &Keys<T>, after: &Keys<T>, distance: impl Fn(T, T) -> f32, least: f32) -> bool {
    let [first, others @ ..] = after.values.as_slice() else {
        return false;
    };
    let is_still = others.iter().all(|value| distance(*first, *value) <= least);
    before.len() <= 1 && !others.is_empty() && is_still
}

/// The tracks that had one key and now have several keys with the same value.
fn blurred(before: &Scene, after: &Scene) -> Vec<String> {
    let offsets = after
        .nodes
        .iter()
        .skip(1)
        .map(|node| node.transform.w_axis.truncate().length());
    let size = offsets.fold(f32::MIN_POSITIVE, f32::max);
    let distance = |a: Vec3, b: Vec3| a.distance(b);
    let mut found = Vec::new();
    for old in &before.animations[0].channels {
        let mut channels = after.animations[0].channels.iter();
        let Some(new) = channels.find(|new| new.node_name == old.node_name) else {
            continue;
        };
        let kinds = [
            (
                "position",
                is_blurred(&old.position_keys, &new.position_keys, distance, MOVES * size),
            ),
            (
                "scale",
                is_blurred(&old.scaling_keys, &new.scaling_keys, distance, MOVES),
            ),
        ];
        let blurred = kinds.into_iter().filter(|(_, is_blurred)| *is_blurred);
        found.extend(blurred.map(|(kind, _)| format!("{kind} of {}", old.node_name)));
    }
    found
}

fn conversions() -> Vec<(&'static str, Conversion)> {
    let new = Conversion::new;
    vec![
        ("metres with +Y up", new()),
        ("feet with +Z up", new().metres_per_unit(0.3048).up(UpAxis::Z)),
        (
            "units of a third of a metre",
            new().metres_per_unit(1.0).out_metres_per_unit(1.0 / 3.0),
        ),
        (
            "a part at another rate",
            new().trim(Moment::Frame(3), Moment::Frame(40)).frame_rate(37.0),
        ),
        ("without the first frame", new().first_frame(FirstFrame::Drop)),
        ("a frame as rest pose", new().rest(RestPoseSource::Frame(7))),
        ("T-pose", new().rest(RestPoseSource::TPose)),
        ("A-pose", new().rest(RestPoseSource::APose)),
        ("T-pose first", new().t_pose_first(true)),
        ("bones along +Y", new().bone_axis(Some(AlongBone::Y))),
        ("in place", new().root(RootMotion::InPlace)),
        ("root motion", new().root(RootMotion::Extract)),
    ]
}

#[test]
fn a_track_with_one_key_has_one_key_after_every_step() {
    let mut random = Sample::new();
    let (mut edits, mut converted) = (0, 0);
    for (file, before) in random.some(fixtures(), 4) {
        let mut other = before.clone();
        Reverse::new().apply(&mut other, &StepInput::new()).unwrap();
        for step in steps() {
            let mut after = before.clone();
            if apply(step, &mut after, &other).is_ok() {
                assert_eq!(blurred(&before, &after), [""; 0], "{file}: {step}");
                edits += 1;
            }
        }
        for (name, conversion) in conversions() {
            let mut after = before.clone();
            if conversion.apply(&mut after).is_ok() {
                assert_eq!(blurred(&before, &after), [""; 0], "{file}: {name}");
                converted += 1;
            }
        }
    }
    assert!(
        edits > 100 && converted > 30,
        "only {edits} edits and {converted} conversions were done"
    );
}

/// Steps that rotate single joints: to a target, by their partners' rotations, or from a T-pose to the motion.
const ROTATING: [&str; 6] = ["foot-lock", "look-at", "mirror", "pin", "reach", "t-pose-first"];

/// The text of a file shows which joints are still.
#[test]
fn a_joint_that_is_still_in_the_text_of_a_file_has_one_rotation_key_after_every_step() {
    let mut tried = 0;
    for file in [
        "real/cmu_mixed_rotation_orders.bvh",
        "real/motionbuilder_vicon_walk.bvh",
        "real/rokoko_dance.bvh",
        "skeletons/accad_run_turn.bvh",
    ] {
        let still = still_joints(file);
        let mut before = mocap::import(format!("../../fixtures/{file}")).unwrap();
        before.trim(0.0, FRAMES);
        let mut other = before.clone();
        Reverse::new().apply(&mut other, &StepInput::new()).unwrap();
        let mut changed: Vec<(&str, Scene)> = Vec::new();
        let is_still = |step: &&str| !ROTATING.iter().any(|name| step.starts_with(name));
        for step in steps().into_iter().filter(is_still) {
            let mut after = before.clone();
            if apply(step, &mut after, &other).is_ok() {
                changed.push((step, after));
            }
        }
        let all = conversions().into_iter();
        for (name, conversion) in all.filter(|(name, _)| *name != "T-pose first") {
            let mut after = before.clone();
            if conversion.apply(&mut after).is_ok() {
                changed.push((name, after));
            }
        }
        for (step, after) in changed {
            for channel in &after.animations[0].channels {
                if still.contains(&channel.node_name) {
                    assert_eq!(channel.rotation_keys.len(), 1, "{file}: {step}: {}", channel.node_name);
                    tried += 1;
                }
            }
        }
    }
    assert!(tried > 300, "{tried} joints are still");
}

/// End sites have no channels in a file, and their rotation moves nothing.
#[test]
fn no_step_gives_an_end_site_a_channel() {
    let chains = [
        "reach:start=Shoulder,to=1.5/2.5/0",
        "reach:start=RightArm,tip=EndSite_RThumb,to=1/1/1",
        "pin:start=Shoulder,range=2f..6f",
    ];
    let mut bent = 0;
    for file in ["lecture_Test.bvh", "cmu_12_01_walk.bvh"] {
        let mut before = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
        before.trim(0.0, FRAMES);
        for step in steps().into_iter().chain(chains) {
            let mut after = before.clone();
            if apply(step, &mut after, &before).is_err() {
                continue;
            }
            bent += usize::from(chains.contains(&step));
            for (node, _) in Binding::new(&after, &after.animations[0]).driven() {
                let node = &after.nodes[node.index()];
                assert_ne!(node.kind, NodeKind::EndSite, "{file}: {step}: {}", node.name);
            }
        }
    }
    assert_eq!(bent, chains.len());
}

/// The nodes that move in the output are the nodes that move in the source.
#[test]
fn a_motion_of_key_frames_has_the_columns_of_its_source() {
    let mut scene = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    InBetween::new()
        .keys(vec![0, 9])
        .apply(&mut scene, &StepInput::new())
        .unwrap();
    let written = Exporter::new()
        .write(&scene, Format::Bvh)
        .unwrap()
        .into_bytes()
        .unwrap();
    let text = String::from_utf8(written).unwrap();
    let row = text.lines().last().unwrap();
    assert_eq!(row.split_whitespace().count(), 12, "{text}");

    let mut walk = import("cmu_12_01_walk.bvh");
    InBetween::new().every(15).apply(&mut walk, &StepInput::new()).unwrap();
    let channels = walk.animations[0].channels.iter();
    let moving: Vec<&str> = channels
        .filter(|channel| channel.position_keys.len() > 1)
        .map(|channel| &*channel.node_name)
        .collect();
    assert_eq!(moving, ["Hips"]);
}

/// The degrees of a channel of the lecture's arm, frame by frame. All rotations of the arm are about Z.
fn degrees(scene: &Scene, channel: usize) -> Vec<f32> {
    let rotations = &scene.animations[0].channels[channel].rotation_keys.values;
    rotations
        .iter()
        .map(|rotation| rotation.to_euler(EulerRot::ZYX).0.to_degrees())
        .collect()
}

/// The largest change of a speed from frame to frame, in degrees or in the file's unit.
fn largest_bend(scene: &Scene) -> f32 {
    let bend = |values: &[f32]| {
        let bends = values
            .windows(3)
            .map(|three| (three[2] - 2.0 * three[1] + three[0]).abs());
        bends.fold(0.0, f32::max)
    };
    let of_channel = |(index, channel): (usize, &Channel)| {
        let at = |axis: usize| bend(&Vec::from_iter(channel.position_keys.values.iter().map(|at| at[axis])));
        (0..3).map(at).fold(bend(&degrees(scene, index)), f32::max)
    };
    scene.animations[0]
        .channels
        .iter()
        .enumerate()
        .map(of_channel)
        .fold(0.0, f32::max)
}

/// Steps that change speeds on purpose: two of them join motions, and one bends a path.
const BENDING: [&str; 3] = ["loop", "concat", "warp:path"];

/// Every angle and the position of the lecture's arm have constant speeds.
#[test]
fn a_motion_of_constant_speed_keeps_it_in_every_step() {
    let arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    assert!(largest_bend(&arm) < 1e-4);
    let uneven = [
        "in-between:keys=0+1+9",
        "in-between:keys=2+5+6",
        "warp:speed=2",
        "warp:0.2=0.6,0.9=2.7",
        "resample:rate=37",
    ];
    let tried = steps().into_iter().chain(uneven);
    let mut done = Vec::new();
    for step in tried.filter(|step| !BENDING.iter().any(|bends| step.starts_with(bends))) {
        let mut after = arm.clone();
        if apply(step, &mut after, &arm).is_ok() {
            assert!(largest_bend(&after) < 1e-4, "{step}: {}", largest_bend(&after));
            done.push(step);
        }
    }
    for (name, conversion) in conversions() {
        let mut after = arm.clone();
        if conversion.apply(&mut after).is_ok() {
            assert!(largest_bend(&after) < 1e-4, "{name}: {}", largest_bend(&after));
        }
    }
    assert!(
        uneven.iter().all(|step| done.contains(step)) && done.len() > 15,
        "{done:?}"
    );
}

/// The elbow of the file rotates from 10 to 100 degrees, 10 degrees in each frame.
#[test]
fn a_straight_line_between_two_keys_is_that_of_the_file() {
    let mut arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    apply("in-between:keys=0+9", &mut arm, &Scene::default()).unwrap();
    for (frame, found) in degrees(&arm, 1).into_iter().enumerate() {
        let expected = 10.0 * (frame + 1) as f32;
        assert!((found - expected).abs() < 1e-4, "{found} degrees in frame {frame}");
    }
}

/// A report states the frames and the seconds of the changed motion.
#[test]
fn reports_state_the_frames_and_the_seconds_that_are_there() {
    for file in ["lecture_Test.bvh", "cmu_12_01_walk.bvh"] {
        let mut before = mocap::import(format!("../../fixtures/real/{file}")).unwrap();
        before.trim(0.0, 150.0);
        let mut tried = 0;
        for step in steps().into_iter().chain([
            "warp:speed=2",
            "warp:speed=1.7",
            "resample:rate=37",
            "trim:range=0..0.44",
        ]) {
            let mut after = before.clone();
            let Ok(report) = apply(step, &mut after, &before) else {
                continue;
            };
            let report = serde_json::to_value(&report).unwrap();
            let animation = &after.animations[0];
            if let Some(seconds) = report["changed"]["seconds"].as_f64() {
                let expected = animation.duration / animation.ticks_per_second;
                assert!(
                    (seconds - expected).abs() < 1e-9,
                    "{file}: {step}: {report}, and there are {expected} s"
                );
                tried += 1;
            }
        }
        assert!(tried >= 5, "{file}: {tried} reports state seconds");
    }
}

/// If a warp has no pair for the start of the motion, the warp gets the pair (0, 0). So no pose is repeated.
#[test]
fn a_warp_from_its_first_moment_on_repeats_no_pose() {
    let arm = mocap::import("../../fixtures/real/lecture_Test.bvh").unwrap();
    let elbow = |step: &str| {
        let mut scene = arm.clone();
        apply(step, &mut scene, &Scene::default()).unwrap();
        degrees(&scene, 1)
    };
    // Half of the speed up to 0.3 s, and the old speed afterwards.
    let expected = [
        10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.0,
    ];
    let found = elbow("warp:0.3=0.6");
    assert!(
        found
            .iter()
            .zip(expected)
            .all(|(found, expected)| (found - expected).abs() < 1e-3),
        "{found:?}"
    );
    assert_eq!(found.len(), expected.len());
    // The inverse of the warp above, and a warp that cuts off the start.
    assert_eq!(elbow("warp:0.6=0.3").len(), 7);
    let cut = elbow("warp:0.3=0");
    assert!((cut[0] - 40.0).abs() < 1e-3 && cut.len() == 7, "{cut:?}");
}
