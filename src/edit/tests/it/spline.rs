//! Tests of the spline of a path.

use mocap::glam::DVec2;
use mocap_edit::internals::Spline;

#[test]
fn it_goes_through_its_points_smoothly_and_straight_on() {
    let times = [0.5, 1.0, 3.0, 3.5];
    let points = [(0.0, 1.0), (2.0, 1.0), (-1.0, 4.0), (0.0, 0.0)].map(DVec2::from);
    let spline = Spline::new(&times, &points);
    for (time, point) in times.into_iter().zip(points) {
        assert!(spline.at(time).abs_diff_eq(point, 1e-12));
    }
    let step = 1e-5;
    for time in [0.2, 0.5, 0.7, 1.0, 2.2, 3.0, 3.4, 3.5, 4.0] {
        let chord = (spline.at(time + step) - spline.at(time - step)) / (2.0 * step);
        assert!(
            chord.abs_diff_eq(spline.speed(time), 1e-3),
            "{time}: {chord} {}",
            spline.speed(time)
        );
        let bend = (spline.speed(time + step) - spline.speed(time - step)) / step;
        // The acceleration is continuous, so it is bounded everywhere.
        assert!(bend.length() < 200.0, "{time}: {bend}");
    }
    assert!(spline.at(5.5).abs_diff_eq(points[3] + 2.0 * spline.speed(3.5), 1e-9));
    let line = Spline::new(&[0.0, 2.0], &[DVec2::ZERO, DVec2::X]);
    assert!(line.at(1.0).abs_diff_eq(DVec2::X * 0.5, 1e-12) && line.at(4.0).abs_diff_eq(DVec2::X * 2.0, 1e-12));
    assert_eq!(Spline::new(&[1.0], &[DVec2::Y]).at(7.0), DVec2::Y);
}
