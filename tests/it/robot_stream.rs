//! Motions on robots while they come.

use mocap::robot::{Robot, RobotMotion, RobotOptions, RobotReport, RobotRetargeter};
use mocap::{Binding, Importer, Pose};

const RATE: f64 = 30.0;

/// A walk at 30 frames a second, for 4 s.
fn walk() -> mocap::Scene {
    let mut source = mocap::import("fixtures/real/cmu_12_01_walk.bvh").unwrap();
    let conversion = mocap::Conversion::new().first_frame(mocap::convert::FirstFrame::DropRestPose);
    conversion.frame_rate(RATE).apply(&mut source).unwrap();
    source
}

fn robot(name: &str) -> Robot {
    Importer::new().import_robot(format!("fixtures/robots/{name}")).unwrap()
}

/// The frames that a stream gives, with how many came together at its end, and its report.
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
    // A stream has the rotations of the source from matrices.
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

#[cfg(all(unix, feature = "cli"))]
mod program {
    use std::io::{BufRead, BufReader, Read};
    use std::process::Stdio;

    use crate::cut;
    use crate::program::{Folder, command_in};

    const FRAMES: usize = 40;

    fn folder() -> Folder {
        let folder = Folder::with(&[]);
        folder.write("walk.bvh", cut::first_frames("real/cmu_short.bvh", FRAMES).as_bytes());
        folder.write("h1.urdf", &std::fs::read("fixtures/robots/h1.urdf").unwrap());
        folder
    }

    /// A row for each frame: place and rotation of the base, and 19 joints.
    fn check_rows(text: &str, frames: usize) {
        assert_eq!(text.lines().count(), frames, "{text}");
        for row in text.lines() {
            let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
            assert_eq!(numbers.len(), 7 + 19);
            let length = numbers[3..7].iter().map(|part| part * part).sum::<f64>().sqrt();
            assert!((length - 1.0).abs() < 1e-4, "{row}");
            assert!((0.5..1.5).contains(&numbers[2]), "{row}");
        }
    }

    #[test]
    fn a_file_is_played_on_a_robot() {
        let folder = folder();
        let done = command_in(&folder.path(""), "play walk.bvh --robot h1.urdf")
            .output()
            .unwrap();
        let said = String::from_utf8(done.stderr).unwrap();
        assert!(done.status.success(), "{said}");
        // The first frame is a rest pose.
        check_rows(&String::from_utf8(done.stdout).unwrap(), FRAMES - 1);
        assert!(said.contains("left_knee_joint"), "{said}");
        assert!(
            said.contains("the last 0.3 s: ") && said.contains("degrees off in the mean"),
            "{said}"
        );
        for (arguments, status, reason) in [
            ("play walk.bvh", 2, "--vmc"),
            ("play walk.bvh --robot h1.urdf --vmc 9", 2, "cannot be used with"),
            ("play walk.bvh --robot h1.urdf --loop", 2, "--loop is for --vmc"),
            ("play walk.bvh --robot walk.bvh", 1, "walk.bvh"),
            ("play vmc:0 --robot h1.urdf --rate 30", 2, "without --loop and --rate"),
        ] {
            folder.refuses(arguments, status, reason);
        }
    }

    #[test]
    fn a_stream_goes_on_a_robot_until_a_signal() {
        let folder = folder();
        let mut player = command_in(&folder.path(""), "play vmc:0 --robot h1.urdf");
        let mut player = player.stderr(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(player.stderr.take().unwrap());
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        let port = line.split(';').next().unwrap().rsplit(':').next().unwrap().to_owned();
        folder.succeeds(&format!("play walk.bvh --vmc {port}"));
        std::thread::sleep(std::time::Duration::from_millis(500));
        let pid = player.id().to_string();
        let killed = std::process::Command::new("kill").args(["-INT", &pid]).status();
        assert!(killed.unwrap().success());
        let (mut rows, mut rest) = (String::new(), String::new());
        player.stdout.take().unwrap().read_to_string(&mut rows).unwrap();
        said.read_to_string(&mut rest).unwrap();
        assert!(player.wait().unwrap().success(), "{rest}");
        // A frame ends as the next begins.
        check_rows(&rows, FRAMES - 1);
    }
}
