//! Tests of joint positions of robots as text.

use mocap_job::internals::rounded_within;

#[test]
fn rounding_stays_within_the_limits() {
    for (value, lower, upper) in [
        (0.087_266_46, -0.1, 0.087_266_46),
        (-0.087_266_56, -0.087_266_56, 1.0),
        (1.0, -1.0, 1.0),
        (0.123_456_49, -1.0, 1.0),
    ] {
        let kept = rounded_within(value, lower, upper);
        assert!((lower..=upper).contains(&kept), "{value} {kept}");
        assert!((kept - value).abs() <= 1.01e-6, "{value} {kept}");
    }
}
