//! Tests of the extremes of an angle, and of the times at which feet land.

use mocap::glam::DVec3;
use mocap_solve::internals::{extended, landings, leavings, turns};

#[test]
fn turns_of_a_sine_are_its_extremes_and_noise_has_none() {
    let sine: Vec<f64> = (0..400).map(|frame| (f64::from(frame) * 0.05).sin()).collect();
    let (highest, lowest) = turns(&sine, 0.5);
    // The period is 125.66 frames. Before its first maximum, the value rises by half of its range.
    assert_eq!(highest, [31, 157, 283]);
    assert_eq!(lowest, [94, 220, 346]);
    assert_eq!(turns(&sine, 5.0), (Vec::new(), Vec::new()));
    assert_eq!(turns(&[], 0.5), (Vec::new(), Vec::new()));
}

#[test]
fn a_foot_lands_when_it_falls_fastest_soon_after_it_was_farthest_before() {
    const RATE: f64 = 100.0;
    // The foot falls by 30 mm within 100 ms, fastest in frame 60. Earlier in the swing, in frame 30, it falls faster.
    let fall = |frame: f64, middle: f64, size: f64| size / (1.0 + ((frame - middle) / 2.5).exp());
    let height = |frame: u32| fall(f64::from(frame), 60.0, 0.03) + fall(f64::from(frame), 30.0, 0.06);
    let heights = |noise: f64| -> Vec<f64> {
        let sign = |frame: u32| if frame.is_multiple_of(2) { noise } else { -noise };
        (0..120).map(|frame| height(frame) + sign(frame)).collect()
    };
    assert_eq!(landings(heights(0.0), &[54], RATE), [60]);
    assert_eq!(landings(heights(0.001), &[54], RATE), [60]);
    // If the foot was farthest forward long before, or does not fall, the frame stays the same. This also holds near
    // the ends.
    assert_eq!(landings(heights(0.0), &[40, 80, 0, 119], RATE)[..2], [40, 80]);
    assert_eq!(landings(vec![0.0; 3], &[0, 2], RATE), [0, 2]);
    assert_eq!(landings(vec![0.0; 0], &[], RATE), [0; 0]);
}

#[test]
fn toes_leave_when_they_were_slow_for_the_last_time_before_they_are_farthest_behind() {
    const RATE: f64 = 100.0;
    // The ball rests until frame 40, and then rises at 3 m/s. In the second case, the ball rises at 1 m/s, as slowly as
    // in a walk.
    let ball = |speed: f64| -> Vec<DVec3> {
        let height = |frame: i32| speed / RATE * f64::from((frame - 40).max(0));
        (0..80).map(|frame| DVec3::Y * height(frame)).collect()
    };
    // In frame 40 the ball has half of its speed, because the frames on both sides count.
    assert_eq!(leavings(&ball(3.1), &[50], RATE), [39]);
    assert_eq!(leavings(&ball(1.0), &[50], RATE), [50]);
    // The last slow frame of the ball is too long before the rearmost position, also at the end of the motion.
    assert_eq!(leavings(&ball(3.1), &[65, 79], RATE), [65, 79]);
    assert_eq!(leavings(&ball(3.1), &[], RATE), [0; 0]);
}

#[test]
fn a_runner_leaves_the_ground_when_the_knee_is_most_extended() {
    const RATE: f64 = 100.0;
    // The knee is most extended in frame 43, and then bends.
    let flexion: Vec<f64> = (0..80).map(|frame| f64::from((frame - 43_i32).pow(2))).collect();
    assert_eq!(extended(&flexion, 40, RATE), Some(43));
    assert_eq!(extended(&flexion, 47, RATE), Some(43));
    // The knee still extends at the end of the searched frames, bends in all of them, or the motion ends.
    assert_eq!(extended(&flexion, 30, RATE), None);
    assert_eq!(extended(&flexion, 60, RATE), None);
    assert_eq!(extended(&flexion[..44], 40, RATE), None);
    assert_eq!(extended(&[], 0, RATE), None);
}
