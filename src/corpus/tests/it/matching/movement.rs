//! How parts of a motion move.

use mocap_corpus::internals::{LIMBS, Movements, NUMBERS, Scale, WIDTH};

/// An arm that turns by a right angle from sample to sample, and one that rests.
fn arm(limb: usize) -> Vec<i8> {
    let row = |turned: bool| {
        let mut row = [0; WIDTH];
        row[3 * limb + usize::from(turned)] = 127;
        row[3 * LIMBS] = 63;
        row
    };
    [false, true, false, true].into_iter().flat_map(row).collect()
}

#[test]
fn speeds_and_spreads_are_those_of_the_part() {
    let movement = Movements::new(&arm(2)).part(1, 2);
    // A right angle is a chord of the root of 2, 20 times a second; the arm is the faster one of its pair.
    assert!((movement[3] - 20.0 * 2.0_f32.sqrt()).abs() < 1e-4, "{movement:?}");
    assert_eq!(movement[2], 0.0);
    // Two directions of length 1 with a mean of length half the root of 2.
    assert!((movement[LIMBS + 3] - 0.5_f32.sqrt()).abs() < 1e-6, "{movement:?}");
    assert!(
        (movement[2 * LIMBS] - 63.0 / 127.0).abs() < 1e-6 && movement[NUMBERS - 1] < 1e-3,
        "{movement:?}"
    );
}

#[test]
fn the_other_arm_moves_the_same() {
    let [left, right] = [2, 3].map(|limb| Movements::new(&arm(limb)).part(0, 3));
    assert_eq!(left, right);
    let still = Movements::new(&arm(2)[..2 * WIDTH]).part(0, 0);
    let scale = Scale::new([left, still].iter());
    assert_eq!(scale.distance(&left, &right, &[true; LIMBS]), 0.0);
    assert!(scale.distance(&left, &still, &[true; LIMBS]) > 1.0);
    // Without the arm only the height is left, which does not differ.
    let mut limbs = [true; LIMBS];
    limbs[3] = false;
    assert_eq!(scale.distance(&left, &still, &limbs), 0.0);
}
