//! Tests Euler angles in every order.

mod lanes;

use mocap::glam::{DMat3, DQuat, DVec3};
use mocap::scene::RotationOrder;
use mocap_scene::math::rotation::{Axis, from_euler, to_euler, with_assimp_sign};

fn from_angles(order: RotationOrder, angles: [f64; 3]) -> DQuat {
    from_euler(order.axes().map(|axis| Axis::ALL[axis]).into_iter().zip(angles))
}

/// The definition of a rotation about an axis.
fn matrix(axis: Axis, degrees: f64) -> DMat3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    match axis {
        Axis::X => DMat3::from_cols(DVec3::X, DVec3::new(0.0, cos, sin), DVec3::new(0.0, -sin, cos)),
        Axis::Y => DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos)),
        Axis::Z => DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z),
    }
}

#[test]
fn every_order_is_the_product_of_its_matrices() {
    for order in RotationOrder::ALL {
        for angles in [[10.0, 20.0, 30.0], [-100.0, 77.0, 200.0], [658.0, -90.0, 45.0]] {
            let rotations = order.axes().map(|axis| Axis::ALL[axis]).into_iter().zip(angles);
            let expected = rotations
                .clone()
                .fold(DMat3::IDENTITY, |m, (axis, angle)| m * matrix(axis, angle));
            let rotation = from_euler(rotations);
            assert!(
                DMat3::from_quat(rotation).abs_diff_eq(expected, 1e-12),
                "{order:?} {angles:?}"
            );
        }
    }
}

#[test]
fn angles_come_back_in_every_order() {
    for order in RotationOrder::ALL {
        for angles in [
            [10.0, 20.0, 30.0],
            [-100.0, 77.0, 200.0],
            [658.0, -89.0, 45.0],
            [0.0, 130.0, -170.0],
        ] {
            let rotation = from_angles(order, angles);
            // Near the given angles, the result has exactly these angles.
            let near = angles.map(|angle| angle + 7.0);
            let found = to_euler(rotation, order, near);
            for (angle, found) in std::iter::zip(angles, found) {
                assert!((angle - found).abs() < 1e-9, "{order:?} {angles:?} {found}");
            }
            // From any other start, the angles give an equal rotation.
            let again = from_angles(order, to_euler(-rotation, order, [0.0; 3]));
            assert!(again.dot(rotation).abs() > 1.0 - 1e-12, "{order:?} {angles:?}");
        }
    }
}

#[test]
fn gimbal_lock_keeps_the_last_angle() {
    for order in RotationOrder::ALL {
        for b in [90.0, -90.0] {
            let rotation = from_angles(order, [40.0, b, 25.0]);
            let found = to_euler(rotation, order, [30.0, b, 20.0]);
            assert!((found[2] - 20.0).abs() < 1e-9, "{order:?} {found:?}");
            let again = from_angles(order, found);
            assert!(again.dot(rotation).abs() > 1.0 - 1e-12, "{order:?} {found:?}");
        }
    }
}

#[test]
fn a_smooth_motion_has_smooth_angles() {
    for order in RotationOrder::ALL {
        let mut before = [0.0; 3];
        for step in 0..=1080 {
            let rotation = from_angles(order, [f64::from(step), 20.0, -0.5 * f64::from(step)]);
            let angles = to_euler(rotation, order, before);
            let jump = std::iter::zip(angles, before)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(
                step == 0 || jump < 1.001,
                "{order:?} at {step}: {before:?} to {angles:?}"
            );
            before = angles;
        }
        assert!((before[0] - 1080.0).abs() < 1e-6, "{order:?} {before:?}");
    }
}

#[test]
fn the_sign_is_that_of_the_matrix_quaternion() {
    let sign = |axis, degrees| with_assimp_sign(from_euler([(axis, degrees)].into_iter()));
    assert!(sign(Axis::Z, 100.0).w > 0.0);
    // The trace 1 + 2 cos 130 is negative. So the largest of x, y, z becomes positive.
    assert!(sign(Axis::Z, 130.0).z > 0.0 && sign(Axis::Z, -130.0).z > 0.0);
    assert!(sign(Axis::Z, -130.0).w < 0.0);
    assert!(sign(Axis::X, 359.0).w > 0.0);
}
