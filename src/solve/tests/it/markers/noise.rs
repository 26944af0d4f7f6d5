//! Tests of the noise of a take.

use mocap::glam::{DVec3, Vec3};
use mocap::{Pose, Scene};
use mocap_solve::internals::{Track, noise};

use super::landmarks::GUIDES;
use super::planted::{joint, knee, legs, planted, walk};
use super::sets::markers;

/// Almost normal numbers with a standard deviation of 1: sums of 12 uniform numbers, less their mean.
fn normal(state: &mut u32) -> f64 {
    let mut even = || {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(*state) / f64::from(u32::MAX)
    };
    (0..12).map(|_| even()).sum::<f64>() - 6.0
}

#[test]
fn noise_on_a_swinging_marker_is_that_which_was_put_there() {
    const NOISE: f64 = 0.001;
    let mut state = 1;
    let mut position = |frame: usize| {
        // A foot that swings by 30 cm once per second, at 120 frames per second.
        let swing = 0.3 * (std::f64::consts::TAU * frame as f64 / 120.0).sin();
        let noise = DVec3::new(normal(&mut state), normal(&mut state), normal(&mut state)) * NOISE;
        DVec3::new(swing, 0.1, 0.0) + noise
    };
    let tracks: [Track; 1] = [(0..2000).map(|frame| Some(position(frame))).collect()];
    let found = noise(&tracks, 120.0);
    assert!((found / NOISE - 1.0).abs() < 0.1, "{found}");
    assert_eq!(noise(&tracks, 30.0), 0.0);
}

/// The skeleton of the walk from markers with noise of 1 mm. One of a hundred positions is a reflection.
fn spoiled() -> Scene {
    let mut walk = planted(&walk(), 1, &markers(GUIDES[0].1));
    let mut state = 1;
    for (frame, row) in walk.frames.iter_mut().enumerate() {
        for (marker, at) in row.iter_mut().enumerate() {
            let mut noise = || Vec3::from_array([(); 3].map(|()| normal(&mut state) as f32));
            *at += noise();
            if (frame * 37 + marker * 11) % 100 == 0 {
                *at += noise() * 150.0;
            }
        }
    }
    walk.solved()
}

#[test]
fn noise_and_reflections_hardly_move_knees_and_elbows() {
    let (solved, truth) = (spoiled(), walk());
    let frames = solved.animations[0].frame_count();
    for side in ["Left", "Right"] {
        let off = knee(&legs(&solved, &truth, 1, side));
        assert!(off < 0.5, "{side} knee: {off} degrees RMS");
        let at = |scene: &Scene, frame: usize, names: [&str; 3]| {
            let pose = Pose::at_tick(scene, 0, frame as f64).unwrap();
            names.map(|name| joint(scene, &pose, name))
        };
        let bones = ["UpperArm", "LowerArm", "Hand"].map(|bone| format!("{}{bone}", side.to_lowercase()));
        let own = |frame: usize| at(&solved, frame, bones.each_ref().map(String::as_str));
        let theirs = ["Arm", "ForeArm", "Hand"].map(|name| format!("{side}{name}"));
        let other = |frame: usize| at(&truth, frame, theirs.each_ref().map(String::as_str));
        let bend = |[a, b, c]: [(Vec3, _); 3]| (b.0 - a.0).angle_between(c.0 - b.0).to_degrees();
        let squares = (0..frames).map(|frame| (bend(own(frame)) - bend(other(1 + frame))).powi(2));
        let off = (squares.sum::<f32>() / frames as f32).sqrt();
        assert!(off < 1.5, "{side} elbow: {off} degrees RMS");
        let turn = |frame: usize| own(frame)[0].1.angle_between(own(frame - 1)[0].1).to_degrees();
        let most = (1..frames).map(turn).fold(0.0, f32::max);
        // The true arm turns by 2.4 degrees at most.
        assert!(most < 8.0, "{side} upper arm: {most} degrees in a frame");
    }
}
