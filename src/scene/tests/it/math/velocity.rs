//! Tests velocities by central differences.

use mocap_scene::math::velocity::velocities;

#[test]
fn inside_over_both_neighbours_at_the_ends_over_one() {
    // The central difference of t^2 is exactly 2 t. At the ends, the difference is 1 and 5 per frame.
    let squares = [0.0, 1.0, 4.0, 9.0];
    assert_eq!(velocities(&squares, 1, 10.0), [10.0, 20.0, 40.0, 50.0]);
    assert_eq!(velocities(&[1.0, 2.0], 2, 10.0), [0.0, 0.0]);
    assert_eq!(velocities(&[], 3, 10.0), [0.0; 0]);
    assert_eq!(velocities(&[], 0, 10.0), [0.0; 0]);
}
