//! Tests that many rotations, computed at once, equal single rotations.

use mocap::glam::Quat;
use mocap_scene::math::rotation::lanes::{LANES, Lanes, fill, fill_lanes, sin_cos_of_half};
use mocap_scene::math::rotation::{Axis, from_euler, with_assimp_sign};

fn key(rotations: &[(Axis, f64)]) -> Quat {
    let columns: Vec<(Axis, &[f64])> = rotations
        .iter()
        .map(|(axis, angle)| (*axis, std::slice::from_ref(angle)))
        .collect();
    let mut keys = [Quat::NAN];
    fill(&columns, &mut keys);
    keys[0]
}

#[test]
fn a_key_is_that_of_one_rotation_after_the_other() {
    let mut angle = 0.0;
    for order in [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
        [2, 2, 0],
    ] {
        for _ in 0..5_000 {
            let rotations = order.map(|axis| {
                // The step is no fraction of a turn, so all parts of the circle occur.
                angle += 0.377;
                (Axis::ALL[axis], angle % 1_000.0 - 500.0)
            });
            let expected = with_assimp_sign(from_euler(rotations.into_iter()));
            // The error is half a unit in the last digit. It doubles if the two values are on different sides of a
            // rounding.
            assert!(
                key(&rotations).abs_diff_eq(expected, f32::EPSILON / 2.0),
                "{rotations:?}"
            );
        }
    }
}

#[test]
fn sine_and_cosine_are_those_of_the_standard_library() {
    for step in -200_000..=200_000 {
        // 0.37 degrees are no fraction of a turn, so all parts of the circle occur.
        let degrees: Lanes = Lanes::of(|lane| f64::from(step) * 0.37 + lane as f64 * 0.043);
        let (sin, cos) = sin_cos_of_half(degrees);
        for lane in 0..LANES {
            // The reduction to the range -360 to 360 has no error. The conversion to radians rounds twice, by at most
            // 7e-16.
            let angle = degrees.0[lane] - 720.0 * (degrees.0[lane] / 720.0).round();
            let (expected_sin, expected_cos) = (0.5 * angle).to_radians().sin_cos();
            assert!((sin.0[lane] - expected_sin).abs() < 1e-15, "{}", degrees.0[lane]);
            assert!((cos.0[lane] - expected_cos).abs() < 1e-15, "{}", degrees.0[lane]);
        }
    }
}

#[test]
fn whole_quarter_turns_are_exact() {
    for (degrees, expected) in [
        (0.0, (0.0, 1.0)),
        (180.0, (1.0, 0.0)),
        (360.0, (0.0, -1.0)),
        (-180.0, (-1.0, 0.0)),
        (540.0, (-1.0, 0.0)),
        (720e9 + 180.0, (1.0, 0.0)),
        (720.0, (0.0, 1.0)),
    ] {
        let (sin, cos) = sin_cos_of_half(Lanes::all(degrees));
        assert_eq!((sin.0[0], cos.0[0]), expected, "{degrees}");
    }
}

#[test]
fn angles_of_any_size_give_rotations() {
    for angle in [1e9, 1e12, -3.4e38, 1e-300, -0.0] {
        let rotation = key(&[(Axis::X, angle), (Axis::Y, angle), (Axis::Z, angle)]);
        assert!(rotation.is_normalized(), "{angle}: {rotation}");
    }
}

#[test]
fn wider_vectors_give_the_same_bits() {
    let column: Vec<f64> = (0..1003).map(|frame| f64::from(frame) * 1.37 - 700.0).collect();
    let columns: [(Axis, &[f64]); 3] = [(Axis::Z, &column), (Axis::X, &column[1..]), (Axis::Y, &column[2..])];
    let (mut here, mut anywhere) = ([Quat::NAN; 1001], [Quat::NAN; 1001]);
    fill(&columns, &mut here);
    fill_lanes(&columns, &mut anywhere);
    assert_eq!(here, anywhere);
}

#[test]
fn a_key_does_not_depend_on_its_neighbours() {
    let column: Vec<f64> = (0..37).map(|frame| f64::from(frame) * 33.3).collect();
    let mut together = vec![Quat::NAN; column.len()];
    fill(&[(Axis::Y, &column), (Axis::X, &column)], &mut together);
    let alone: Vec<Quat> = column
        .iter()
        .map(|&angle| key(&[(Axis::Y, angle), (Axis::X, angle)]))
        .collect();
    assert_eq!(together, alone);
}
