//! Tests limbs of two bones that reach a goal.

use mocap::glam::Vec3;
use mocap_scene::ik::TwoBone;
use proptest::prelude::*;

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from)
}

fn unit() -> impl Strategy<Value = Vec3> {
    vector(1.0).prop_filter_map("no direction", Vec3::try_normalize)
}

/// The positions of an arm or leg of 0.1 to 4 m, within 10 m of the origin, bent at any angle.
fn limb() -> impl Strategy<Value = [Vec3; 3]> {
    (vector(10.0), unit(), unit(), 0.05f32..2.0, 0.05f32..2.0)
        .prop_map(|(start, first, second, a, b)| [start, start + a * first, start + a * first + b * second])
}

fn lengths([start, middle, end]: [Vec3; 3]) -> (f32, f32) {
    (start.distance(middle), middle.distance(end))
}

/// The positions of the middle and of the end after the rotations.
fn apply([start, middle, end]: [Vec3; 3], found: &TwoBone) -> [Vec3; 2] {
    let middle_now = start + found.upper * (middle - start);
    [middle_now, middle_now + found.lower * (end - middle)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    #[test]
    fn a_goal_within_reach_is_reached(joints in limb(), toward in unit(), fraction in 0f32..=1.0, pole in prop::option::of(vector(20.0))) {
        let (a, b) = lengths(joints);
        let goal = joints[0] + toward * ((a - b).abs() + fraction * (a + b - (a - b).abs()));
        let found = TwoBone::solve(joints, goal, pole);
        let [middle, end] = apply(joints, &found);
        // The tolerance is 0.01 mm. Positions up to 24 m have a rounding of 2e-6.
        prop_assert!(end.distance(goal) < 1e-5, "{}", end.distance(goal));
        prop_assert!(middle.distance(found.middle) < 1e-5 && end.distance(found.end) < 1e-5);
        prop_assert!(found.distance < 1e-5);
    }

    #[test]
    fn beyond_reach_the_limb_is_straight_towards_the_goal(joints in limb(), toward in unit(), beyond in 1.001f32..1e6) {
        let (a, b) = lengths(joints);
        let found = TwoBone::solve(joints, joints[0] + toward * ((a + b) * beyond), None);
        let [middle, end] = apply(joints, &found);
        prop_assert!(middle.distance(joints[0] + toward * a) < 1e-4, "{middle}");
        prop_assert!(end.distance(joints[0] + toward * (a + b)) < 1e-4, "{end}");
    }

}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1_000))]

    #[test]
    fn the_middle_bends_towards_the_pole(joints in limb(), toward in unit(), fraction in 0.05f32..0.95, pole in vector(20.0)) {
        let (a, b) = lengths(joints);
        let goal = joints[0] + toward * ((a - b).abs() + fraction * (a + b - (a - b).abs()));
        let wanted = (pole - joints[0]).reject_from_normalized(toward);
        prop_assume!(wanted.length() > 0.1);
        let [middle, _] = apply(joints, &TwoBone::solve(joints, goal, Some(pole)));
        let bend = (middle - joints[0]).reject_from_normalized(toward);
        prop_assert!(bend.angle_between(wanted) < 1e-2, "{bend} {wanted}");
    }

    #[test]
    fn a_goal_where_the_end_is_changes_nothing(joints in limb()) {
        let found = TwoBone::solve(joints, joints[2], None);
        let [middle, end] = apply(joints, &found);
        // Near full stretch, the error of the middle is the root of the rounding.
        prop_assert!(middle.distance(joints[1]) < 1e-3 && end.distance(joints[2]) < 1e-5);
    }

    /// A small movement of the goal is a small movement of the limb, unless the limb is fully stretched or folded.
    #[test]
    fn it_is_continuous(joints in limb(), toward in unit(), fraction in 0.02f32..0.98, step in unit()) {
        let (a, b) = lengths(joints);
        prop_assume!((joints[2] - joints[0]).normalize().dot(toward) > -0.99 && joints[0].distance(joints[2]) > 0.05);
        let distance = (a - b).abs() + fraction * (a + b - (a - b).abs());
        prop_assume!(distance > 0.05);
        let goal = joints[0] + toward * distance;
        let [here, _] = apply(joints, &TwoBone::solve(joints, goal, None));
        let [there, _] = apply(joints, &TwoBone::solve(joints, goal + step * 1e-4, None));
        prop_assert!(here.distance(there) < 0.05, "{here} {there}");
    }

    #[test]
    fn nothing_gives_a_number_that_is_not_finite(values in prop::array::uniform15(prop_oneof![
        Just(0.0f32), Just(1.0), Just(-1.0), Just(f32::NAN), Just(f32::INFINITY), Just(f32::MAX), Just(f32::MIN_POSITIVE),
        -2f32..2.0,
    ])) {
        let at = |index: usize| Vec3::from_slice(&values[3 * index..]);
        let joints = [at(0), at(1), at(2)];
        let found = TwoBone::solve(joints, at(3), Some(at(4)));
        prop_assert!(found.upper.is_normalized() && found.lower.is_normalized(), "{found:?}");
    }
}

#[test]
fn a_straight_limb_bends_to_come_nearer() {
    let joints = [Vec3::Y, Vec3::Y * 0.5, Vec3::ZERO];
    for pole in [None, Some(Vec3::new(0.0, 0.5, 1.0))] {
        let goal = Vec3::new(0.0, 0.2, 0.0);
        let [middle, end] = apply(joints, &TwoBone::solve(joints, goal, pole));
        assert!(end.distance(goal) < 1e-6);
        assert!((middle - Vec3::Y).length() - 0.5 < 1e-6);
        assert!(pole.is_none() || (middle.z > 0.29 && middle.x.abs() < 1e-6), "{middle}");
    }
}
