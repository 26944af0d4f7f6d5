//! Tests of smoothing, spikes and gaps.

use mocap::edit::{Despike, Fill, Smooth, SmoothFilter, Step, StepInput};
use mocap::glam::Quat;
use mocap::scene::Keys;

use super::*;

const WALK: &str = "cmu_12_01_walk.bvh";

/// The largest angle between the rotations of two scenes in degrees, and the frame.
fn largest_turn(a: &Scene, b: &Scene) -> (f32, usize) {
    let channels = a.animations[0].channels.iter().zip(&b.animations[0].channels);
    let angles = channels.flat_map(|(a, b)| {
        (0..a.rotation_keys.len().max(b.rotation_keys.len())).map(|frame| {
            let at = |keys: &Keys<Quat>| keys.sample(frame as f64).unwrap();
            let change = at(&a.rotation_keys).inverse() * at(&b.rotation_keys);
            ((2.0 * change.xyz().length().min(1.0).asin()).to_degrees(), frame)
        })
    });
    angles.fold((0.0, 0), |most, angle| if angle.0 > most.0 { angle } else { most })
}

#[test]
fn an_oscillation_keeps_the_share_that_the_filter_states() {
    for (filter, share) in [
        (SmoothFilter::Butterworth, 1.0 / (1.0 + 16.0)),
        (SmoothFilter::Gaussian, 0.5f32.powi(4)),
    ] {
        let mut scene = import(WALK);
        let channel = &mut scene.animations[0].channels[3];
        let axis = Vec3::new(0.6, 0.8, 0.0);
        // An oscillation of 12 Hz at 120 frames per second about an axis, added to a rotation far from the identity.
        let base = Quat::from_rotation_z(2.0);
        let angle = |frame: usize| 0.2 * (std::f32::consts::TAU * frame as f32 / 10.0).sin();
        let wave = (0..523).map(|frame| base * Quat::from_axis_angle(axis, angle(frame)));
        channel.rotation_keys = Keys::every_tick(wave.collect());
        let smooth = Smooth::new().filter(filter).cut_off(6.0);
        smooth.apply(&mut scene, &StepInput::new()).unwrap();
        for frame in 60..460 {
            let change = base.inverse() * scene.animations[0].channels[3].rotation_keys.values[frame];
            let found = 2.0 * change.xyz().dot(axis).asin();
            assert!(
                (found - share * angle(frame)).abs() < 0.003,
                "{filter:?} {frame}: {found}"
            );
        }
    }
}

#[test]
fn smoothing_keeps_bones_ends_and_what_is_slow() {
    let before = import(WALK);
    for filter in [SmoothFilter::Butterworth, SmoothFilter::Gaussian] {
        let mut scene = before.clone();
        let smooth = Smooth::new().filter(filter).cut_off(15.0);
        smooth.apply(&mut scene, &StepInput::new()).unwrap();
        assert_bones_keep_their_lengths(&before, &scene);
        assert_eq!(scene.validate(), []);
        let (old, new) = (positions(&before), positions(&scene));
        for frame in [0, old.len() - 1] {
            assert!(old[frame].iter().zip(&new[frame]).all(|(a, b)| a.distance(*b) < 1e-5));
        }
        let moved = old
            .iter()
            .flatten()
            .zip(new.iter().flatten())
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max);
        assert!(0.0 < moved && moved < 0.02, "{moved}");
    }
    let error = Smooth::new()
        .cut_off(61.0)
        .apply(&mut before.clone(), &StepInput::new())
        .unwrap_err();
    assert!(
        error
            .diagnostic()
            .message
            .starts_with("cut-off must be above 0 and below half of the frame rate, 60.0"),
        "{error}"
    );
}

/// The rotations of every channel, by the name of its node.
fn rotations(scene: &Scene) -> Vec<(String, Vec<Quat>)> {
    let animation = &scene.animations[0];
    let channels = animation.channels.iter();
    channels
        .map(|channel| (channel.node_name.clone(), channel.rotation_keys.values.clone()))
        .collect()
}

/// The largest angle between two rotations of the same frame, in radians.
fn farthest(a: &[Quat], b: &[Quat]) -> f32 {
    let angles = a.iter().zip(b).map(|(a, b)| a.angle_between(*b));
    angles.fold(0.0, f32::max)
}

#[test]
fn a_part_alone_is_smoothed_in_a_range_alone() {
    let before = import(WALK);
    let whole = {
        let mut scene = before.clone();
        Smooth::new().apply(&mut scene, &StepInput::new()).unwrap();
        rotations(&scene)
    };
    let is_arm = |name: &str| {
        ["Shoulder", "Arm", "Hand", "Thumb", "Finger"]
            .iter()
            .any(|part| name.contains(part))
    };
    for (step, is_of_part) in [
        ("smooth:part=arms,range=120f..240f", &is_arm as &dyn Fn(&str) -> bool),
        ("smooth:joints=head+LeftFoot,range=120f..240f", &|name: &str| {
            ["Head", "LeftFoot"].contains(&name)
        }),
        ("smooth:range=120f..240f", &|_: &str| true),
    ] {
        let mut scene = before.clone();
        let step: mocap::edit::EditStep = step.parse().unwrap();
        step.apply(&mut scene, &StepInput::new()).unwrap();
        let mut changed = 0;
        for (((name, old), (_, new)), (_, all)) in rotations(&before).iter().zip(&rotations(&scene)).zip(&whole) {
            if !is_of_part(name) || old.len() < 2 {
                assert!(old == new, "{step}: {name}");
                continue;
            }
            // 0.2 s are 24 frames, in which the filter eases in and out.
            assert!(farthest(&old[..95], &new[..95]) < 1e-3, "{step}: {name}");
            assert!(farthest(&old[266..], &new[266..]) < 1e-3, "{step}: {name}");
            assert!(new[120..=240] == all[120..=240], "{step}: {name}");
            changed += usize::from(old != new);
        }
        assert!(changed > 0, "{step}");
        assert_bones_keep_their_lengths(&before, &scene);
    }
    for (step, message) in [
        ("smooth:joints=LeftHnad", "no node or bone is called \"LeftHnad\""),
        ("smooth:range=9..10", "the part to keep begins after the last frame"),
        ("smooth:ease=-1", "ease must be"),
    ] {
        let step: mocap::edit::EditStep = step.parse().unwrap();
        let error = step.apply(&mut before.clone(), &StepInput::new()).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
    }
}

#[test]
fn spikes_go_and_the_motion_stays() {
    let mut clean = import(WALK);
    // The toes of this file jump by 7 degrees for one frame, three times.
    let report = Despike::new().apply(&mut clean, &StepInput::new()).unwrap();
    assert_eq!((report.replaced, report.joints), (3, vec!["LeftToeBase".to_owned()]));
    let mut untouched = clean.clone();
    let report = Despike::new().change(&mut untouched, &StepInput::new()).unwrap();
    assert_eq!((report.replaced, untouched == clean), (0, true), "{report:?}");

    let mut scene = clean.clone();
    let spikes = [(3usize, 50usize, 1usize), (7, 200, 2), (12, 201, 3), (20, 400, 1)];
    for (channel, frame, length) in spikes {
        for keys in &mut scene.animations[0].channels[channel].rotation_keys.values[frame..frame + length] {
            *keys *= Quat::from_rotation_y(0.5);
        }
    }
    let report = Despike::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!((report.replaced, report.joints.len()), (7, 4), "{report:?}");
    let (off, frame) = largest_turn(&clean, &scene);
    assert!(off < 1.0, "{off} degrees in frame {frame}");
    assert_bones_keep_their_lengths(&clean, &scene);
}

/// The largest step of any rotation in degrees, from `first` on.
fn largest_step(scene: &Scene, first: usize) -> f32 {
    let steps = scene.animations[0].channels.iter().flat_map(|channel| {
        let keys = &channel.rotation_keys.values;
        let from = first.min(keys.len().saturating_sub(1));
        keys[from..]
            .windows(2)
            .map(|pair| pair[0].angle_between(pair[1]).to_degrees())
    });
    steps.fold(0.0, f32::max)
}

/// Plants a roll as a camera produces it: the upper arm rolls from a frame on, and the forearm rolls back.
#[test]
fn a_bone_that_is_turned_about_itself_from_a_frame_on_turns_slowly() {
    let mut scene = import(WALK);
    Despike::new().apply(&mut scene, &StepInput::new()).unwrap();
    let walk = scene.clone();
    let before = positions(&walk);
    let of = |name: &str| walk.nodes.iter().position(|node| node.name == name).unwrap();
    let bone = walk.nodes[of("LeftForeArm")].transform.w_axis.truncate().normalize();
    let turn = Quat::from_axis_angle(bone, 1.5);
    for channel in &mut scene.animations[0].channels {
        let turned = channel.rotation_keys.values.iter_mut().skip(200);
        match channel.node_name.as_str() {
            "LeftArm" => turned.for_each(|rotation| *rotation *= turn),
            "LeftForeArm" => turned.for_each(|rotation| *rotation = turn.inverse() * *rotation),
            _ => {}
        }
    }
    assert!(largest_step(&scene, 0) > 80.0);
    let report = Despike::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!(report.joints, ["LeftArm", "LeftForeArm"]);
    // 86 degrees over 0.4 s in 48 frames are 2.7 degrees per frame at the fastest frame.
    assert!(largest_step(&scene, 0) < largest_step(&walk, 0) + 2.7);
    for (before, after) in before.iter().flatten().zip(positions(&scene).iter().flatten()) {
        assert!(before.distance(*after) < 1e-3, "{before} {after}");
    }
}

/// 19 steps of this take are larger than 60 degrees. The first step leaves the rest pose at the beginning.
#[test]
fn arms_of_a_depth_camera_turn_about_themselves_no_more() {
    let mut scene = import("kinect_openni.bvh");
    scene.trim(0.0, 520.0);
    assert!(largest_step(&scene, 13) > 130.0);
    Despike::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert!(largest_step(&scene, 13) < 65.0, "{}", largest_step(&scene, 13));
}

#[test]
fn gaps_are_filled_as_the_motion_went() {
    let mut clean = import(WALK);
    // The truth has no noise, because no algorithm could restore noise in a gap.
    Smooth::new().apply(&mut clean, &StepInput::new()).unwrap();
    let mut scene = clean.clone();
    for channel in &mut scene.animations[0].channels {
        for (first, last) in [(100, 112), (250, 255), (300, 399)] {
            let rotations = &mut channel.rotation_keys.values;
            if rotations.len() > 1 {
                let held = rotations[first - 1];
                rotations[first..=last].fill(held);
            }
            let positions = &mut channel.position_keys.values;
            if positions.len() > 1 {
                let held = positions[first - 1];
                positions[first..=last].fill(held);
            }
        }
    }
    let held = scene.clone();
    let report = Fill::new().apply(&mut scene, &StepInput::new()).unwrap();
    assert_eq!(report.gaps, [[100, 112], [250, 255]]);
    assert_eq!(report.longer, [[300, 399]]);
    let part = |scene: &Scene| {
        let mut scene = scene.clone();
        scene.trim(0.0, 290.0);
        scene
    };
    let (off, off_held) = (
        largest_turn(&part(&clean), &part(&scene)).0,
        largest_turn(&part(&clean), &part(&held)).0,
    );
    assert!(off < 0.35 * off_held, "{off} of {off_held} degrees");
    assert_bones_keep_their_lengths(&held, &scene);
    // Frames that were not held stay unchanged, and so does the gap that is too long.
    let (old, new) = (positions(&held), positions(&scene));
    for frame in (0..old.len()).filter(|frame| !(100..=112).contains(frame) && !(250..=255).contains(frame)) {
        assert_eq!(old[frame], new[frame], "{frame}");
    }
}
