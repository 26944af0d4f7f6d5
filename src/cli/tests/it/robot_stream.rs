//! `mocap play --robot`: a file, and a stream that ends by a signal.

use std::io::{BufRead, BufReader, Read};
use std::process::Stdio;

use crate::at_root;
use crate::cut;
use crate::program::{Folder, command_in};

const FRAMES: usize = 40;

fn folder() -> Folder {
    let folder = Folder::with(&[]);
    folder.write("walk.bvh", cut::first_frames("real/cmu_short.bvh", FRAMES).as_bytes());
    folder.write("h1.urdf", &std::fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    folder
}

/// A row for each frame: position and rotation of the base, and 19 joints.
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
        said.contains("the last 0.3 s: ") && said.contains("mean limb error"),
        "{said}"
    );
    for (arguments, status, reason) in [
        ("play walk.bvh", 2, "--vmc"),
        ("play walk.bvh --robot h1.urdf --vmc 9", 2, "cannot be used with"),
        ("play walk.bvh --robot h1.urdf --loop", 2, "--loop is for --vmc"),
        ("play walk.bvh --robot walk.bvh", 1, "walk.bvh"),
        (
            "play vmc:0 --robot h1.urdf --rate 30",
            2,
            "does not support --loop and --rate",
        ),
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
    // A frame ends when the next begins.
    check_rows(&rows, FRAMES - 1);
}
