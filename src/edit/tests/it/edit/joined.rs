//! Tests of loops, and of motions that are made of two.

use glam::Quat;
use mocap::edit::report::{BlendReport, ConcatReport, WarpReport, WarpTimeReport};
use mocap::edit::{
    Blend, BlendWeight, Concat, InBetween, KeyInterpolation, Layer, LayerPart, Loop, Mirror, Smooth, Step, StepInput,
    Turn, Warp,
};
use mocap::figure::{Humanoid, HumanoidBone};

use mocap::Code;
use proptest::prelude::*;

use super::*;

const WALK: &str = "cmu_12_01_walk.bvh";

fn concat(scene: &mut Scene, other: &Scene) -> mocap::Result<ConcatReport> {
    Concat::new().apply(scene, &StepInput::new().other(other))
}

fn blend(scene: &mut Scene, other: &Scene, weight: impl Into<BlendWeight>) -> mocap::Result<BlendReport> {
    Blend::new()
        .weight(weight.into())
        .apply(scene, &StepInput::new().other(other))
}

fn warp_time(scene: &mut Scene, moments: &[(f64, f64)]) -> mocap::Result<WarpTimeReport> {
    match Warp::Moments(moments.to_vec()).apply(scene, &StepInput::new())? {
        WarpReport::Time(report) => Ok(report),
        other => panic!("{other:?}"),
    }
}

fn part(scene: &Scene, first: usize, last: usize) -> Scene {
    let mut scene = scene.clone();
    scene.trim(first as f64, last as f64);
    scene
}

#[track_caller]
fn assert_same_motion(a: &Scene, b: &Scene, tolerance: f32) {
    let (a, b) = (positions(a), positions(b));
    assert_eq!(a.len(), b.len());
    for (frame, (a, b)) in a.iter().zip(&b).enumerate() {
        for (node, (a, b)) in a.iter().zip(b).enumerate() {
            assert!(a.distance(*b) <= tolerance, "node {node} in frame {frame}: {a} {b}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_clip_that_is_cut_in_two_comes_back(cut in 2usize..520) {
        let whole = import(WALK);
        let (mut first, second) = (part(&whole, 0, cut), part(&whole, cut, 522));
        let report = concat(&mut first, &second).unwrap();
        prop_assert_eq!((report.seam, report.frames), (cut, 523));
        assert_same_motion(&whole, &first, 1e-5);
        prop_assert_eq!(first.validate(), []);
    }

    #[test]
    fn a_warp_and_its_inverse_is_nothing(middle in 1u32..5, factor in 2u32..4) {
        let scene = import(WALK);
        let mut warped = scene.clone();
        let rate = scene.animations[0].ticks_per_second;
        // The times are whole frames, before and after the warp.
        let moment = |frame: u32, to: u32| (f64::from(frame) / rate, f64::from(to) / rate);
        let middle = 100 * middle;
        let moments = [moment(0, 0), moment(middle, middle), moment(522, middle + factor * (522 - middle))];
        let report = warp_time(&mut warped, &moments).unwrap();
        prop_assert!((report.slowest - 1.0 / f64::from(factor)).abs() < 1e-9);
        assert_bones_keep_their_lengths(&part(&scene, 0, 0), &part(&warped, 0, 0));
        let inverse = moments.map(|(from, to)| (to, from));
        warp_time(&mut warped, &inverse).unwrap();
        assert_same_motion(&scene, &warped, 1e-5);
    }
}

#[test]
fn another_motion_begins_where_the_first_ends() {
    let walk = import(WALK);
    let mut scene = part(&walk, 0, 200);
    let other = part(&walk, 37, 237);
    let report = concat(&mut scene, &other).unwrap();
    assert!(report.largest_rotation > 1.0 && report.frames == 401, "{report:?}");
    let at = positions(&scene);
    // No node jumps farther at the seam than it moves from frame to frame elsewhere.
    let step = |frame: usize, node: usize| at[frame][node].distance(at[frame + 1][node]);
    for node in 0..scene.nodes.len() {
        let fastest = (0..190).map(|frame| step(frame, node)).fold(0.0, f32::max);
        assert!(
            (198..204).all(|frame| step(frame, node) < 1.5 * fastest + 1e-4),
            "{}",
            scene.nodes[node].name
        );
    }
    assert_bones_keep_their_lengths(&part(&walk, 0, 0), &part(&scene, 0, 0));
    let error = concat(&mut scene, &import("z_up_dab.bvh")).unwrap_err();
    assert!(
        error
            .diagnostic()
            .message
            .starts_with("the two motions have different skeletons: "),
        "{error}"
    );
}

/// The condition of animsmith for a loop: the speeds of joints at the first and last frame differ by at most 0.1 m/s.
#[test]
fn a_loop_goes_on_as_fast_as_it_ends() {
    for file in [
        WALK,
        "motionbuilder_vicon_walk.bvh",
        "additive_root_walk.bvh",
        "makehuman_zombie_walk.bvh",
    ] {
        let mut scene = import(file);
        let options = Loop::new().in_place(true);
        options.apply(&mut scene, &StepInput::new()).unwrap();
        let rate = scene.animations[0].ticks_per_second as f32;
        let at = positions(&scene);
        let last = at.len() - 1;
        for (index, node) in scene.nodes.iter().enumerate() {
            let place = |frame: usize| at[frame][index];
            let (out, into) = (place(1) - place(0), place(last) - place(last - 1));
            let jump = out.distance(into) * rate;
            assert!(jump < 0.1, "{file}: {}: {jump}", node.name);
            assert!(place(0).distance(place(last)) < 1e-4, "{file}");
        }
    }
}

#[test]
fn a_loop_ends_as_it_begins() {
    for (file, in_place) in [
        (WALK, false),
        (WALK, true),
        ("motionbuilder_vicon_walk.bvh", true),
        ("rokoko_dance.bvh", false),
    ] {
        let mut scene = import(file);
        // The noise is removed first, because it hides the speed of a single frame.
        Smooth::new().apply(&mut scene, &StepInput::new()).unwrap();
        let report = Loop::new()
            .in_place(in_place)
            .apply(&mut scene, &StepInput::new())
            .unwrap();
        assert_eq!(scene.validate(), []);
        let at = positions(&scene);
        let last = at.len() - 1;
        assert_eq!(last, report.last - report.first);
        let seconds = last as f64 / scene.animations[0].ticks_per_second;
        assert!((0.59..4.01).contains(&seconds), "{file}: {seconds} s");
        assert!(report.contacts_agree, "{file}: {report:?}");
        // Positions are relative to the hips, along the directions of the body over the ground. So the distance and the
        // turn of a cycle do not count.
        let found = Humanoid::of(&scene);
        let joint = |bone: HumanoidBone| found.joint(bone).unwrap().index();
        let seen = |frame: usize| {
            let at = &at[frame];
            let left = (at[joint(HumanoidBone::LeftUpperLeg)] - at[joint(HumanoidBone::RightUpperLeg)])
                .reject_from(Vec3::Y)
                .normalize();
            let ahead = left.cross(Vec3::Y);
            let hips = at[joint(HumanoidBone::Hips)];
            at.iter()
                .map(|point| point - hips)
                .map(|way| Vec3::new(way.dot(left), way.y, way.dot(ahead)))
                .collect::<Vec<_>>()
        };
        let (start, end) = (seen(0), seen(last));
        // The velocities at both ends are one-sided and of the second order, so that an acceleration does not count as
        // a jump.
        let (out, into) = ([seen(1), seen(2)], [seen(last - 1), seen(last - 2)]);
        let fastest = (1..=last).flat_map(|frame| {
            let (a, b) = (seen(frame - 1), seen(frame));
            a.iter().zip(b).map(|(a, b)| a.distance(b)).collect::<Vec<_>>()
        });
        let fastest = fastest.fold(0.0, f32::max);
        for node in 0..start.len() {
            let name = &scene.nodes[node].name;
            assert!(
                start[node].distance(end[node]) < 1e-4,
                "{file}: {name} is {} off",
                start[node].distance(end[node])
            );
            let out = 2.0 * out[0][node] - 1.5 * start[node] - 0.5 * out[1][node];
            let into = 1.5 * end[node] - 2.0 * into[0][node] + 0.5 * into[1][node];
            assert!(out.distance(into) < 0.05 * fastest, "{file}: {name} {out} {into}");
        }
        if in_place {
            assert!(at[0][joint(HumanoidBone::Hips)].distance(at[last][joint(HumanoidBone::Hips)]) < 1e-4);
        }
    }
    let mut short = part(&import(WALK), 0, 30);
    let error = Loop::new().apply(&mut short, &StepInput::new()).unwrap_err();
    assert_eq!(
        error.diagnostic().message,
        "the motion of 0.250 s is too short for a loop of 0.6 s"
    );
    let by_hand = Loop::new().frames(Some([10, 40]));
    let error = by_hand.apply(&mut short, &StepInput::new()).unwrap_err();
    assert_eq!(
        error.diagnostic().message,
        "a loop from frame 10 to frame 40 is not possible: the motion has frames 0 to 30"
    );
}

#[test]
fn a_blend_without_weight_is_the_first_and_with_all_weight_the_second() {
    let walk = import(WALK);
    let first = part(&walk, 0, 300);
    let mut second = part(&walk, 120, 380);
    Mirror::new().apply(&mut second, &StepInput::new()).unwrap();
    for (weight, expected) in [(0.0, &first), (1.0, &second)] {
        let mut scene = first.clone();
        blend(&mut scene, &second, weight).unwrap();
        assert_same_motion(expected, &scene, 1e-5);
    }
    let mut scene = first.clone();
    let report = blend(&mut scene, &second, 0.5).unwrap();
    assert_eq!(report.frames, 281);
    assert_bones_keep_their_lengths(&part(&first, 0, 0), &part(&scene, 0, 0));
    assert_eq!(scene.validate(), []);
    // A motion blended with a slower copy of itself is the same motion, at a speed between the two speeds.
    let mut slow = first.clone();
    warp_time(&mut slow, &[(0.0, 0.0), (300.0 / 120.0, 600.0 / 120.0)]).unwrap();
    let mut scene = first.clone();
    blend(&mut scene, &slow, 0.5).unwrap();
    let (at, was_at) = (positions(&scene), positions(&first));
    for (frame, at) in at.iter().enumerate() {
        let was = &was_at[((frame as f32 / 1.5).round() as usize).min(300)];
        let off = at.iter().zip(was).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(off < 0.05, "{off} m in frame {frame}");
    }
}

#[test]
fn a_weight_may_change_over_time() {
    let walk = import(WALK);
    let first = part(&walk, 0, 300);
    let mut second = part(&walk, 0, 300);
    Mirror::new().apply(&mut second, &StepInput::new()).unwrap();
    // Up to 0.5 s only the first motion counts. Both motions are equally long and look alike, but their steps use
    // opposite feet.
    let curve = |points: &[(f64, f64)]| BlendWeight::Curve(points.to_vec());
    let mut scene = first.clone();
    blend(&mut scene, &second, curve(&[(0.5, 0.0), (1.5, 1.0)])).unwrap();
    assert_eq!(scene.validate(), []);
    assert_bones_keep_their_lengths(&first, &scene);
    let (old, new) = (positions(&first), positions(&scene));
    for frame in 0..=60 {
        let off = old[frame]
            .iter()
            .zip(&new[frame])
            .map(|(a, b)| a.distance(*b))
            .fold(0.0, f32::max);
        assert!(off < 1e-5, "{off} in frame {frame}");
    }
    // At the end only the second motion counts, wherever the steps have led.
    let (end, expected) = (positions(&scene), positions(&second));
    let (end, expected) = (end.last().unwrap(), expected.last().unwrap());
    for (place, expected_place) in end.iter().zip(expected) {
        let (from_hips, expected) = (place.distance(end[0]), expected_place.distance(expected[0]));
        assert!((from_hips - expected).abs() < 0.02, "{from_hips} {expected}");
        assert!((place.y - expected_place.y).abs() < 0.02, "{place} {expected_place}");
    }
    // A curve with one value equals a constant weight.
    let (mut flat, mut constant) = (first.clone(), first.clone());
    blend(&mut flat, &second, curve(&[(0.0, 0.25), (9.0, 0.25)])).unwrap();
    blend(&mut constant, &second, 0.25).unwrap();
    assert_same_motion(&flat, &constant, 1e-5);
    for (weight, message) in [
        (curve(&[]), "a curve of weights must have at least one point, got 0"),
        (
            curve(&[(0.0, 0.0), (1.0, 1.5)]),
            "weight must be from 0 to 1, got 1.5 at 1 s",
        ),
        (BlendWeight::from(f64::NAN), "weight must be from 0 to 1, got NaN"),
        (
            curve(&[(1.0, 0.0), (1.0, 1.0)]),
            "the times of a curve of weights must be finite, at least 0, and in increasing order, got [1.0, 1.0]",
        ),
    ] {
        let mut scene = first.clone();
        let error = blend(&mut scene, &second, weight).unwrap_err();
        assert_eq!(error.diagnostic().message, message);
        assert!(scene == first);
    }
}

/// A walk, blended with the same walk in another direction, gives this walk in a direction between the two directions.
/// The result is as fast as the walk, and has no jump. At 180 degrees, a mean of the positions would not move at all.
#[test]
fn walks_in_different_directions_are_mixed_as_each_figure_sees_them() {
    let first = part(&import(WALK), 0, 300);
    let was_at = positions(&first);
    let length = was_at[0][0].distance(was_at[300][0]);
    for by in [30.0, 90.0, 150.0, -170.0] {
        let mut second = first.clone();
        Turn::new().by(Some(by)).apply(&mut second, &StepInput::new()).unwrap();
        let curve = BlendWeight::Curve(vec![(0.5, 0.0), (2.0, 1.0)]);
        for (weight, straight) in [(BlendWeight::from(0.5), true), (curve, false)] {
            let mut scene = first.clone();
            blend(&mut scene, &second, weight).unwrap();
            let at = positions(&scene);
            let far = at[0][0].distance(at[300][0]);
            assert!(!straight || (far - length).abs() < 0.01, "{by}: {far} m, not {length}");
            for node in 0..scene.nodes.len() {
                let fastest = |at: &[Vec<glam::Vec3>]| {
                    let steps = at.windows(2).map(|pair| pair[0][node].distance(pair[1][node]));
                    steps.fold(0.0, f32::max)
                };
                let (now, before) = (fastest(&at), fastest(&was_at));
                assert!(
                    now < 1.15 * before + 1e-3,
                    "{by}: {}: {now} {before}",
                    scene.nodes[node].name
                );
            }
        }
    }
}

/// The warning about two motions that do not fit, as text; empty if they fit.
fn unfit(scene: &Scene) -> String {
    let warnings = scene.warnings.iter();
    let of_fit = warnings.filter(|warning| warning.code == mocap::Code::PosesApart);
    of_fit.map(ToString::to_string).collect()
}

#[test]
fn motions_that_do_not_fit_are_warned_of() {
    let walk = import(WALK);
    // The two parts of a cut clip fit.
    let mut whole = part(&walk, 0, 260);
    concat(&mut whole, &part(&walk, 260, 522)).unwrap();
    assert_eq!(unfit(&whole), "");
    let mut both = walk.clone();
    blend(&mut both, &walk, 0.5).unwrap();
    assert_eq!(unfit(&both), "");

    // One joint differs by 60 degrees, and nothing else differs.
    let mut bent = walk.clone();
    let mut channels = bent.animations[0].channels.iter_mut();
    let forearm = channels.find(|channel| channel.node_name == "LeftForeArm").unwrap();
    for rotation in &mut forearm.rotation_keys.values {
        *rotation *= Quat::from_rotation_y(60f32.to_radians());
    }
    let mut joined = part(&walk, 0, 260);
    concat(&mut joined, &part(&bent, 260, 522)).unwrap();
    let found = unfit(&joined);
    assert!(
        found.contains("LeftForeArm by 60.0 degrees at frame 260 (more than 45 degrees)"),
        "{found}"
    );
    assert!(!found.contains("cm"), "{found}");
    let mut mixed = walk.clone();
    blend(&mut mixed, &bent, 0.5).unwrap();
    assert!(unfit(&mixed).contains("degrees"), "{}", unfit(&mixed));
    // Parts that are not mixed need not fit.
    let mut first = walk.clone();
    blend(&mut first, &bent, 0.0).unwrap();
    assert_eq!(unfit(&first), "");

    // Without alignment, the second motion begins elsewhere: the walk covers 4 m in 4.3 s.
    let mut apart = part(&walk, 0, 520);
    let options = Concat::new().align(false);
    options
        .apply(&mut apart, &StepInput::new().other(&part(&walk, 0, 260)))
        .unwrap();
    assert!(
        unfit(&apart).contains(" cm at frame 520 (more than 30 cm)"),
        "{}",
        unfit(&apart)
    );

    // Only the speed differs: the second motion stands.
    let mut still = part(&walk, 260, 522);
    for channel in &mut still.animations[0].channels {
        let (position, rotation) = (channel.position_keys.values[0], channel.rotation_keys.values[0]);
        channel.position_keys.values.fill(position);
        channel.rotation_keys.values.fill(rotation);
    }
    let mut stopped = part(&walk, 0, 260);
    concat(&mut stopped, &still).unwrap();
    assert!(
        unfit(&stopped).contains(" m/s at frame 260 (more than 1 m/s)"),
        "{}",
        unfit(&stopped)
    );
    assert!(!unfit(&stopped).contains("degrees"), "{}", unfit(&stopped));
}

#[test]
fn a_layer_changes_its_part_alone() {
    let walk = import(WALK);
    let (mut scene, other) = (part(&walk, 0, 200), part(&walk, 150, 300));
    let layer = Layer::new().part(LayerPart::Arms);
    layer.apply(&mut scene, &StepInput::new().other(&other)).unwrap();
    let found = Humanoid::of(&walk);
    let joint = |bone: HumanoidBone| found.joint(bone).unwrap().index();
    let (old, new, donor) = (positions(&walk), positions(&scene), positions(&other));
    for frame in 0..=150 {
        for bone in [HumanoidBone::LeftFoot, HumanoidBone::Head, HumanoidBone::RightToes] {
            assert!(old[frame][joint(bone)].distance(new[frame][joint(bone)]) < 1e-6);
        }
        let reach = |at: &[Vec3]| at[joint(HumanoidBone::LeftHand)].distance(at[joint(HumanoidBone::LeftUpperArm)]);
        assert!((reach(&new[frame]) - reach(&donor[frame])).abs() < 1e-5);
    }
}

#[test]
fn keys_stay_and_what_lies_between_is_smooth() {
    let walk = import(WALK);
    for interpolation in [KeyInterpolation::Slerp, KeyInterpolation::Squad] {
        let mut all = walk.clone();
        InBetween::new()
            .every(1)
            .interpolation(interpolation)
            .apply(&mut all, &StepInput::new())
            .unwrap();
        assert_same_motion(&walk, &all, 1e-6);
        let mut scene = walk.clone();
        let options = InBetween::new().keys(vec![7]).every(20).interpolation(interpolation);
        assert_eq!(options.apply(&mut scene, &StepInput::new()).unwrap().keys.len(), 29);
        assert_bones_keep_their_lengths(&walk, &scene);
        let (old, new) = (positions(&walk), positions(&scene));
        for frame in [0, 7, 20, 200, 520, 522] {
            assert!(
                old[frame].iter().zip(&new[frame]).all(|(a, b)| a.distance(*b) < 1e-5),
                "{frame}"
            );
        }
    }
    // At a key, the speed jumps with slerp, and hardly with squad.
    let jump = |interpolation| {
        let mut scene = walk.clone();
        InBetween::new()
            .every(20)
            .interpolation(interpolation)
            .apply(&mut scene, &StepInput::new())
            .unwrap();
        let at = positions(&scene);
        let bend =
            |frame: usize, node: usize| (at[frame + 1][node] - 2.0 * at[frame][node] + at[frame - 1][node]).length();
        let bends = (20..500)
            .step_by(20)
            .flat_map(|frame| (0..at[0].len()).map(move |node| bend(frame, node)));
        bends.fold(0.0, f32::max)
    };
    assert!(jump(KeyInterpolation::Squad) < 0.3 * jump(KeyInterpolation::Slerp));
}

/// The second motion is played at the frame rate of the first. Files may state any rates, so an hour could have a
/// million frames per second.
#[test]
fn a_second_motion_that_would_have_too_many_frames_is_refused() {
    let mut fast = import(WALK);
    fast.trim(0.0, 10.0);
    let mut slow = fast.clone();
    fast.animations[0].ticks_per_second = 1e6;
    slow.animations[0].ticks_per_second = 1e-3;
    let refusal = concat(&mut fast.clone(), &slow).unwrap_err();
    assert_eq!(refusal.code(), Code::LimitExceeded);
    let refusal = blend(&mut fast.clone(), &slow, BlendWeight::Constant(1.0)).unwrap_err();
    assert_eq!(refusal.code(), Code::LimitExceeded);
    assert_eq!(concat(&mut slow, &fast).unwrap().frames, 11);
}
