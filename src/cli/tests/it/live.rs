//! `mocap record` and `mocap play` against each other.

use std::io::{BufRead, BufReader, Read};
use std::net::UdpSocket;
use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use mocap::Importer;
use mocap::live::VmcMotion;

use crate::cut;
use crate::program::{Folder, command_in};

/// Records the packets of `send` into `output`, and ends the recording by a signal. Returns the messages.
fn recorded(folder: &Folder, output: &str, send: impl FnOnce(&str)) -> String {
    let mut recorder = command_in(&folder.path(""), &format!("record vmc:0 -o {output}"));
    let mut recorder = recorder.stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(recorder.stderr.take().unwrap());
    let mut line = String::new();
    said.read_line(&mut line).unwrap();
    send(line.split(';').next().unwrap().rsplit(':').next().unwrap());
    let pid = i32::try_from(recorder.id()).unwrap();
    let killed = std::process::Command::new("kill")
        .args(["-INT", &pid.to_string()])
        .status();
    assert!(killed.unwrap().success());
    let mut rest = String::new();
    said.read_to_string(&mut rest).unwrap();
    assert!(recorder.wait().unwrap().success(), "{rest}");
    rest
}

/// A jump of the sender's clock by hours loses no data, even in a format with a row for every frame.
#[test]
fn a_take_is_kept_across_a_jump_of_the_senders_clock() {
    const FRAMES: usize = 20;
    let folder = Folder::with(&[]);
    let mut scene = mocap::import("../../fixtures/real/cmu_short.bvh").unwrap();
    mocap::Conversion::new().apply(&mut scene).unwrap();
    let motion = VmcMotion::new(&scene).unwrap();
    let rest = recorded(&folder, "take.bvh", |port| {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        for frame in 0..FRAMES {
            let seconds = frame as f64 / 60.0;
            let clock = if frame < 10 { seconds } else { 7_000.0 + seconds };
            for packet in motion.packets_at(seconds, clock) {
                socket.send_to(&packet, format!("127.0.0.1:{port}")).unwrap();
            }
            sleep(Duration::from_millis(16));
        }
        sleep(Duration::from_millis(100));
    });
    assert!(
        rest.contains("warning[clock-jump]") && rest.contains("jumped forward by"),
        "{rest}"
    );
    assert!(rest.contains(&format!("{FRAMES} frames")), "{rest}");
    let scene = Importer::new().import(folder.path("take.bvh")).unwrap();
    let seconds = scene.animations[0].duration / scene.animations[0].ticks_per_second;
    assert!((0.2..10.0).contains(&seconds), "{seconds}");
}

/// A recording that a signal ends is complete, with every played frame.
#[test]
fn what_is_played_is_recorded_until_a_signal() {
    const FRAMES: usize = 20;
    let folder = Folder::with(&[]);
    folder.write("walk.bvh", cut::first_frames("real/cmu_short.bvh", FRAMES).as_bytes());
    let rest = recorded(&folder, "take.vrma --clean", |port| {
        folder.succeeds(&format!("play walk.bvh --vmc {port}"));
        sleep(Duration::from_millis(100));
        assert!(!folder.path("take.vrma").exists());
    });
    let scene = Importer::new().import(folder.path("take.vrma")).unwrap();
    assert_eq!(scene.animations[0].frame_count(), FRAMES, "{rest}");
    assert!(rest.contains("clean:"), "{rest}");
}

#[test]
fn addresses_and_outputs_are_refused_before_anything_is_heard() {
    let folder = Folder::of_real(&["lecture_Test.bvh"]);
    for (arguments, status, reason) in [
        ("record 39539 -o take.vrma", 2, "not vmc:PORT"),
        ("record vmc:nowhere -o take.vrma", 2, "neither a port nor an address"),
        ("record vmc:70000 -o take.vrma", 2, "neither a port nor an address"),
        ("record vmc:0 -o take.xyz", 2, "must end in"),
        ("record vmc:0 -o lecture_Test.bvh", 1, "would replace a file"),
        (
            "record vmc:0 -o take.vrma --seconds 0",
            1,
            "no humanoid pose was received",
        ),
        ("play lecture_Test.bvh --vmc 127.0.0.1:0", 2, "from 1 to 65535"),
        ("play lecture_Test.bvh --vmc 9", 1, "not-humanoid"),
        (
            "play lecture_Test.bvh --vmc 9 --clean --delay 1",
            2,
            "works only with a stream",
        ),
        ("play lecture_Test.bvh --vmc 9 --delay 1", 2, "--clean"),
        ("play vmc:0 --vmc 9", 2, "requires --clean"),
        ("play vmc:0 --vmc 9 --clean --loop", 2, "does not support --loop"),
        ("play vmc:0 --vmc 9 --clean --delay 11", 2, "from 0 to 10"),
        ("play vmc:9 --vmc 9 --clean", 2, "would receive its own result"),
        ("play vmc:0.0.0.0:9 --vmc 9 --clean", 2, "would receive its own result"),
        (
            "bridge vmc:9 --onto lecture_Test.bvh --vmc 9",
            2,
            "would receive its own result",
        ),
        ("play vmc:nowhere --vmc 9 --clean", 2, "neither a port nor an address"),
        ("bridge vmc:0 --onto lecture_Test.bvh --vmc 9", 1, "not-humanoid"),
        ("bridge vmc:0 --onto lecture_Test.bvh", 2, "--vmc <HOST:PORT>"),
        (
            "bridge vmc:0 --onto lecture_Test.bvh --vmc 9 --udp-json 8",
            2,
            "cannot be used with",
        ),
        ("bridge vmc:0 --onto none.vrm --vmc 9", 1, "none.vrm"),
        ("bridge 39539 --onto lecture_Test.bvh --vmc 9", 2, "not vmc:PORT"),
        ("bridge vmc:0 --onto lecture_Test.bvh --vmc 9 --delay 1", 2, "--clean"),
    ] {
        folder.refuses(arguments, status, reason);
    }
    assert!(!folder.path("take.vrma").exists());
}
