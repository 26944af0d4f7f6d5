//! Tests the springs that smooth the wanted velocity and facing.

use mocap::glam::{Vec2, Vec3};
use mocap_corpus::internals::{AHEAD, RATE, Root, Steering};

const AT_ORIGIN: Root = Root {
    position: Vec3::ZERO,
    forward: Vec3::Z,
};

/// The spring's differential equation, x'' = -2 r (x' - goal') - r^2 (x - goal), in small steps.
#[test]
fn springs_are_those_of_their_equation() {
    let mut steering = Steering::new(Vec3::Z);
    let trajectory = steering.update(&AT_ORIGIN, Vec2::new(0.0, 1.5), Vec2::X);
    let (mut moved, mut velocity, mut acceleration) = (0.0_f64, 0.0_f64, 0.0_f64);
    let (mut angle, mut turning) = (0.0_f64, 0.0_f64);
    let (rate, step) = (f64::from(RATE), 1e-5);
    let mut seconds = 0.0;
    for (index, frames) in AHEAD.into_iter().enumerate() {
        while seconds < frames as f64 / 60.0 {
            let jerk = -2.0 * rate * acceleration - rate * rate * (velocity - 1.5);
            let slowing = -2.0 * rate * turning - rate * rate * (angle - std::f64::consts::FRAC_PI_2);
            moved += step * velocity;
            velocity += step * acceleration;
            acceleration += step * jerk;
            angle += step * turning;
            turning += step * slowing;
            seconds += step;
        }
        let found = trajectory.positions[index];
        assert!(
            (f64::from(found.z) - moved).abs() < 1e-3 && found.x == 0.0,
            "{found} {moved}"
        );
        let found = trajectory.directions[index];
        assert!((f64::from(found.x) - angle.sin()).abs() < 1e-3, "{found} {angle}");
    }
}

#[test]
fn a_stick_that_is_let_go_stops_it_and_leaves_where_it_looks() {
    let mut steering = Steering::new(Vec3::Z);
    for _ in 0..300 {
        steering.update(&AT_ORIGIN, Vec2::new(-1.0, -0.1), Vec2::ZERO);
    }
    let going = steering;
    assert!((going.velocity() - Vec3::new(-1.0, 0.0, -0.1)).length() < 1e-3);
    for _ in 0..300 {
        steering.update(&AT_ORIGIN, Vec2::ZERO, Vec2::new(f32::NAN, 1.0));
    }
    assert!(steering.velocity().length() < 1e-3);
    assert!(steering.forward().distance(going.forward()) < 0.05);
}
