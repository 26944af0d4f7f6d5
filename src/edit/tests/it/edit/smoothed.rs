//! Tests of the amplitude that the filters of `smooth` leave of an oscillation.

use mocap::edit::{Despike, FootLock, Smooth, SmoothFilter, Step, StepInput};
use mocap::glam::Quat;
use mocap::scene::{Animation, Channel, Keys, Node, NodeId};
use mocap::{Code, Scene};

/// The fraction of an oscillation of `frequency` that the filter leaves, computed from its weights.
fn response(filter: SmoothFilter, frequency: f64) -> f64 {
    let kernel = filter.kernel(6.0, 240.0, usize::MAX);
    let phase = |frame: usize| (std::f64::consts::TAU * frequency * frame as f64 / 240.0).cos();
    let terms = kernel.iter().enumerate().skip(1);
    f64::from(kernel[0])
        + 2.0
            * terms
                .map(|(frame, weight)| f64::from(*weight) * phase(frame))
                .sum::<f64>()
}

#[test]
fn the_filters_have_the_responses_that_define_them() {
    for (frequency, butterworth) in [
        (0.0, 1.0),
        (1.0, 1.0 / (1.0 + 1.0 / 1296.0)),
        (6.0, 0.5),
        (18.0, 1.0 / 82.0),
    ] {
        assert!(
            (response(SmoothFilter::Butterworth, frequency) - butterworth).abs() < 4e-3,
            "{frequency}"
        );
    }
    for (frequency, gaussian) in [(0.0, 1.0), (6.0, 0.5), (12.0, 0.0625), (24.0, 0.0)] {
        assert!(
            (response(SmoothFilter::Gaussian, frequency) - gaussian).abs() < 1e-3,
            "{frequency}"
        );
    }
}

/// A node that rotates back and forth from frame to frame.
fn trembling(rate: f64, frames: usize) -> Scene {
    let mut scene = Scene::default();
    scene.nodes.push(Node::default());
    let turn = |frame: usize| Quat::from_rotation_x(frame as f32 % 2.0);
    let channel = Channel {
        node: Some(NodeId::new(0)),
        rotation_keys: Keys::every_tick((0..frames).map(turn).collect()),
        ..Channel::default()
    };
    scene.animations.push(Animation {
        ticks_per_second: rate,
        duration: (frames - 1) as f64,
        channels: vec![channel],
        ..Animation::default()
    });
    scene
}

/// The rate in a file once led to two thousand million weights, each used in every frame.
#[test]
fn averages_of_too_many_frames_are_refused() {
    let slow = Smooth::new().cut_off(1e-3);
    let smoothed = |rate: f64, frames: usize| slow.apply(&mut trembling(rate, frames), &StepInput::new());
    assert!(smoothed(1e6, 20).is_ok());
    let refusal = smoothed(1e6, 100_000).unwrap_err();
    assert_eq!(refusal.code(), Code::LimitExceeded);
    let expected = refusal.diagnostic().expected.as_deref();
    assert_eq!(expected, Some("at most 21474 frames on either side"));
    let longest = Despike::new().longest(50_000);
    let refusal = longest
        .apply(&mut trembling(30.0, 200_000), &StepInput::new())
        .unwrap_err();
    assert_eq!(refusal.code(), Code::LimitExceeded);
}

/// A step refuses to average too many frames of a walk at an extreme rate, but accepts a short walk.
#[test]
fn a_foot_lock_of_too_many_frames_at_once_is_refused() {
    let walk = |seconds: f64, rate: f64| {
        let mut scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
        scene.trim(120.0, 120.0 + (120.0 * seconds).ceil());
        scene.resample(rate, &mocap::Limits::default()).unwrap();
        FootLock::new().apply(&mut scene, &StepInput::new())
    };
    assert!(walk(0.1, 1e4).is_ok());
    assert_eq!(walk(0.03, 1e6).unwrap_err().code(), Code::LimitExceeded);
}
