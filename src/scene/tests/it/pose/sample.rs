//! Tests the values of keys at a tick.

use std::f32::consts::{FRAC_1_SQRT_2, PI};

use mocap::Trs;
use mocap::glam::{Mat4, Quat, Vec3};
use mocap::scene::{Channel, Keys};
use proptest::prelude::*;

/// A rotation about Z. The test computes it without glam, in the same way as the keys of a file are computed.
fn about_z(degrees: f64) -> Quat {
    let (sin, cos) = (degrees.to_radians() / 2.0).sin_cos();
    Quat::from_xyzw(0.0, 0.0, sin as f32, cos as f32)
}

#[test]
fn a_track_without_keys_has_no_value() {
    assert_eq!(Keys::<Vec3>::default().sample(1.0), None);
    let no_ticks = Keys::<Quat> {
        values: Vec::new(),
        ticks: Some(Vec::new()),
    };
    assert_eq!(no_ticks.sample(1.0), None);
}

#[test]
fn one_key_holds_for_all_time() {
    let keys = Keys::constant(Vec3::X);
    let late_key = Keys {
        values: vec![Vec3::X],
        ticks: Some(vec![7.0]),
    };
    for tick in [f64::NEG_INFINITY, -1.0, 0.0, 0.5, 7.0, 1e300, f64::INFINITY, f64::NAN] {
        assert_eq!(keys.sample(tick), Some(Vec3::X), "{tick}");
        assert_eq!(late_key.sample(tick), Some(Vec3::X), "{tick}");
    }
}

#[test]
fn ticks_beyond_the_keys_take_the_nearest() {
    let keys = Keys::every_tick(vec![Vec3::X, Vec3::Y, Vec3::Z]);
    let spaced = Keys {
        values: keys.values.clone(),
        ticks: Some(vec![1.0, 4.0, 5.0]),
    };
    for keys in [keys, spaced] {
        for before in [f64::NEG_INFINITY, -0.5, 0.0, f64::NAN] {
            assert_eq!(keys.sample(before), Some(Vec3::X), "{before}");
        }
        for after in [5.0, 5.5, f64::INFINITY] {
            assert_eq!(keys.sample(after), Some(Vec3::Z), "{after}");
        }
    }
}

#[test]
fn positions_move_on_a_line_between_keys() {
    let keys = Keys {
        values: vec![Vec3::ZERO, Vec3::new(4.0, 8.0, -16.0)],
        ticks: Some(vec![10.0, 14.0]),
    };
    assert_eq!(keys.sample(11.0), Some(Vec3::new(1.0, 2.0, -4.0)));
    assert_eq!(keys.sample(13.0), Some(Vec3::new(3.0, 6.0, -12.0)));
}

#[test]
fn rotations_turn_evenly() {
    let keys = Keys::every_tick(vec![about_z(10.0), about_z(130.0)]);
    for (tick, degrees) in [(0.25, 40.0), (0.5, 70.0), (0.75, 100.0)] {
        let turned = keys.sample(tick).unwrap();
        assert!(turned.abs_diff_eq(about_z(degrees), 1e-6), "{tick}: {turned}");
    }
}

#[test]
fn rotations_take_the_shorter_way() {
    // From 10 to 350 degrees, the interpolation goes 20 degrees backward, not 340 degrees forward. A negated quaternion
    // is the same rotation.
    for end in [about_z(350.0), -about_z(350.0)] {
        let middle = Keys::every_tick(vec![about_z(10.0), end]).sample(0.5).unwrap();
        assert!(middle.abs_diff_eq(Quat::IDENTITY, 1e-6), "{middle}");
    }
    let same = Keys::every_tick(vec![about_z(70.0), -about_z(70.0)]);
    assert!(same.sample(0.5).unwrap().abs_diff_eq(about_z(70.0), 1e-6));
}

#[test]
fn small_and_half_turns_stay_rotations() {
    for degrees in [1e-4, 0.01, 0.05, 0.1, 1.0, 179.99, 180.0] {
        let keys = Keys::every_tick(vec![about_z(0.0), about_z(degrees)]);
        for eighth in 1..8 {
            let tick = f64::from(eighth) / 8.0;
            let turned = keys.sample(tick).unwrap();
            assert!((turned.length() - 1.0).abs() < 1e-6, "{degrees} at {tick}: {turned}");
            assert!(
                turned.abs_diff_eq(about_z(degrees * tick), 1e-6),
                "{degrees} at {tick}: {turned}"
            );
        }
    }
}

#[test]
fn ticks_and_values_of_different_number_do_no_harm() {
    for (values, ticks) in [(1, 3), (3, 1), (2, 0), (0, 2)] {
        let keys = Keys {
            values: vec![Vec3::ONE; values],
            ticks: Some((0..ticks).map(f64::from).collect()),
        };
        for tick in [-1.0, 0.0, 0.5, 1.5, 9.0] {
            assert_eq!(keys.sample(tick), (values > 0).then_some(Vec3::ONE));
        }
    }
}

#[test]
fn a_channel_takes_what_it_lacks_from_the_rest_transform() {
    let channel = Channel {
        rotation_keys: Keys::constant(about_z(90.0)),
        ..Channel::default()
    };
    let rest = Trs {
        translation: Vec3::new(1.0, 2.0, 3.0),
        rotation: about_z(30.0),
        scale: Vec3::splat(2.0),
    };
    let expected = Trs {
        rotation: about_z(90.0),
        ..rest
    };
    assert_eq!(channel.sample(3.0, rest), expected);
    assert_eq!(Channel::default().sample(3.0, rest), rest);
}

#[test]
fn the_matrix_scales_first_and_moves_last() {
    let trs = Trs {
        translation: Vec3::new(10.0, 20.0, 30.0),
        rotation: about_z(90.0),
        scale: Vec3::new(2.0, 3.0, 4.0),
    };
    // x is scaled to 2 and rotated onto y; y is scaled to 3 and rotated onto -x.
    let point = trs.matrix().transform_point3(Vec3::ONE);
    assert!(point.abs_diff_eq(Vec3::new(7.0, 22.0, 34.0), 1e-5), "{point}");
}

#[test]
fn a_matrix_comes_apart_into_its_components() {
    let matrix = Mat4::from_cols_array(&[
        0.0, 2.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 5.0, 6.0, 7.0, 1.0,
    ]);
    let trs = Trs::from_matrix(matrix);
    assert_eq!(trs.translation, Vec3::new(5.0, 6.0, 7.0));
    assert_eq!(trs.scale, Vec3::new(2.0, 3.0, 4.0));
    assert!(
        trs.rotation
            .abs_diff_eq(Quat::from_xyzw(0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2), 1e-6)
    );

    let flat = Trs::from_matrix(Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0)));
    assert_eq!(flat.rotation, Quat::IDENTITY);
}

fn vectors() -> impl Strategy<Value = Vec<Vec3>> {
    let vector = prop::array::uniform3(-1e3f32..1e3).prop_map(Vec3::from);
    prop::collection::vec(vector, 1..20)
}

fn rotations() -> impl Strategy<Value = Vec<Quat>> {
    let rotation = (prop::array::uniform3(-1f32..1.0), -PI..PI).prop_filter_map("no axis", |(axis, angle)| {
        let axis = Vec3::from(axis).try_normalize()?;
        Some(Quat::from_axis_angle(axis, angle))
    });
    prop::collection::vec(rotation, 1..20)
}

proptest! {
    #[test]
    fn at_whole_ticks_the_keys_come_back(positions in vectors(), rotations in rotations()) {
        let position_keys = Keys::every_tick(positions.clone());
        let rotation_keys = Keys::every_tick(rotations.clone());
        for (tick, position) in positions.iter().enumerate() {
            prop_assert_eq!(position_keys.sample(tick as f64), Some(*position));
        }
        for (tick, rotation) in rotations.iter().enumerate() {
            prop_assert_eq!(rotation_keys.sample(tick as f64), Some(*rotation));
        }
    }

    #[test]
    fn at_its_tick_each_key_comes_back(
        values in rotations(), gaps in prop::collection::vec(1e-3f64..1e3, 20), start in -10f64..10.0,
    ) {
        let ticks = gaps.iter().scan(start, |tick, gap| { *tick += gap; Some(*tick) });
        let keys = Keys { ticks: Some(ticks.take(values.len()).collect()), values };
        for (index, value) in keys.values.iter().enumerate() {
            prop_assert_eq!(keys.sample(keys.tick(index)), Some(*value));
        }
    }

    #[test]
    fn written_ticks_mean_what_counted_ticks_mean(values in rotations(), tick in -2f64..22.0) {
        let written = Keys { ticks: Some((0..values.len()).map(|tick| tick as f64).collect()), values };
        let counted = Keys::every_tick(written.values.clone());
        prop_assert_eq!(written.sample(tick), counted.sample(tick));
    }

    #[test]
    fn between_two_keys_a_rotation_is_between_them(values in rotations(), tick in 0f64..18.0) {
        prop_assume!(values.len() > 1);
        let tick = tick % (values.len() - 1) as f64;
        let (from, to) = (values[tick as usize], values[tick as usize + 1]);
        let turned = Keys::every_tick(values).sample(tick).unwrap();
        // This angle comes from an arc cosine, which cannot distinguish angles below 1e-3.
        let (found, expected) = (from.angle_between(turned), tick.fract() as f32 * from.angle_between(to));
        prop_assert!((found - expected).abs() < 2e-3, "{found} of {expected}");
        prop_assert!((turned.length() - 1.0).abs() < 1e-5);
    }
}
