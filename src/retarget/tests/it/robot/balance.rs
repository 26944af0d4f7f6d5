//! Tests the shift of a mass that moves the centre of pressure.

use mocap::glam::DVec2;
use mocap_retarget::internals::{GRAVITY, shifts};

/// By the equation that the shift solves: the shift changes the centre of pressure by the missing distance.
#[test]
fn a_mass_that_is_shifted_has_its_pressure_within() {
    let (height, fps) = (0.9, 120.0);
    let bump = |frame: usize| 0.1 * (-((frame as f64 - 300.0) / 40.0).powi(2)).exp();
    let outside: Vec<DVec2> = (0..600)
        .map(|frame| DVec2::new(bump(frame), -0.5 * bump(frame)))
        .collect();
    let found = shifts(&outside, height, fps).unwrap();
    for frame in 1..599 {
        let bent = (found[frame - 1] - 2.0 * found[frame] + found[frame + 1]) * fps * fps;
        let moved = found[frame] - height / GRAVITY * bent;
        assert!(
            (moved + outside[frame]).length() < 1e-3,
            "{frame} {moved} {}",
            outside[frame]
        );
    }
    assert_eq!(shifts(&[DVec2::ZERO; 50], height, fps), None);
}
