//! Tests the angles that BVH files store.

use mocap::glam::Quat;
use mocap::scene::RotationOrder;
use mocap_formats::internals::bvh::{Angles, unit_within};
use mocap_scene::math::rotation::{Axis, from_euler};

#[test]
fn angles_with_few_decimals_come_back_with_few() {
    for order in RotationOrder::ALL {
        let axes = order.axes().map(|axis| Axis::ALL[axis]);
        for written in [
            [-13.8102, 2.5002, 3.3502],
            [90.0, 0.0, 90.0],
            [0.0, -5.5, 0.0],
            [100.4, -36.8, -11.4],
        ] {
            let key = from_euler(axes.into_iter().zip(written)).as_quat();
            assert_eq!(Angles::new(order, true).next(key), Some(written), "{order:?}");
        }
    }
}

#[test]
fn a_rounded_unit_quaternion_has_a_unit_quaternion_near() {
    let mut angle = 0.1;
    for _ in 0..1000 {
        angle = (angle * 7.3) % 360.0;
        let axes = [Axis::X, Axis::Y, Axis::Z];
        let key = from_euler(axes.into_iter().zip([angle, 2.0 * angle, 0.3 * angle])).as_quat();
        let rotation = unit_within(key).unwrap();
        assert_eq!(rotation.as_quat(), key);
        assert!((rotation.length() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn what_is_no_rotation_is_refused() {
    for key in [
        Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
        Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0),
    ] {
        assert_eq!(Angles::new(RotationOrder::Zxy, true).next(key), None);
    }
}
