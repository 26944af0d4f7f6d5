//! Rest poses in which a skeleton is bound.

use mocap::figure::Figure;
use mocap::figure::report::RestPose;

use crate::placed_joints::{Joint, scene};

/// A person whose arms are lowered by these angles in degrees. The hips are rolled by 7 degrees, as in SMPL's bodies.
/// `turned` rotates the shoulders about the up axis, in degrees.
fn person(left: f32, right: f32, turned: f32) -> Vec<Joint> {
    let arm = |side: f32, below: f32, along: f32| {
        let (sine, cosine) = below.to_radians().sin_cos();
        let across = side * (0.18 + along * cosine);
        let (turn_sine, turn_cosine) = turned.to_radians().sin_cos();
        [across * turn_cosine, 1.4 - along * sine, -across * turn_sine]
    };
    vec![
        ("Hips", None, [0.0, 0.95, 0.0]),
        ("Spine", Some(0), [0.0, 1.08, 0.0]),
        ("Neck", Some(1), [0.0, 1.45, 0.0]),
        ("Head", Some(2), [0.0, 1.58, 0.0]),
        ("LeftUpLeg", Some(0), [0.06, 0.867, 0.0]),
        ("LeftLeg", Some(4), [0.08, 0.47, 0.0]),
        ("LeftFoot", Some(5), [0.08, 0.08, -0.02]),
        ("LeftToeBase", Some(6), [0.08, 0.02, 0.1]),
        ("RightUpLeg", Some(0), [-0.06, 0.853, 0.0]),
        ("RightLeg", Some(8), [-0.08, 0.47, 0.0]),
        ("RightFoot", Some(9), [-0.08, 0.08, -0.02]),
        ("RightToeBase", Some(10), [-0.08, 0.02, 0.1]),
        ("LeftArm", Some(1), arm(1.0, left, 0.0)),
        ("LeftForeArm", Some(12), arm(1.0, left, 0.28)),
        ("LeftHand", Some(13), arm(1.0, left, 0.53)),
        ("RightArm", Some(1), arm(-1.0, right, 0.0)),
        ("RightForeArm", Some(15), arm(-1.0, right, 0.28)),
        ("RightHand", Some(16), arm(-1.0, right, 0.53)),
    ]
}

/// Hip joints that an author estimated from a skin are not level. A body with rotated shoulders is in motion.
#[test]
fn arms_that_are_lowered_unevenly_make_a_t_pose() {
    for (left, right) in [(7.0, 16.0), (16.0, 7.0), (0.0, 9.0)] {
        let pose = |turned: f32| Figure::new(&scene(&person(left, right, turned))).rest_pose;
        let found = pose(0.0);
        assert_eq!(found.value, RestPose::TPose, "{left} and {right}: {}", found.reason);
        let found = pose(12.0);
        assert_eq!(found.value, RestPose::Other, "{left} and {right}: {}", found.reason);
    }
}
