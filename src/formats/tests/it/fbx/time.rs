//! Tests the times of keys in FBX.

use mocap::Code;
use mocap_formats::internals::fbx::{SECOND, end, key_times};

#[test]
fn key_times_are_never_late_and_never_equal() {
    // A jump at 0.1 s in 32 bits: its two keys are neighbouring numbers.
    let jump = 0.1_f32;
    let ticks = [0.0, 1e-40, jump.next_down().into(), jump.into()];
    let times: Vec<i64> = key_times(&ticks, 1.0).collect();
    assert_eq!(times[..2], [0, 1]);
    assert!(times.is_sorted_by(|a, b| a < b), "{times:?}");
    assert!(times[3] as f64 <= f64::from(jump) * SECOND);
    // 1/30 s is a whole number of FBX's units.
    assert_eq!(
        key_times(&[1.0, 7.0], 30.0).collect::<Vec<_>>(),
        [1_539_538_600, 10_776_770_200]
    );
}

#[test]
fn a_clip_that_fbx_cannot_time_is_refused() {
    assert_eq!(end(30.0, 30.0).unwrap(), SECOND as i64);
    // A million frames at a thousandth of a frame per second last 30 years.
    assert_eq!(end(1e6, 1e-3).unwrap_err().code(), Code::LimitExceeded);
}
