//! Noise at several rates: correlated, interpolated, and of the root alone.

use mocap::Pose;
use mocap::edit::{Clean, CleanPart, Resample, Step, StepInput};
use mocap::glam::{Quat, Vec3};
use mocap::scene::Scene;

use super::{Dice, add_noise, distance, only, outcome};
use mocap::edit::report::CleanOutcome;

fn at_rate(scene: &Scene, rate: f64) -> Scene {
    let mut scene = scene.clone();
    Resample::new().rate(rate).apply(&mut scene, &StepInput::new()).unwrap();
    scene
}

fn walk_at(rate: f64) -> Scene {
    let mut scene = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    scene.trim(20.0, 500.0);
    at_rate(&scene, rate)
}

/// An estimate at 30 frames per second has no noise between its own frames, whatever the rate of its file.
#[test]
fn noise_is_taken_out_of_an_interpolated_take() {
    let truth = walk_at(30.0);
    let mut noisy = truth.clone();
    add_noise(&mut noisy, 7);
    let off = distance(&truth, &noisy);
    for rate in [30.0, 60.0, 120.0] {
        let mut scene = at_rate(&noisy, rate);
        let report = only(CleanPart::Noise, &mut scene);
        assert!(report.after.jitter < 0.1 * report.before.jitter, "{rate}: {report}");
        let left = distance(&truth, &at_rate(&scene, 30.0));
        assert!(left < 0.8 * off, "{rate}: {left} of {off}, {report}");
    }
}

/// Ornstein-Uhlenbeck noise over 120 ms, as estimators have, shows a third of its size from frame to frame.
#[test]
fn correlated_noise_is_taken_out_at_every_rate() {
    for rate in [24.0, 30.0, 60.0, 120.0] {
        let mut scene = walk_at(rate);
        let keep = (-1.0 / (0.12 * rate as f32)).exp();
        let mut dice = Dice(5);
        for channel in &mut scene.animations[0].channels {
            let mut noise = dice.normals();
            for rotation in &mut channel.rotation_keys.values {
                noise = keep * noise + (1.0 - keep * keep).sqrt() * dice.normals();
                *rotation *= Quat::from_scaled_axis(noise * (2f32 / 3f32.sqrt()).to_radians());
            }
        }
        let report = only(CleanPart::Noise, &mut scene);
        assert!(report.after.jitter < 0.25 * report.before.jitter, "{rate}: {report}");
        assert!(
            report.after.peak_speed > 0.9 * report.before.peak_speed,
            "{rate}: {report}"
        );
    }
}

#[test]
fn no_frame_is_put_into_an_interpolated_take() {
    let mut noisy = walk_at(30.0);
    add_noise(&mut noisy, 9);
    for rate in [60.0, 120.0] {
        let mut scene = at_rate(&noisy, rate);
        let report = only(CleanPart::Time, &mut scene);
        assert_eq!(outcome(&report, CleanPart::Time), CleanOutcome::Nothing, "{report}");
    }
}

/// A root that is displaced by 43 cm for one frame is moved back. The units of the file are 5.6 cm.
#[test]
fn a_root_that_is_elsewhere_for_a_frame_comes_back() {
    let truth = walk_at(60.0);
    let mut scene = truth.clone();
    let root = &mut scene.animations[0].channels[0].position_keys.values;
    for frame in [30, 90, 91, 150] {
        root[frame] += Vec3::new(5.0, 5.0, -2.8);
    }
    let report = Clean::new().floor(false).apply(&mut scene, &StepInput::new()).unwrap();
    let position = |scene: &Scene, frame: usize| Pose::at_tick(scene, 0, frame as f64).unwrap().node_to_world[0].w_axis;
    for frame in 0..scene.animations[0].frame_count() {
        let off = (position(&scene, frame) - position(&truth, frame)).length();
        assert!(off < 0.2, "frame {frame}: {off}, {report}");
    }
}
