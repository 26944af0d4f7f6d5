//! Tests vectors and rotations as structures of arrays.

mod rotation;

use mocap::glam::{DMat3, DQuat, DVec3, EulerRot};
use mocap_scene::math::soa::{Lanes, Matrices, Vectors, double};

type Rotations = double::Quaternions;

fn rotations(first: f64) -> [DQuat; double::LANES] {
    std::array::from_fn(|lane| {
        let angle = first + lane as f64;
        DQuat::from_euler(EulerRot::XYZ, angle, 0.7 * angle, -1.3 * angle)
    })
}

#[test]
fn products_equal_those_of_glam() {
    let (a, b) = (rotations(0.3), rotations(2.0));
    let [many_a, many_b] = [a, b].map(|all| Rotations::of(|lane| all[lane].to_array()));
    let vector = DVec3::new(1.0, -2.0, 0.5);
    let vectors = Vectors::all(vector.to_array());
    let mut product = Matrices::ZERO;
    product.set_product(&many_a.into(), &many_b.into());
    for lane in 0..double::LANES {
        let (a, b) = (a[lane], b[lane]);
        let is_near = |found: [f64; 3], expected: DVec3| {
            let found = DVec3::from_array(found);
            assert!(found.abs_diff_eq(expected, 1e-14), "{found}, not {expected}");
        };
        is_near((many_a * vectors).lane(lane), a * vector);
        is_near((many_a.conjugate() * vectors).lane(lane), a.conjugate() * vector);
        is_near((&product * vectors).lane(lane), a * (b * vector));
        let found = DQuat::from_array((many_a * many_b).lane(lane));
        assert!(found.abs_diff_eq(a * b, 1e-15), "{found}");
    }
}

#[test]
fn an_unnormalized_quaternion_is_a_matrix_that_stretches() {
    let (length, units) = (1.2, rotations(1.0));
    let many = Rotations::of(|lane| units[lane].to_array());
    let found = Matrices::from_unnormalized(many, Lanes::all(length * length));
    for (lane, unit) in units.into_iter().enumerate() {
        let expected = DMat3::from_quat(unit * length);
        for column in 0..3 {
            let found = DVec3::from_array(found.0[column].lane(lane));
            assert!(found.abs_diff_eq(expected.col(column), 1e-14), "{found}");
        }
    }
}

#[test]
fn the_larger_of_a_number_and_nan_is_nan() {
    let a: Lanes<f32, 3> = Lanes([1.0, f32::NAN, 2.0]);
    let b = Lanes([3.0, 1.0, f32::NAN]);
    let found = a.max(b).0;
    assert!(found[0] == 3.0 && found[1].is_nan() && found[2].is_nan(), "{found:?}");
}
