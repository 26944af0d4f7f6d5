//! The distance by which feet come down to the floor.

use mocap_retarget::internals::drops;

#[test]
fn feet_that_stand_come_down_and_those_on_a_step_do_not() {
    let contacts = vec![[true, false]; 100];
    let even = drops(&vec![[0.02, 0.3]; 100], &contacts, 30.0);
    assert!(even.iter().all(|drop| (drop - 0.02).abs() < 1e-12));
    let step = drops(&vec![[0.2, 0.3]; 100], &contacts, 30.0);
    assert!(step.iter().all(|drop| *drop == 0.0));
    // The shift of a foot in the air goes from one stance to the next without a jump.
    let heights: Vec<[f64; 2]> = (0..100)
        .map(|frame| [if frame < 50 { 0.01 } else { 0.03 }, 0.5])
        .collect();
    let contacts: Vec<[bool; 2]> = (0..100).map(|frame| [!(30..70).contains(&frame), false]).collect();
    let found = drops(&heights, &contacts, 30.0);
    assert!((found[0] - 0.01).abs() < 1e-6 && (found[99] - 0.03).abs() < 1e-6);
    assert!(found.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.001));
}
