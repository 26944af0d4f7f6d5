//! Motions on robots, frame by frame as they arrive.

use mocap::retarget::robot::report::RobotReport;
use mocap::retarget::robot::{Robot, RobotMotion, RobotOptions, RobotRetargeter};
use mocap::{Binding, Importer, Pose};

const RATE: f64 = 30.0;

/// A walk at 30 frames per second, for 4 s.
fn walk() -> mocap::Scene {
    let mut source = mocap::import("../../fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let conversion = mocap::Conversion::new().first_frame(mocap::convert::FirstFrame::DropRestPose);
    conversion.frame_rate(RATE).apply(&mut source).unwrap();
    source
}

fn robot(name: &str) -> Robot {
    Importer::new()
        .import_robot(format!("../../fixtures/robots/{name}"))
        .unwrap()
}

/// The frames that a stream returns, the number of frames that it returns at once at its end, and its report.
fn streamed(source: &mocap::Scene, robot: &Robot, options: &RobotOptions) -> (RobotMotion, usize, RobotReport) {
    let retargeter = RobotRetargeter::new(source, robot, options).unwrap();
    let mut stream = retargeter.stream(source, RATE).unwrap();
    let mut parts = Vec::new();
    let (animation, mut pose) = (&source.animations[0], Pose::rest(source));
    let binding = Binding::new(source, animation);
    for frame in 0..animation.frame_count() {
        pose.sample(&binding, animation, frame as f64);
        parts.extend(stream.push(&pose));
    }
    parts.push(stream.finish());
    let left = parts.last().unwrap().frames();
    let mut whole = parts[0].clone();
    for part in &parts[1..] {
        whole.root.extend(&part.root);
        whole.dof_pos.extend(&part.dof_pos);
        whole.contacts.extend(&part.contacts);
    }
    (whole, left, stream.report().unwrap())
}

#[test]
fn what_comes_is_as_the_whole_motion_and_keeps_its_limits() {
    let source = walk();
    let robot = robot("g1_29dof_rev_1_0.urdf");
    let (motion, left, _) = streamed(&source, &robot, &RobotOptions::new());
    let (whole, _) = RobotRetargeter::new(&source, &robot, &RobotOptions::new())
        .unwrap()
        .clip(&source, 0)
        .unwrap();
    assert_eq!(motion.frames(), whole.frames());
    assert_eq!(left, 15 + 3, "0.5 and 0.1 s");
    let apart = motion.dof_pos.iter().zip(&whole.dof_pos).map(|(a, b)| (a - b).abs());
    let apart = apart.sum::<f64>() / motion.dof_pos.len() as f64;
    assert!(apart < 0.06, "{apart} rad");
    for (a, b) in motion.root.iter().zip(&whole.root) {
        assert!(a.translation.distance(b.translation) < 0.06, "{a:?} {b:?}");
    }
    let joints = robot.moving_joints();
    for frame in 0..motion.frames() {
        for (dof, &link) in joints.iter().enumerate() {
            let (limits, at) = (robot.links[link].joint.limits, motion.dof_of(frame)[dof]);
            assert!((limits.lower..=limits.upper).contains(&at), "{frame} {dof} {at}");
            if frame > 0 {
                let velocity = (at - motion.dof_of(frame - 1)[dof]).abs() * RATE;
                assert!(velocity <= limits.velocity.unwrap() + 1e-6, "{frame} {dof} {velocity}");
            }
        }
    }
}

#[test]
fn the_report_of_a_stream_is_of_the_frames_that_it_gave() {
    let (source, robot) = (walk(), robot("h1.urdf"));
    let (motion, _, report) = streamed(&source, &robot, &RobotOptions::new());
    let (_, of_clip) = RobotRetargeter::new(&source, &robot, &RobotOptions::new())
        .unwrap()
        .clip(&source, 0)
        .unwrap();
    assert_eq!((report.frames, report.passes, report.fps), (motion.frames(), 2, RATE));
    assert_eq!(report.clip, source.animations[0].name);
    assert_eq!(report.limit_violations, 0);
    assert!(
        (report.mean_degrees - of_clip.mean_degrees).abs() < 0.5,
        "{report:?} {of_clip:?}"
    );
    // A stream computes the rotations of the source from matrices.
    let source_skate = [&report, &of_clip].map(|report| report.source_skate.unwrap());
    assert!((source_skate[0] - source_skate[1]).abs() < 1e-5, "{source_skate:?}");
    assert_eq!(report.guessed, of_clip.guessed);
    let joints = motion.dof_names.len();
    let steps = motion.dof_pos.iter().zip(&motion.dof_pos[joints..]);
    let fastest = steps.map(|(from, to)| (to - from).abs() * RATE).fold(0.0, f64::max);
    assert!(
        (report.max_velocity - fastest).abs() < 1e-9,
        "{} {fastest}",
        report.max_velocity
    );
    let retargeter = RobotRetargeter::new(&source, &robot, &RobotOptions::new()).unwrap();
    assert_eq!(retargeter.stream(&source, RATE).unwrap().report(), None);
}

#[test]
fn one_pass_comes_sooner_and_rates_that_are_none_are_refused() {
    let source = walk();
    let robot = robot("h1.urdf");
    let (motion, left, _) = streamed(&source, &robot, &RobotOptions::new().passes(1));
    assert_eq!((motion.frames(), left), (source.animations[0].frame_count(), 3));
    for rate in [0.0, -30.0, f64::NAN, f64::INFINITY, 5000.0] {
        let retargeter = RobotRetargeter::new(&source, &robot, &RobotOptions::new()).unwrap();
        let error = retargeter.stream(&source, rate).unwrap_err().to_string();
        assert!(error.contains("from 1 to 1000"), "{error}");
    }
}
