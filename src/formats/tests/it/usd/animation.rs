//! Tests half-precision numbers, as USD stores them.

use mocap_formats::internals::usd::{STEP, half, half_of_scale};

#[test]
fn halves_are_those_of_numpy() {
    // The expected values are numpy.float16(x), as float32.
    for (value, expected) in [
        (1.0, 1.0),
        (0.01, 0.010_002_136),
        (1.1, 1.099_609_4),
        (-100.3, -100.3125),
        (1e-5, 1.001_358e-5),
        (2049.0, 2048.0),
    ] {
        assert_eq!(half(value), expected, "{value}");
    }
}

#[test]
fn a_scale_that_is_not_zero_keeps_its_sign() {
    assert_eq!(half_of_scale(-1e-9), -STEP);
    assert_eq!(half_of_scale(1e-30), STEP);
    assert_eq!(half_of_scale(0.0), 0.0);
    assert_eq!(half_of_scale(0.01), half(0.01));
}
