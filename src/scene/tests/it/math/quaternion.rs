//! Tests exponentials, twists and means of rotations.

use mocap::glam::{Quat, Vec3};
use mocap_scene::math::quaternion::{exp, log, log_without_branches, mean, nlerp, squared_angle, twist, twist_angle};

#[test]
fn a_rotation_is_the_exponential_of_its_logarithm() {
    for angle in [0.0, 1e-6, 1e-3, 0.1, 0.3999, 0.4001, 1.0, 2.0, 3.0, -3.1] {
        let vector = Vec3::new(0.6, 0.0, -0.8) * angle;
        let rotation = exp(vector);
        assert!(rotation.is_normalized());
        assert!(rotation.abs_diff_eq(Quat::from_axis_angle(Vec3::new(0.6, 0.0, -0.8), angle), 1e-6));
        for rotation in [rotation, -rotation] {
            assert!(log(rotation).abs_diff_eq(vector, 1e-6 * (1.0 + angle.abs())), "{angle}");
        }
    }
}

#[test]
fn what_has_no_branches_is_the_same() {
    let axis = Vec3::new(0.48, -0.6, 0.64);
    for angle in [0.0f32, 1e-4, 0.02, 0.5, 1.5, 2.5, 3.1, -2.9] {
        for sign in [1.0, -1.0] {
            let rotation = Quat::from_axis_angle(axis, angle) * sign;
            let found = Vec3::from_array(log_without_branches(rotation.to_array()));
            assert!(
                found.abs_diff_eq(axis * angle, 1e-6 * (1.0 + angle.abs())),
                "{angle}: {found}"
            );
            let square = squared_angle(rotation.to_array(), Quat::IDENTITY.to_array());
            assert!(
                (square - angle * angle).abs() < 1e-6 * (1.0 + angle * angle),
                "{angle}: {square}"
            );
        }
    }
}

#[test]
fn a_rotation_is_its_twist_and_a_swing() {
    let axis = Vec3::new(0.6, 0.0, -0.8);
    for angle in [-3.0, -0.5, 0.0, 0.1, 2.0_f32] {
        // A swing rotates about an axis that is perpendicular to the axis of the twist.
        let swing = Quat::from_axis_angle(Vec3::new(0.8, 0.0, 0.6), 0.7);
        let about = Quat::from_axis_angle(axis, angle);
        for rotation in [swing * about, about * swing, -(swing * about)] {
            let found = twist(rotation, axis);
            assert!(found.dot(about).abs() > 1.0 - 1e-6, "{angle}: {found}");
            assert!((twist_angle(rotation, axis) - angle).abs() < 1e-5, "{angle}");
        }
    }
    assert_eq!(
        twist(Quat::from_rotation_x(std::f32::consts::PI), Vec3::Y).xyz(),
        Vec3::ZERO
    );
}

#[test]
fn the_sign_of_a_quaternion_changes_neither_blend_nor_mean() {
    let (from, to) = (Quat::from_rotation_x(0.2), Quat::from_rotation_x(0.6));
    let half = Quat::from_rotation_x(0.4);
    assert!(nlerp(from, to, 0.5).abs_diff_eq(half, 1e-6));
    assert!(nlerp(from, -to, 0.5).abs_diff_eq(half, 1e-6));
    assert!(mean(&[from, -to]).unwrap().abs_diff_eq(half, 1e-6));
    assert_eq!(mean(&[]), None);
}
