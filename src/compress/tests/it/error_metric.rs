//! The displacement that a rotation error causes.

use mocap::glam::{Quat, Vec3};
use mocap_compress::internals::{LeverArms, SHELL_DISTANCE};

#[test]
fn the_error_is_that_of_the_farthest_point() {
    let arms = LeverArms::new(vec![Vec3::X * 0.5, Vec3::X * 0.2]);
    assert_eq!(arms.longest, 0.5);
    let angle = 0.01;
    let across = arms.error(Vec3::ZERO, Quat::from_rotation_z(angle));
    assert!((across - 0.5 * angle).abs() < 1e-6, "{across}");
    // A twist about the arm only moves the shell.
    let twist = arms.error(Vec3::ZERO, Quat::from_rotation_x(angle));
    assert!((twist - SHELL_DISTANCE * angle).abs() < 1e-6, "{twist}");
}

#[test]
fn a_counter_rotation_moves_the_end_of_an_arm_back() {
    let arms = LeverArms::new(vec![Vec3::X * 0.5]);
    let error = Vec3::Y * 0.001;
    let rotation = Vec3::from_array(arms.counter_rotation.map(|row| Vec3::from_array(row).dot(error)));
    // The arc of this angle at the end of the arm has the length of the error, apart from the share of the shell.
    assert!(rotation.abs_diff_eq(Vec3::Z * -0.002, 1e-5), "{rotation}");
    assert!(arms.error(error, Quat::from_scaled_axis(rotation)) < 0.07 * error.y);
}
