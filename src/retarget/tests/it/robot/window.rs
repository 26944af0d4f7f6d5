//! Tests which frames of a window are solved again.

use mocap_retarget::internals::window::{SMALL, near};

#[test]
fn frames_near_those_that_moved_are_solved_again() {
    let mut moved = vec![0.0; 40];
    (moved[3], moved[20], moved[24]) = (1.0, SMALL, 1.0);
    moved[30] = 0.5 * SMALL;
    assert_eq!(near(&moved, 100, 4.0), [100..108, 116..129]);
    assert!(near(&[0.0; 9], 0, 4.0).is_empty());
}
