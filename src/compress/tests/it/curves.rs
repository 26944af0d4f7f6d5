//! Curves of Euler angles.

use mocap::glam::DVec3;
use mocap_compress::internals::curves::{reduce, union};

/// A knee, which bends about one axis alone, has keys on that axis alone.
#[test]
fn an_axis_that_stays_has_one_key() {
    let values: Vec<DVec3> = (0..50)
        .map(|frame| DVec3::new(2.0, f64::from(frame * frame), -1.0))
        .collect();
    let ticks: Vec<f64> = (0..50).map(f64::from).collect();
    let error = |frame: usize, value: DVec3| values[frame].distance(value) as f32;
    let (curves, lossy) = reduce(&values, DVec3::new(2.0, 0.0, 0.0), &ticks, 10.0, error);
    assert_eq!(curves[0].values, [2.0]);
    // Half a unit of the parabola's curvature times the square of half the distance of two keys is at most 10.
    assert_eq!(curves[1].key_frames[..4], [0, 6, 12, 18]);
    assert_eq!(union(&curves), *curves[1].key_frames);
    for (frame, value) in lossy.iter().enumerate() {
        assert!(value.distance(values[frame]) <= 10.0, "{frame}: {value}");
    }
}
