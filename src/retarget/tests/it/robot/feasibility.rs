//! The distance of a point from a hull.

use mocap::glam::DVec2;
use mocap_retarget::internals::outside;

#[test]
fn a_point_is_outside_a_hull_by_its_distance() {
    let square = || -> Vec<DVec2> {
        let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (0.5, 0.5), (0.5, 0.0)];
        corners.into_iter().map(DVec2::from).collect()
    };
    assert_eq!(outside(square(), DVec2::new(0.2, 0.9)), DVec2::ZERO);
    let is = |points: Vec<DVec2>, at: [f64; 2], by: [f64; 2]| {
        let found = outside(points, DVec2::from(at));
        assert!(found.distance(DVec2::from(by)) < 1e-12, "{found}");
    };
    is(square(), [1.3, 0.5], [0.3, 0.0]);
    is(square(), [1.3, 1.4], [0.3, 0.4]);
    // A line and a point.
    is(square()[..2].to_vec(), [0.5, 0.25], [0.0, 0.25]);
    is(square()[..1].to_vec(), [0.0, 2.0], [0.0, 2.0]);
}
