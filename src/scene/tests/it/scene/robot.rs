//! Tests the inertia of a robot's links.

use mocap::glam::{DMat3, DQuat, DVec3, EulerRot};
use mocap::scene::robot::{Inertial, Placement};

#[test]
fn a_box_has_the_inertia_of_a_box() {
    // The moments of a box of 2 kg and 0.2 x 0.4 x 0.6 m are m / 12 (b^2 + c^2), and so on.
    let moments = [
        2.0 / 12.0 * (0.16 + 0.36),
        2.0 / 12.0 * (0.04 + 0.36),
        2.0 / 12.0 * (0.04 + 0.16),
    ];
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, -0.2, 0.7);
    let axes = DMat3::from_quat(turn);
    let inertia = axes * DMat3::from_diagonal(DVec3::from_array(moments)) * axes.transpose();
    let inertial = Inertial {
        mass: 2.0,
        origin: Placement::IDENTITY,
        inertia: [
            inertia.x_axis.x,
            inertia.y_axis.y,
            inertia.z_axis.z,
            inertia.x_axis.y,
            inertia.x_axis.z,
            inertia.y_axis.z,
        ],
    };
    let (origin, half_size) = inertial.equivalent_box().unwrap();
    let mut sides = (2.0 * half_size).to_array();
    sides.sort_unstable_by(f64::total_cmp);
    assert!(
        DVec3::from_array(sides).abs_diff_eq(DVec3::new(0.2, 0.4, 0.6), 1e-9),
        "{sides:?}"
    );
    // The shortest side is along the box's own X.
    let shortest = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .min_by(|a, b| (half_size * *a).length().total_cmp(&(half_size * *b).length()))
        .unwrap();
    let along = (origin.rotation * shortest).dot(turn * DVec3::X).abs();
    assert!((along - 1.0).abs() < 1e-9, "{along}");
}
