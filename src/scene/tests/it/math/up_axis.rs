//! Tests rotations from one up axis to another.

use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::UpAxis;
use mocap_scene::math::up_axis::{from_to, to_y_up, turn_to_y_up, turned};

#[test]
fn what_points_up_still_does() {
    let axes = [Vec3::Y, Vec3::Z, Vec3::NEG_Y, Vec3::NEG_Z];
    let point = Vec3::new(1.0, 2.0, 3.0);
    for (from, axis) in std::iter::zip(UpAxis::ALL, axes) {
        assert_eq!(to_y_up(axis, from), Vec3::Y);
        let rotation = Mat4::from_quat(turn_to_y_up(from).as_quat());
        assert!(
            rotation.abs_diff_eq(from_to(from, UpAxis::Y), 1e-6),
            "{from:?}: {rotation}"
        );
        for (to, other) in std::iter::zip(UpAxis::ALL, axes) {
            assert_eq!(turned(axis, from, to), other, "{from:?} to {to:?}");
            assert_eq!(turned(point, from, to), from_to(from, to).transform_vector3(point));
            assert_eq!(from_to(from, to) * from_to(to, from), Mat4::IDENTITY);
            assert_eq!(from_to(from, to).determinant(), 1.0);
        }
    }
    let [y_to_z, z_to_y] = [from_to(UpAxis::Y, UpAxis::Z), from_to(UpAxis::Z, UpAxis::Y)];
    assert_eq!(y_to_z.transform_vector3(Vec3::Y), Vec3::Z);
    assert_eq!(z_to_y.transform_vector3(Vec3::Z), Vec3::Y);
    // X does not change, so left and right are not swapped.
    assert_eq!(z_to_y.transform_vector3(Vec3::X), Vec3::X);
    assert_eq!(
        turn_to_y_up(UpAxis::Z).as_quat(),
        Quat::from_rotation_arc(Vec3::Z, Vec3::Y)
    );
}
