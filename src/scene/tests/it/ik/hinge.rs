//! Tests limbs that bend about a hinge.

use mocap::glam::{Quat, Vec3};
use mocap_scene::ik::{bend_about_hinge, hinge_rotations, plane_normal};
use mocap_scene::internals::MOST_OF_HINGE;
use proptest::prelude::*;

fn unit() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-1f32..1.0).prop_filter_map("no direction", |toward| Vec3::from(toward).try_normalize())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// A limb may also be straight. Then only the hinge shows the direction of the bend.
    #[test]
    fn a_goal_within_reach_is_reached(
        toward in unit(), other in unit(), goal in unit(), bend in 0f32..2.5, lengths in (0.05f32..2.0, 0.05f32..2.0), fraction in 0f32..=1.0,
    ) {
        let hinge = toward.cross(other);
        prop_assume!(hinge.length() > 0.05);
        let (hinge, (a, b)) = (hinge.normalize(), lengths);
        let middle = toward * a;
        let joints = [Vec3::ZERO, middle, middle + Quat::from_axis_angle(hinge, bend) * toward * b];
        let goal = goal * ((a - b).abs() + fraction * (a + b - (a - b).abs()));
        let old = plane_normal(joints, hinge);
        prop_assert!(old.dot(hinge) > 0.999);
        prop_assume!(old.reject_from_normalized(goal.normalize_or(Vec3::X)).length() > 0.05);
        let found = hinge_rotations(joints, goal, [old, old]).unwrap();
        let knee = found.upper * joints[1];
        let end = knee + found.lower * (joints[2] - joints[1]);
        prop_assert!(end.distance(goal) < 1e-5, "{}", end.distance(goal));
        // The second bone still bends about the hinge, in the right direction.
        let bent = knee.cross(end - knee);
        prop_assert!(bent.dot(old.reject_from_normalized(goal.normalize())) > -1e-5, "{bent}");
    }
}

/// Noise of 0.1 mm in any direction of a straight leg moves a knee that has to bend only a little.
#[test]
fn noise_does_not_turn_the_plane_of_a_straight_leg() {
    let (thigh, ankle, hinge) = (Vec3::Y, Vec3::ZERO, Vec3::X);
    let goal = Vec3::new(0.0, 0.02, 0.01);
    let knee = |noise: Vec3| {
        let joints = [thigh, Vec3::Y * 0.5 + noise, ankle];
        let found = bend_about_hinge(joints, goal, hinge).unwrap();
        let knee = thigh + found.upper * (joints[1] - thigh);
        let end = knee + found.lower * (ankle - joints[1]);
        assert!(end.distance(goal) < 1e-5);
        assert!(found.upper.to_axis_angle().1 < 0.5, "the thigh is twisted");
        knee
    };
    let still = knee(Vec3::ZERO);
    assert!(still.z > 0.05, "it bends to the front: {still}");
    for angle in 0..12 {
        let noise = Quat::from_rotation_y(angle as f32 * std::f32::consts::FRAC_PI_6) * Vec3::Z * 1e-4;
        assert!(knee(noise).distance(still) < 0.002, "{noise}");
    }
}

/// A bent knee keeps its plane, also if it bends backward. If the goal is the end of the limb, nothing changes.
#[test]
fn a_limb_that_is_seen_to_bend_keeps_its_plane() {
    for knee in [
        Vec3::new(0.0, 0.5, 0.1),
        Vec3::new(0.0, 0.5, -0.1),
        Vec3::new(0.1, 0.5, 0.0),
    ] {
        let joints = [Vec3::Y, knee, Vec3::ZERO];
        let same = bend_about_hinge(joints, joints[2], Vec3::X).unwrap();
        assert!(same.upper.angle_between(Quat::IDENTITY) < 1e-3);
        let found = bend_about_hinge(joints, Vec3::Y * 0.02, Vec3::X).unwrap();
        let moved = joints[0] + found.upper * (knee - joints[0]);
        let (before, after) = (knee.with_y(0.0), moved.with_y(0.0));
        // The hinge has at most the weight MOST_OF_HINGE, and the knee is 0.1 m off the line.
        let most = (MOST_OF_HINGE as f32 * knee.distance(joints[0]) / 0.1).atan();
        assert!(
            after.length() > 0.1 && before.angle_between(after) < most + 1e-3,
            "{knee} {moved}"
        );
    }
}
