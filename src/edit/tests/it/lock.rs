//! Tests how a foot lock completes shifts between two contacts, and smooth curves above given values.

use mocap::glam::Vec3;
use mocap_edit::internals::{complete, envelope, filled};
use proptest::prelude::*;

#[test]
fn gaps_fill_with_straight_lines() {
    let known = x(&[None, Some(2.0), None, None, None, Some(4.0), None]);
    let expected = [2.0, 2.0, 2.5, 3.0, 3.5, 4.0, 4.0].map(|value| Vec3::X * value);
    assert_eq!(filled(known.into_iter()), expected);
    assert_eq!(filled([None, None].into_iter()), [Vec3::ZERO; 2]);
}

fn x(values: &[Option<f32>]) -> Vec<Option<Vec3>> {
    values.iter().map(|value| value.map(|x| Vec3::X * x)).collect()
}

#[test]
fn what_is_known_stays_and_the_rest_eases_to_zero() {
    let mut known = vec![None; 30];
    known[10..15].fill(Some(2.0));
    let shifts = complete(&x(&known), 5);
    assert!(
        shifts[..6]
            .iter()
            .chain(&shifts[19..])
            .all(|shift| *shift == Vec3::ZERO),
        "{shifts:?}"
    );
    assert!(shifts[10..15].iter().all(|shift| *shift == Vec3::X * 2.0));
    for pair in shifts[5..11].windows(2) {
        assert!(pair[0].x < pair[1].x && pair[1].x - pair[0].x < 0.7, "{shifts:?}");
    }
}

#[test]
fn near_contacts_join_without_a_detour() {
    let mut known = vec![Some(1.0); 20];
    known[8..12].fill(None);
    let shifts = complete(&x(&known), 5);
    assert!(
        shifts.iter().all(|shift| shift.abs_diff_eq(Vec3::X, 1e-6)),
        "{shifts:?}"
    );
}

#[test]
fn the_speed_does_not_jump() {
    // The shift grows by 1 in each frame in which it is known.
    let known: Vec<_> = (0..60)
        .map(|frame: u16| (frame < 20).then(|| f32::from(frame)))
        .collect();
    let shifts = complete(&x(&known), 20);
    for triple in shifts.windows(3) {
        let change = (triple[2] - 2.0 * triple[1] + triple[0]).length();
        // A cubic from slope 1 and value 19 to 0 within 20 frames has a second derivative of at most (6 * 19 + 4 * 20)
        // / 20^2.
        assert!(change < 0.5, "{change}");
    }
}

proptest! {
    #[test]
    fn an_envelope_is_nowhere_below_and_smooth(values in prop::collection::vec(prop_oneof![Just(0.0f32), 0f32..1.0], 1..80), radius in 1usize..15) {
        let found = envelope(&values, radius);
        for (found, value) in found.iter().zip(&values) {
            prop_assert!(found >= value);
            prop_assert!(*found <= values.iter().copied().fold(0.0, f32::max) + 1e-6);
        }
        for pair in found.windows(2) {
            prop_assert!((pair[0] - pair[1]).abs() <= 2.1 / (radius as f32 + 1.0));
        }
    }
}
