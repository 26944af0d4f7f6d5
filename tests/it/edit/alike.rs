//! Two motions that meet where they are most alike, and motions of two skeletons.

use glam::Vec3;
use mocap::Scene;
use mocap::edit::{Blend, Concat, EditStep, Step, StepInput, StepReport};
use mocap::figure::{Humanoid, HumanoidBone};
use mocap::retargeting::apply_steps;

use super::*;

const WALK: &str = "cmu_12_01_walk.bvh";

fn file(name: &str) -> String {
    format!("{}/fixtures/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn part(scene: &Scene, first: usize, last: usize) -> Scene {
    let mut scene = scene.clone();
    scene.trim(first as f64, last as f64);
    scene
}

/// The largest distance of a joint of one motion from its position in another, frame by frame.
fn farthest(a: &[Vec<Vec3>], b: &[Vec<Vec3>]) -> f32 {
    assert_eq!(a.len(), b.len());
    let joints = a.iter().flatten().zip(b.iter().flatten());
    joints.map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

/// Two parts of one walk that overlap: where the first ends and the second begins they are alike in no pose, but in the
/// part that both have they are the same, so that the whole walk comes back.
#[test]
fn parts_that_overlap_become_the_whole() {
    let walk = import(WALK);
    let (mut first, second) = (part(&walk, 0, 300), part(&walk, 250, 522));
    let input = StepInput::new();
    let report = Concat::new()
        .within(0.5)
        .apply(&mut first, &input.other(&second))
        .unwrap();
    assert_eq!(report.frames, 523);
    assert!(report.apart.unwrap() < 1e-4, "{report:?}");
    let left_out: f64 = report.left_out.iter().sum();
    assert!(
        (left_out * walk.animations[0].ticks_per_second - 50.0).abs() < 1e-6,
        "{report:?}"
    );
    assert!(farthest(&positions(&walk), &positions(&first)) < 1e-4);
    assert!(first.warnings.is_empty(), "{:?}", first.warnings);

    // Without a search the figure goes back by 50 frames at the seam.
    let mut plain = part(&walk, 0, 300);
    let report = Concat::new().apply(&mut plain, &input.other(&second)).unwrap();
    assert_eq!(
        (report.frames, report.left_out, report.apart),
        (300 + 273, [0.0; 2], None)
    );
}

#[test]
fn a_mix_begins_and_ends_where_both_are_alike() {
    let walk = import(WALK);
    let (mut first, second) = (part(&walk, 0, 400), part(&walk, 24, 424));
    let input = StepInput::new();
    let report = Blend::new()
        .within(0.5)
        .apply(&mut first, &input.other(&second))
        .unwrap();
    let seconds = 24.0 / walk.animations[0].ticks_per_second;
    assert_eq!(report.left_out_before, [seconds, 0.0]);
    assert_eq!(report.left_out_after, [0.0, seconds]);
    // Of both the same part is left, so that the mix is that part.
    assert!(farthest(&positions(&part(&walk, 24, 400)), &positions(&first)) < 1e-3);
}

#[test]
fn a_time_of_a_search_is_checked_and_may_be_longer_than_the_motion() {
    let walk = import(WALK);
    for within in [-0.1, 10.5, f64::NAN, f64::INFINITY] {
        let (mut scene, input) = (part(&walk, 0, 60), StepInput::new());
        let concat = Concat::new().within(within).apply(&mut scene, &input.other(&walk));
        let blend = Blend::new().within(within).apply(&mut scene, &input.other(&walk));
        for error in [concat.unwrap_err(), blend.unwrap_err()] {
            let expected = format!("within must be from 0 to 10 seconds, got {within}");
            assert_eq!(error.diagnostic().message, expected);
        }
    }
    for frames in [0, 1, 2, 5, 60] {
        let short = part(&walk, 0, frames);
        let (mut joined, mut mixed) = (short.clone(), short.clone());
        let input = StepInput::new();
        let report = Concat::new()
            .within(10.0)
            .apply(&mut joined, &input.other(&short))
            .unwrap();
        assert!(report.frames > 0 && report.frames <= 2 * frames + 1, "{report:?}");
        let report = Blend::new()
            .within(10.0)
            .apply(&mut mixed, &input.other(&short))
            .unwrap();
        assert_eq!(report.frames, frames + 1);
    }
}

#[test]
fn a_motion_of_another_skeleton_is_retargeted_and_said_to_be() {
    let walk = import(WALK);
    let run = mocap::import(file("skeletons/accad_run_turn.bvh")).unwrap();
    let steps: Vec<EditStep> = vec!["concat:within=0.5".parse().unwrap()];
    let mut joined = walk.clone();
    let reports = apply_steps(&mut joined, &steps, &[&run], None).unwrap();
    let text = reports[0].to_string();
    assert!(
        text.starts_with("concat with accad_run_turn.bvh, retargeted from another skeleton ("),
        "{text}"
    );
    let StepReport::Concat(report) = &reports[0].changed else {
        unreachable!()
    };
    assert_eq!(joined.nodes, walk.nodes);
    assert_bones_keep_their_lengths(&walk, &joined);
    // The last pose is that of the run: its thighs and arms point where those of the run do, but for its heading.
    let (own, theirs) = (Humanoid::of(&walk), Humanoid::of(&run));
    let (ours, source) = (positions(&joined), positions(&run));
    let (ours, source) = (&ours[report.frames - 1], source.last().unwrap());
    for (from, to) in [
        (HumanoidBone::LeftUpperLeg, HumanoidBone::LeftLowerLeg),
        (HumanoidBone::RightUpperArm, HumanoidBone::RightLowerArm),
    ] {
        let direction = |at: &[Vec3], found: &Humanoid| {
            let [from, to] = [from, to].map(|bone| at[found.joint(bone).unwrap().index()]);
            (to - from).normalize()
        };
        let (a, b) = (direction(ours, &own), direction(source, &theirs));
        assert!((a.y - b.y).abs() < 0.1, "{from:?}: {a} {b}");
    }

    // What is no humanoid is refused, with the reason.
    let chain = mocap::import(file("real/blender_two_joints.bvh")).unwrap();
    let error = apply_steps(&mut walk.clone(), &steps, &[&chain], None).unwrap_err();
    let expected = "the two motions have different skeletons, and the second cannot be retargeted: ";
    assert!(error.diagnostic().message.starts_with(expected), "{error}");
}
