//! Tests the least height of swinging feet.

use mocap_retarget::internals::clearances;

#[test]
fn a_foot_rises_after_it_stood_and_comes_down_before_it_stands() {
    let fps = 60.0;
    // One foot stands for 10 frames, swings for 24 and stands for 10. The other foot never stands.
    let contacts: Vec<[bool; 2]> = (0..44).map(|frame| [!(10..34).contains(&frame), false]).collect();
    let fast = vec![[2.0; 2]; contacts.len()];
    let found = clearances(&contacts, &fast, fps, 0.03);
    for (frame, [left, right]) in found.iter().enumerate() {
        assert_eq!(*right, 0.0);
        assert_eq!(*left, found[43 - frame][0], "frame {frame}");
        if contacts[frame][0] {
            assert_eq!(*left, 0.0);
        }
    }
    // The full height begins after 0.15 s. After a third of this time, the sole has risen by a quarter of the way from
    // 7 mm to the full height. A quarter is the square of the sine of 30 degrees.
    assert!((found[21][0] - 0.03).abs() < 1e-9);
    assert!((found[12][0] - 0.01275).abs() < 1e-9, "{}", found[12][0]);
    // A sole scrapes within 5 mm of the floor, from the first frame in the air on.
    assert!(found[10][0] > 0.006, "{}", found[10][0]);
    let steps = found[10..34].windows(2).map(|two| (two[1][0] - two[0][0]).abs() * fps);
    assert!(
        steps.fold(0.0, f64::max) < 0.5,
        "no foot in the air rises faster than 0.5 m/s"
    );
}

/// A landing sole carries the body before it rests, so a slow sole stays near the floor.
#[test]
fn a_slow_foot_stays_near_the_floor() {
    let contacts: Vec<[bool; 2]> = (0..60).map(|frame| [!(10..50).contains(&frame), true]).collect();
    let at = |speed: f64| clearances(&contacts, &vec![[speed; 2]; 60], 60.0, 0.025)[30][0];
    assert_eq!(at(0.0), 0.0);
    // A sole that is faster than 0.3 m/s within 5 mm of the floor scrapes.
    assert!(at(0.3) > 0.005 && at(0.3) < 0.02, "{}", at(0.3));
    assert!((at(2.0) - 0.025).abs() < 1e-12);
}
