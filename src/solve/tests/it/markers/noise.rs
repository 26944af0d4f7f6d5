//! Tests of the noise of a take.

use mocap::glam::DVec3;
use mocap_solve::internals::{Track, noise};

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
