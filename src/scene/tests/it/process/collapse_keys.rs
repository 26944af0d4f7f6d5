//! Tests which tracks are reduced to one key.

use mocap::Scene;
use mocap::glam::{Quat, Vec3};
use mocap::process::KeyTolerance;
use mocap::scene::{Animation, Channel, Keys};

fn collapsed(channel: Channel, tolerance: KeyTolerance) -> Channel {
    let mut scene = Scene {
        animations: vec![Animation {
            channels: vec![channel],
            ..Animation::default()
        }],
        ..Scene::default()
    };
    scene.collapse_keys(tolerance);
    scene.animations.remove(0).channels.remove(0)
}

fn positions(xs: &[f32], tolerance: f32) -> usize {
    let values = xs.iter().map(|&x| Vec3::new(x, 0.0, 0.0)).collect();
    let channel = Channel {
        position_keys: Keys::every_tick(values),
        ..Channel::default()
    };
    let tolerance = KeyTolerance::default().position(tolerance);
    collapsed(channel, tolerance).position_keys.len()
}

fn rotations(angles: &[f32], tolerance: f32) -> usize {
    let values = angles.iter().map(|&angle| Quat::from_rotation_y(angle)).collect();
    let channel = Channel {
        rotation_keys: Keys::every_tick(values),
        ..Channel::default()
    };
    let tolerance = KeyTolerance::default().rotation(tolerance);
    collapsed(channel, tolerance).rotation_keys.len()
}

#[test]
fn zero_tolerance_asks_for_equal_numbers() {
    assert_eq!(positions(&[1.0, 1.0, 1.0], 0.0), 1);
    assert_eq!(positions(&[0.0, -0.0], 0.0), 1);
    assert_eq!(positions(&[1.0, 1.0, 1.0f32.next_up()], 0.0), 3);
    assert_eq!(positions(&[0.0, f32::from_bits(1)], 0.0), 2);
    assert_eq!(positions(&[f32::NAN, f32::NAN], 0.0), 2);
    assert_eq!(rotations(&[0.3, 0.3], 0.0), 1);
    assert_eq!(rotations(&[0.3, 0.300_001], 0.0), 2);
}

#[test]
fn a_tolerance_is_a_distance_in_the_files_unit() {
    assert_eq!(positions(&[5.0, 5.25, 4.75], 0.25), 1);
    assert_eq!(positions(&[5.0, 5.25, 4.75], 0.249), 3);
}

#[test]
fn a_tolerance_is_an_angle_in_radians() {
    assert_eq!(rotations(&[1.0, 1.001], 0.001_01), 1);
    assert_eq!(rotations(&[1.0, 1.001], 0.000_99), 2);
    // Equal angles, whose quaternions have opposite signs.
    assert_eq!(rotations(&[1.0, 1.001 + std::f32::consts::TAU], 0.001_01), 1);
}

#[test]
fn a_track_that_drifts_is_kept() {
    let drift: Vec<f32> = (0..100).map(|i| i as f32 * 0.01).collect();
    assert_eq!(positions(&drift, 0.02), 100);
}

#[test]
fn ticks_of_a_collapsed_track_are_gone_and_others_stay() {
    let still = Keys {
        values: vec![Vec3::ONE; 2],
        ticks: Some(vec![3.0, 7.0]),
    };
    let moving = Keys {
        values: vec![Quat::IDENTITY, Quat::from_rotation_x(1.0)],
        ticks: Some(vec![3.0, 7.0]),
    };
    let channel = Channel {
        position_keys: still,
        rotation_keys: moving.clone(),
        ..Channel::default()
    };
    let after = collapsed(channel, KeyTolerance::default());
    assert_eq!(after.position_keys, Keys::constant(Vec3::ONE));
    assert_eq!(after.rotation_keys, moving);
    assert!(after.scaling_keys.is_empty());
}
