//! Extremes of an angle.

use mocap_solve::internals::turns;

#[test]
fn turns_of_a_sine_are_its_extremes_and_noise_has_none() {
    let sine: Vec<f64> = (0..400).map(|frame| (f64::from(frame) * 0.05).sin()).collect();
    let (highest, lowest) = turns(&sine, 0.5);
    // Its period is 125.66 frames; before its first maximum it rises by half of its range.
    assert_eq!(highest, [31, 157, 283]);
    assert_eq!(lowest, [94, 220, 346]);
    assert_eq!(turns(&sine, 5.0), (Vec::new(), Vec::new()));
    assert_eq!(turns(&[], 0.5), (Vec::new(), Vec::new()));
}
