//! Tests which of the two rotation vectors of a rotation continues a motion.

use std::f32::consts::{PI, TAU};

use mocap::glam::Vec3;
use mocap_corpus::internals::nearest_to;
use mocap_scene::math::quaternion::exp;

/// The shorter rotation vector of a joint that turns past 180 degrees flips to the opposite direction.
#[test]
fn past_half_a_turn_the_longer_vector_goes_on() {
    let axis = Vec3::new(0.6, 0.0, -0.8);
    let shorter = axis * (PI + 0.1 - TAU);
    let found = nearest_to(axis * (PI - 0.1), shorter);
    assert!(found.distance(axis * (PI + 0.1)) < 1e-5, "{found}");
    let difference = exp(found) * exp(shorter).inverse();
    assert!(difference.w.abs() > 1.0 - 1e-6, "{difference}");
}

#[test]
fn the_shorter_vector_stays_where_it_is_nearer() {
    let vector = Vec3::new(0.0, 1.0, 0.0);
    assert_eq!(nearest_to(Vec3::ZERO, vector), vector);
    assert_eq!(nearest_to(Vec3::new(0.0, 2.0, 0.0), vector), vector);
    assert_eq!(nearest_to(vector, Vec3::ZERO), Vec3::ZERO);
}
