//! Tests of joining two motions where they are most alike.

use glam::Vec3;
use mocap::Scene;
use mocap::edit::{Blend, Concat, Step, StepInput};

use super::*;

const WALK: &str = "cmu_12_01_walk.bvh";

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

/// Joins two parts of one walk that overlap. The end of the first part and the beginning of the second are not alike.
/// But both parts share frames, so the whole walk is restored.
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

    // Without a search, the figure jumps back by 50 frames at the seam.
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
    // The same part of both motions remains, so the mix equals this part.
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
