//! Tests convex hulls.

use mocap::glam::DVec2;
use mocap_scene::math::hull::{area, convex_hull};

#[test]
fn a_square_with_points_inside_and_on_its_edge_has_four_corners() {
    let corners = [(0.0, 0.0), (2.0, 0.0), (0.0, 3.0), (2.0, 3.0), (0.5, 0.5), (0.5, 0.0)];
    let mut points: Vec<DVec2> = corners.into_iter().map(DVec2::from).collect();
    let hull = convex_hull(&mut points);
    assert_eq!(hull.len(), 4);
    assert!((area(&hull) - 6.0).abs() < 1e-12);
    assert_eq!(area(&convex_hull(&mut points[..1].to_vec())), 0.0);
}
