//! Motions that are slowed down to the limits of a robot.

use mocap::Code;
use mocap::edit::{Step, StepInput, Warp};
use mocap::glam::DVec3;
use mocap::retarget::robot::report::{RobotReport, TimeScale};
use mocap::retarget::robot::{Robot, RobotMotion, RobotOptions, RobotRetargeter};
use mocap::retarget::{RetargetOptions, Retargeter};
use mocap::scene::Scene;
use mocap::scene::report::AppliedStep;
use serde_json::json;

use crate::robot_to_robot::robot;
use crate::robot_walk::walk;

fn scaled(source: &Scene, robot: &Robot, scale: TimeScale) -> (RobotMotion, RobotReport) {
    let options = RobotOptions::new().time_scale(scale);
    let mut retargeter = RobotRetargeter::new(source, robot, &options).unwrap();
    retargeter.clip(source, 0).unwrap()
}

/// The robot with other velocity and effort limits.
fn limited(mut robot: Robot, velocity: impl Fn(f64) -> f64, effort: impl Fn(f64) -> Option<f64>) -> Robot {
    for link in robot.moving_joints() {
        let limits = &mut robot.links[link].joint.limits;
        limits.velocity = limits.velocity.map(&velocity);
        limits.effort = limits.effort.and_then(&effort);
    }
    robot
}

/// The largest velocity of a joint as a multiple of its limit, and its name.
fn fastest(robot: &Robot, motion: &RobotMotion) -> (f64, String) {
    let joints = robot.moving_joints();
    let mut found = (0.0, String::new());
    for frame in 1..motion.frames() {
        for (index, link) in joints.iter().enumerate() {
            let joint = &robot.links[*link].joint;
            let step = motion.dof_of(frame)[index] - motion.dof_of(frame - 1)[index];
            let velocity = step.abs() * motion.fps / joint.limits.velocity.unwrap_or(f64::INFINITY);
            if velocity > found.0 {
                found = (velocity, joint.name.clone());
            }
        }
    }
    found
}

/// A smooth curve deviates from its chord by at most an eighth of the second difference.
fn most_from_chord(from: usize, last: usize, at: impl Fn(usize) -> DVec3) -> f64 {
    let bend = |frame: usize| match (1..last).contains(&frame) {
        true => (at(frame + 1) - 2.0 * at(frame) + at(frame - 1)).length(),
        false => 0.0,
    };
    bend(from).max(bend(from + 1)) / 8.0 + 1e-4
}

/// The joints, the base and the feet in contact have the positions of the other motion at `speed` times its speed.
fn assert_same_path(slow: &RobotMotion, fast: &RobotMotion, speed: f64) {
    let last = fast.frames() - 1;
    assert_eq!(slow.frames(), (last as f64 / speed + 1e-6) as usize + 1);
    assert_eq!(slow.fps, fast.fps);
    for frame in 0..slow.frames() {
        let at = (frame as f64 * speed).min(last as f64);
        let (from, part) = ((at as usize).min(last - 1), at - (at as usize).min(last - 1) as f64);
        for (joint, here) in slow.dof_of(frame).iter().enumerate() {
            let [before, after] = [from, from + 1].map(|frame| fast.dof_of(frame)[joint]);
            let there = before + part * (after - before);
            let most = most_from_chord(from, last, |frame| DVec3::X * fast.dof_of(frame)[joint]);
            assert!(
                (here - there).abs() < most,
                "{}: {frame}: {here} {there}",
                slow.dof_names[joint]
            );
        }
        let [before, after] = [from, from + 1].map(|frame| fast.root[frame]);
        let place = before.translation.lerp(after.translation, part);
        let most = most_from_chord(from, last, |frame| fast.root[frame].translation);
        assert!(place.distance(slow.root[frame].translation) < most, "{frame}");
        let turn = before.rotation.slerp(after.rotation, part);
        assert!(turn.angle_between(slow.root[frame].rotation) < 5e-3, "{frame}");
        assert_eq!(slow.contacts[frame], fast.contacts[at.round() as usize], "{frame}");
    }
}

#[test]
fn a_slow_robot_keeps_the_path_of_its_joints() {
    let walk = walk();
    let quick = limited(robot("h1.urdf"), |_| 1e4, |_| None);
    let slow = limited(robot("h1.urdf"), |velocity| 0.2 * velocity, |_| None);
    let (fast, at_full_speed) = scaled(&walk, &quick, TimeScale::default());
    assert_eq!((at_full_speed.time_scale, at_full_speed.slowed_by), (1.0, None));
    let (motion, report) = scaled(&walk, &slow, TimeScale::Auto);
    let (excess, joint) = fastest(&slow, &fast);
    assert!(excess > 1.2, "{excess}");
    assert!(
        (report.time_scale * excess - 1.0).abs() < 1e-3,
        "{} {excess}",
        report.time_scale
    );
    assert_eq!(report.slowed_by.as_ref(), Some(&joint));
    let (after, _) = fastest(&slow, &motion);
    assert!((0.98..=1.0).contains(&after), "{after}");
    assert_eq!((report.fraction_too_fast, report.limit_violations), (0.0, 0));
    assert_same_path(&motion, &fast, report.time_scale);
    assert_eq!(report.frames, motion.frames());
    let text = report.to_string();
    let line = format!("slowed to {:.3} of its speed because of {joint}", report.time_scale);
    assert!(text.contains(&line), "{text}");
    // The poses are as near to the source as with fast joints. Without slowing the motion down they are not.
    assert!((report.mean_degrees - at_full_speed.mean_degrees).abs() < 0.05);
    let (_, clipped) = scaled(&walk, &slow, TimeScale::default());
    assert!(
        clipped.mean_degrees > report.mean_degrees + 0.5,
        "{}",
        clipped.mean_degrees
    );
}

#[test]
fn a_quick_robot_keeps_the_speed() {
    let (walk, robot) = (walk(), robot("g1_29dof_rev_1_0.urdf"));
    let quick = limited(robot, |_| 1e4, |_| Some(1e6));
    let [(auto, report), (fast, other)] =
        [TimeScale::Auto, TimeScale::default()].map(|scale| scaled(&walk, &quick, scale));
    assert_eq!((auto, report.time_scale, &report.slowed_by), (fast, 1.0, &None));
    assert_eq!(report, other);
}

/// A factor sets the speed of every robot. Joints use the additional time.
#[test]
fn a_factor_sets_the_speed() {
    let (walk, h1) = (walk(), robot("h1.urdf"));
    let (fast, _) = scaled(&walk, &limited(h1.clone(), |_| 1e4, |_| None), TimeScale::default());
    let (slow, report) = scaled(&walk, &limited(h1.clone(), |_| 1e4, |_| None), TimeScale::Factor(0.8));
    assert_same_path(&slow, &fast, 0.8);
    assert_eq!((report.time_scale, report.slowed_by), (0.8, None));
    // At full speed, a joint would be 1.5 times too fast.
    let part = fastest(&h1, &fast).0 / 1.5;
    let tight = limited(h1, |velocity| part * velocity, |_| None);
    let (half, report) = scaled(&walk, &tight, TimeScale::Factor(0.5));
    assert_same_path(&half, &fast, 0.5);
    assert_eq!(report.fraction_too_fast, 0.0);
    for factor in [0.0, -1.0, f64::NAN] {
        let options = RobotOptions::new().time_scale(TimeScale::Factor(factor));
        let error = RobotRetargeter::new(&walk, &tight, &options).unwrap_err();
        assert_eq!(error.diagnostic().code, Code::InvalidValue, "{factor}");
    }
    let options = RobotOptions::new().time_scale(TimeScale::Factor(1e-9));
    let error = RobotRetargeter::new(&walk, &tight, &options).unwrap().clip(&walk, 0);
    assert_eq!(error.unwrap_err().diagnostic().code, Code::LimitExceeded);
}

/// No joint of a slower motion is too fast. A motion that would have to be far slower is refused with its speed.
#[test]
fn the_speed_has_a_lower_bound() {
    let walk = walk();
    let quick = limited(robot("h1.urdf"), |_| 1e4, |_| None);
    let (fast, _) = scaled(&walk, &quick, TimeScale::default());
    let of_all = |velocity: f64| limited(robot("h1.urdf"), |_| velocity, |_| None);
    let (most, joint) = fastest(&of_all(1.0), &fast);
    let (_, report) = scaled(&walk, &of_all(0.07 * most), TimeScale::Auto);
    assert!((report.time_scale - 0.07).abs() < 1e-4, "{}", report.time_scale);
    assert_eq!(report.fraction_too_fast, 0.0);
    let options = RobotOptions::new().time_scale(TimeScale::Auto);
    let mut snail = RobotRetargeter::new(&walk, &of_all(0.0123456 * most), &options).unwrap();
    let error = snail.clip(&walk, 0).unwrap_err();
    assert_eq!(error.diagnostic().code, Code::LimitExceeded);
    let said = error.to_string();
    assert!(
        said.contains(&format!("{joint} needs ")) && said.contains(" 0.0123, "),
        "{said}"
    );
}

/// A wrist that is too slow lags behind. All other joints keep their speed and their path.
#[test]
fn a_slow_wrist_does_not_slow_the_walk() {
    let walk = walk();
    let quick = limited(robot("g1_29dof_rev_1_0.urdf"), |_| 1e4, |_| None);
    let (fast, _) = scaled(&walk, &quick, TimeScale::Auto);
    let wrist = fast
        .dof_names
        .iter()
        .position(|name| name == "left_wrist_yaw_joint")
        .unwrap();
    let steps = (1..fast.frames()).map(|frame| (fast.dof_of(frame)[wrist] - fast.dof_of(frame - 1)[wrist]).abs());
    let most = steps.fold(0.0, f64::max) * fast.fps;
    let mut slow = quick.clone();
    let link = slow.moving_joints()[wrist];
    slow.links[link].joint.limits.velocity = Some(0.3 * most);
    let (motion, report) = scaled(&walk, &slow, TimeScale::Auto);
    assert_eq!((report.time_scale, report.slowed_by.as_ref()), (1.0, None));
    assert_eq!(
        (report.lagging.as_slice(), report.fraction_too_fast),
        (&[fast.dof_names[wrist].clone()][..], 0.0)
    );
    let (after, _) = fastest(&slow, &motion);
    assert!((0.9..=1.0 + 1e-9).contains(&after), "{after}");
    for frame in 0..fast.frames() {
        for (joint, (here, there)) in std::iter::zip(motion.dof_of(frame), fast.dof_of(frame)).enumerate() {
            assert!(
                joint == wrist || (here - there).abs() < 1e-9,
                "{frame}: {}",
                fast.dof_names[joint]
            );
        }
    }
    assert!(report.to_string().contains("lagging: left_wrist_yaw_joint"), "{report}");
}

/// A motion needs two frames.
#[test]
fn a_factor_leaves_more_than_one_frame() {
    let (walk, robot) = (walk(), robot("h1.urdf"));
    let last = walk.animations[0].frame_count() - 1;
    let with = |factor: usize| {
        let options = RobotOptions::new().time_scale(TimeScale::Factor(factor as f64));
        RobotRetargeter::new(&walk, &robot, &options).unwrap().clip(&walk, 0)
    };
    assert_eq!(with(last).unwrap().0.frames(), 2);
    let error = with(last + 1).unwrap_err();
    assert_eq!(error.diagnostic().code, Code::InvalidValue);
    let said = error.to_string();
    assert!(said.contains(&format!("leaves one of {} frames", last + 1)), "{said}");
    assert!(said.contains(&format!("a factor of at most {last}")), "{said}");
}

/// Without limits, no motion on a robot needs to be slower.
#[test]
fn auto_needs_limits() {
    let mut free = robot("h1.urdf");
    for link in &mut free.links {
        (link.joint.limits.velocity, link.joint.limits.effort) = (None, None);
    }
    let options = RobotOptions::new().time_scale(TimeScale::Auto);
    let error = RobotRetargeter::new(&walk(), &free, &options).unwrap_err();
    assert_eq!(error.diagnostic().code, Code::InvalidValue);
    assert!(
        error.to_string().contains("the file of h1_description has none"),
        "{error}"
    );
}

/// Arms that are too weak only for a fast walk slow the motion down. Arms that are too weak even to hang do not.
#[test]
fn efforts_slow_a_motion_down_if_that_helps() {
    let mut walk = walk();
    Warp::Speed(2.0).apply(&mut walk, &StepInput::new()).unwrap();
    let with = |effort: f64| {
        let mut robot = limited(robot("h1.urdf"), |_| 1e4, |_| Some(1e6));
        for link in robot.moving_joints() {
            let joint = &mut robot.links[link].joint;
            if joint.name.contains("shoulder") || joint.name.contains("elbow") {
                joint.limits.effort = Some(effort);
            }
        }
        let (_, report) = scaled(&walk, &robot, TimeScale::Auto);
        let over = report.dynamics.as_ref().unwrap().fraction_over_effort.unwrap();
        (report.time_scale, report.slowed_by, over)
    };
    let found = [0.5, 2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0, 1e3].map(with);
    let (weak, strong) = (&found[0], &found[found.len() - 1]);
    assert!(weak.0 == 1.0 && weak.1.is_none() && weak.2 > 0.01, "{weak:?}");
    assert_eq!((strong.0, &strong.1, strong.2), (1.0, &None, 0.0));
    let slowed: Vec<_> = found.iter().filter(|(speed, _, _)| *speed < 1.0).collect();
    assert!(!slowed.is_empty());
    for (speed, joint, over) in slowed {
        let joint = joint.as_ref().unwrap();
        assert!(
            *speed >= 0.25 && (joint.contains("shoulder") || joint.contains("elbow")),
            "{joint}"
        );
        assert!(*over <= 0.01, "{speed}: {over}");
    }
}

/// The steps of the output say how the speed changed.
#[test]
fn a_file_records_the_change_of_speed() {
    let walk = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    let options = RetargetOptions::new().time_scale(TimeScale::Factor(0.5));
    let made = Retargeter::new(walk, robot("h1.urdf"), options).unwrap();
    let clip = &made.clips()[0];
    let motion = clip.robot_motion.as_ref().unwrap();
    assert_eq!(clip.animation.frame_count(), motion.frames());
    assert_eq!(made.limb_angles(0).unwrap()[0].degrees.len(), motion.frames());
    let [.., AppliedStep::Edit { edit, .. }, AppliedStep::Retarget { .. }] = &clip.provenance.steps[..] else {
        panic!("{:?}", clip.provenance.steps);
    };
    assert_eq!(edit.0, json!({"step": "warp", "speed": 0.5}));
}
