//! Tests the solver of joint positions.

use mocap::glam::{DQuat, DVec3};
use mocap::retarget::robot::Weights;
use mocap::scene::robot::{JointKind, Mimic, Robot, RobotJoint, RobotLink};
use mocap_retarget::internals::{Bounds, Goals, Kinematics, RotationGoal, Solver, Terms};
use mocap_scene::math::cholesky;

#[test]
fn a_system_is_solved() {
    // By hand: x = (1, -2, 3).
    let full = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 5.0]];
    let known = [1.0, -2.0, 3.0];
    let mut right: Vec<f64> = full
        .iter()
        .map(|row| row.iter().zip(known).map(|(a, x)| a * x).sum())
        .collect();
    let mut matrix: Vec<f64> = full.iter().flatten().copied().collect();
    cholesky::solve(&mut matrix, &mut right, 3);
    for (found, known) in right.iter().zip(known) {
        assert!((found - known).abs() < 1e-12, "{right:?}");
    }
}

/// Two hinges about one axis. The second rotates twice as far as the first. By hand, the first takes 0.3 of a rotation
/// by 0.9.
#[test]
fn a_follower_shares_the_turn_of_its_leader() {
    let link = |parent, mimic| RobotLink {
        parent,
        joint: RobotJoint {
            kind: JointKind::Hinge,
            mimic,
            ..RobotJoint::default()
        },
        ..RobotLink::default()
    };
    let mimic = Mimic {
        leader: 1,
        multiplier: 2.0,
        offset: 0.0,
    };
    let robot = Robot {
        links: vec![RobotLink::default(), link(Some(0), None), link(Some(1), Some(mimic))],
        ..Robot::default()
    };
    let kinematics = Kinematics::new(&robot);
    let turn = |body, target, weight| RotationGoal {
        body,
        weight_axes: DQuat::IDENTITY,
        weights: DVec3::splat(weight),
        target,
    };
    let goals = Goals {
        rotations: vec![
            turn(0, DQuat::IDENTITY, 1e6),
            turn(2, DQuat::from_axis_angle(DVec3::Z, 0.9), 1.0),
        ],
        reaches: Vec::new(),
        ..Goals::default()
    };
    let mut pose = kinematics.rest();
    let bounds = |most: f64| Bounds {
        lower: vec![-most; 2],
        upper: vec![most; 2],
    };
    let mut solver = Solver::new(Terms::new(&kinematics, &goals), Weights::new().hold);
    solver.solve(&kinematics, &goals, &bounds(3.0), &mut pose, 30);
    assert!((pose.positions[0] - 0.3).abs() < 1e-4, "{:?}", pose.positions);
    assert_eq!(pose.positions[1], 2.0 * pose.positions[0]);
}
