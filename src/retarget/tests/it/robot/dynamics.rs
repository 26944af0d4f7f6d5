//! Tests inverse dynamics against values that are computed by hand.

use mocap::glam::DVec3;
use mocap::scene::robot::{Inertial, JointKind, JointLimits, Placement, Robot, RobotJoint, RobotLink};
use mocap_retarget::internals::{Dynamics, GRAVITY, Kinematics, Rates};

/// A rod of 2 kg and 1 m along X, on a hinge about Y at its end. By hand, the torque m g l / 2 holds it, and m l^2 / 3
/// accelerates it.
#[test]
fn a_rod_takes_what_is_computed_by_hand() {
    let rod = Inertial {
        mass: 2.0,
        origin: Placement {
            translation: DVec3::new(0.5, 0.0, 0.0),
            ..Placement::IDENTITY
        },
        inertia: [0.0, 2.0 / 12.0, 2.0 / 12.0, 0.0, 0.0, 0.0],
    };
    let hinge = RobotJoint {
        kind: JointKind::Hinge,
        axis: DVec3::Y,
        limits: JointLimits::default(),
        armature: 0.25,
        ..RobotJoint::default()
    };
    let robot = Robot {
        links: vec![
            RobotLink::default(),
            RobotLink {
                parent: Some(0),
                joint: hinge,
                inertial: Some(rod),
                ..RobotLink::default()
            },
        ],
        ..Robot::default()
    };
    let kinematics = Kinematics::new(&robot);
    let mut dynamics = Dynamics::new(&robot, &kinematics);
    let still = Rates {
        joints: vec![0.0],
        ..Rates::default()
    };
    let pose = kinematics.rest();
    assert!(dynamics.centre(&pose).abs_diff_eq(DVec3::new(0.5, 0.0, 0.0), 1e-12));
    let held = dynamics.inverse(&kinematics, &pose, &still, &still);
    assert!(held.linear.abs_diff_eq(2.0 * GRAVITY * DVec3::Z, 1e-12));
    assert!((held.joints[0] + GRAVITY).abs() < 1e-12, "{held:?}");
    let turning = Rates {
        joints: vec![3.0],
        ..Rates::default()
    };
    let turned = dynamics.inverse(&kinematics, &pose, &still, &turning);
    let wanted = -GRAVITY + 3.0 * (2.0 / 3.0 + 0.25);
    assert!((turned.joints[0] - wanted).abs() < 1e-12, "{turned:?}");
    // The base and the rod rotate twice per second about Z, so the middle of the rod moves in a circle.
    let spinning = Rates {
        angular: 2.0 * DVec3::Z,
        joints: vec![0.0],
        ..Rates::default()
    };
    let spun = dynamics.inverse(&kinematics, &pose, &spinning, &still);
    assert!(
        spun.linear.abs_diff_eq(DVec3::new(-4.0, 0.0, 2.0 * GRAVITY), 1e-12),
        "{spun:?}"
    );
}
