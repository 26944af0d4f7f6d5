//! Tests the compression of curves of Euler angles.

use mocap::glam::DVec3;
use mocap_compress::internals::curves::reduce;

/// A knee bends about one axis only, so only this axis has keys.
#[test]
fn an_axis_that_stays_has_one_key() {
    let values: Vec<DVec3> = (0..50)
        .map(|frame| DVec3::new(2.0, f64::from(frame * frame), -1.0))
        .collect();
    let ticks: Vec<f64> = (0..50).map(f64::from).collect();
    let is_within = |frame: usize, value: DVec3| values[frame].distance(value) <= 10.0;
    let curves = reduce(&values, DVec3::new(2.0, 0.0, 0.0), &ticks, is_within, |_, _| true);
    assert_eq!(curves[0].values, [2.0]);
    // The error of a line is the curvature times half of the squared half distance of its keys. Here it is at most 10.
    assert_eq!(curves[1].key_frames[..4], [0, 6, 12, 18]);
}

/// Three.js holds the last value of an axis at times at which only other axes have keys.
#[test]
fn axes_that_move_have_their_keys_at_the_same_frames() {
    let values: Vec<DVec3> = (0..50)
        .map(|frame| DVec3::new(f64::from(frame * frame), 5.0, f64::from(frame * (49 - frame))))
        .collect();
    let ticks: Vec<f64> = (0..50).map(f64::from).collect();
    let is_within = |frame: usize, value: DVec3| values[frame].distance(value) <= 10.0;
    let curves = reduce(&values, DVec3::Y * 5.0, &ticks, is_within, |_, _| true);
    assert_eq!(curves[0].key_frames, curves[2].key_frames);
    assert_eq!(curves[1].values, [5.0]);
    assert!(curves[0].values.len() < 20, "{:?}", curves[0].key_frames);
    for pair in curves[0].key_frames.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|frame| frame as usize);
        for frame in from..to {
            let line = values[from].lerp(values[to], (frame - from) as f64 / (to - from) as f64);
            assert!(is_within(frame, line), "{frame}");
        }
    }
}
