//! Inputs and outputs that are not regular files, and files that change during reading.

#![cfg(unix)]

use std::fs::{self, File, OpenOptions};
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use mocap::{Code, Format, Importer, Limits, SkeletonMesh};

use crate::at_root;
use crate::program::{Folder, command, words};

fn make_fifo(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

#[test]
fn a_pipe_that_a_file_names_is_refused_and_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let beside = |name: &str| folder.path().join(name);
    make_fifo(&beside("walk.asf"));
    fs::copy(at_root("fixtures/made/tiny.amc"), beside("walk_01.amc")).unwrap();
    let error = mocap::import(beside("walk_01.amc")).unwrap_err();
    assert_eq!(error.code(), Code::Io, "{error}");
    assert!(error.to_string().contains("must be a regular file"), "{error}");

    make_fifo(&beside("a.bin"));
    let scene = mocap::import(at_root("fixtures/real/lecture_Test.bvh")).unwrap();
    let written = beside("b.gltf");
    mocap::Exporter::new().export(&scene, &written).unwrap();
    let text = fs::read_to_string(&written).unwrap().replace("b.bin", "a.bin");
    fs::write(beside("a.gltf"), text).unwrap();
    let error = mocap::import(beside("a.gltf")).unwrap_err();
    assert_eq!(error.code(), Code::Io, "{error}");
    assert!(error.to_string().contains("a.bin"), "{error}");
}

#[cfg(target_os = "linux")]
#[test]
fn an_endless_stream_ends_before_it_fills_memory() {
    let error = mocap::import("/dev/zero").unwrap_err();
    assert_eq!(error.code(), Code::UnknownFormat, "{error}");
    let limits = Limits::new().max_bytes(1 << 20);
    let error = Importer::new()
        .format(Format::Bvh)
        .limits(limits)
        .import("/dev/zero")
        .unwrap_err();
    assert_eq!(error.code(), Code::LimitExceeded, "{error}");
    assert_eq!(mocap::import("/dev/null").unwrap_err().code(), Code::UnknownFormat);
}

#[test]
fn a_pipe_is_read_to_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    make_fifo(&pipe);
    for name in ["lecture_Test.bvh", "py_c3d_motion.c3d"] {
        let file = at_root(&format!("fixtures/real/{name}"));
        let expected = mocap::import(&file).unwrap();
        let piped = thread::scope(|scope| {
            scope.spawn(|| fs::write(&pipe, fs::read(&file).unwrap()).unwrap());
            mocap::import(&pipe).unwrap()
        });
        assert_eq!(
            (piped.nodes, piped.animations),
            (expected.nodes, expected.animations),
            "{name}"
        );
    }
}

/// Another program truncates and rewrites a file. Each read gives an error or a scene, and the process continues.
#[test]
fn a_file_that_shrinks_while_it_is_read_is_an_error_or_a_scene() {
    let mut text = String::from("HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n}\nMOTION\n");
    // The file is large, but quick to read: only line breaks follow.
    text += "Frames: 2\nFrame Time: 0.1\n1\n";
    text += &"\n".repeat(6 << 20);
    text += "2\n";
    let file = tempfile::NamedTempFile::with_suffix(".bvh").unwrap();
    fs::write(file.path(), &text).unwrap();
    let is_done = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            while !is_done.load(Ordering::Relaxed) {
                let open = OpenOptions::new().write(true).open(file.path()).unwrap();
                open.set_len(60).unwrap();
                open.set_len(text.len() as u64).unwrap();
                fs::write(file.path(), &text).unwrap();
            }
        });
        let importer = Importer::new().skeleton_mesh(SkeletonMesh::None);
        let mut outcomes = Vec::new();
        for threads in [1, 2, 1, 2, 1, 2] {
            outcomes.push(
                importer
                    .clone()
                    .threads(threads)
                    .import(file.path())
                    .map_err(|error| error.code()),
            );
        }
        is_done.store(true, Ordering::Relaxed);
        assert!(
            outcomes.iter().flatten().all(|scene| scene.nodes.len() <= 1),
            "{outcomes:?}"
        );
    });
}

/// Runs the program with a file as its standard input.
fn mocap_with_input(arguments: &[&str], input: &str) -> Output {
    command(arguments)
        .stdin(Stdio::from(File::open(at_root(&format!("fixtures/{input}"))).unwrap()))
        .output()
        .unwrap()
}

#[test]
fn a_dash_is_standard_input_in_every_command() {
    let walk = "real/lecture_Test.bvh";
    for arguments in [
        &["info", "-"][..],
        &["skeleton", "-"],
        &["dump", "-", "tree"],
        &["pose", "-", "--tick", "1"],
        &["check", "-"],
    ] {
        let named: Vec<_> = arguments
            .iter()
            .map(|argument| {
                if *argument == "-" {
                    "fixtures/real/lecture_Test.bvh"
                } else {
                    argument
                }
            })
            .collect();
        let expected = mocap_with_input(&named, walk);
        let found = mocap_with_input(arguments, walk);
        assert!(found.status.success(), "{arguments:?}: {}", words(&found));
        let text =
            |output: &Output| String::from_utf8_lossy(&output.stdout).replace("fixtures/real/lecture_Test.bvh", "-");
        // Only the name of the input differs.
        assert_eq!(text(&found).trim_start(), text(&expected).trim_start(), "{arguments:?}");
    }
    // Contents that do not determine the format: the first row of an .amc file is arbitrary.
    let motion = mocap_with_input(
        &["info", "-", "--from", "asf-amc", "--skeleton", "fixtures/made/tiny.asf"],
        "made/tiny.amc",
    );
    assert!(motion.status.success(), "{}", words(&motion));
}

#[test]
fn a_dash_is_standard_output_in_every_command_that_writes_one_file() {
    let walk = "real/lecture_Test.bvh";
    let (captured, character) = (
        "fixtures/skeletons/bvhtoolbox_walk01.bvh",
        "fixtures/characters/human_default.glb",
    );
    let cases: [(&[&str], &[u8]); 14] = [
        (&["convert", "-", "-"], b"glTF"),
        (&["convert", "-", "-", "--to", "bvh"], b"HIERARCHY"),
        (&["convert", "-", "-", "--to", "gltf"], b"{\"accessors\""),
        (&["edit", "-", "-o", "-", "--step", "despike"], b"glTF"),
        (
            &["edit", "-", "-o", "-", "--to", "bvh", "--step", "despike"],
            b"HIERARCHY",
        ),
        (&["retarget", captured, character, "-o", "-"], b"glTF"),
        (&["retarget", captured, character, "-o", "-", "--to", "vrma"], b"glTF"),
        (
            &[
                "retarget",
                captured,
                "--to-skeleton",
                captured,
                "-o",
                "-",
                "--to",
                "bvh",
            ],
            b"HIERARCHY",
        ),
        (&["fk", "-", "-o", "-"], b"# {"),
        (&["sheet", "-", "-o", "-"], b"\x89PNG"),
        (&["plot", "-", "--joint", "Elbow", "-o", "-"], b"\x89PNG"),
        (&["gif", "-", "-o", "-", "--width", "64", "--height", "64"], b"GIF89a"),
        (&["view", "-", "-o", "-"], b"<!doctype html>"),
        (
            &[
                "convert",
                "fixtures/real/lecture_Test.bvh",
                "-",
                "--fps",
                "5",
                "--to",
                "bvh",
            ],
            b"HIERARCHY",
        ),
    ];
    for (arguments, beginning) in cases {
        let output = mocap_with_input(arguments, walk);
        assert!(output.status.success(), "{arguments:?}: {}", words(&output));
        let start = &output.stdout[..beginning.len().min(output.stdout.len())];
        assert!(
            start.eq_ignore_ascii_case(beginning),
            "{arguments:?}: {:?}",
            String::from_utf8_lossy(start)
        );
    }
    assert!(!Path::new("-").exists());
    let file = mocap_with_input(&["convert", "fixtures/real/lecture_Test.bvh", "-"], walk).stdout;
    let folder = tempfile::tempdir().unwrap();
    let written = folder.path().join("a.glb");
    let named = ["convert", "fixtures/real/lecture_Test.bvh", written.to_str().unwrap()];
    assert!(mocap_with_input(&named, walk).status.success());
    assert_eq!(file, fs::read(written).unwrap());
    // Standard output gets the bytes that a file would have.
    let written = folder.path().join("moved.glb");
    let retarget = |output| mocap_with_input(&["retarget", captured, character, "-o", output], walk);
    assert!(retarget(written.to_str().unwrap()).status.success());
    assert_eq!(retarget("-").stdout, fs::read(&written).unwrap());
    for refused in [
        &["convert", "-"][..],
        &["convert", "-", "-", "--verify"],
        &["view", "fixtures/made", "-o", "-"],
        &["edit", "-", "-o", "-", "--step", "smooth", "--json"],
        &["retarget", captured, character, "-o", "-", "--to", "gltf"],
        &["retarget", captured, "-", "-o", "-"],
    ] {
        let output = mocap_with_input(refused, walk);
        assert_eq!(output.status.code(), Some(2), "{refused:?}: {}", words(&output));
        assert!(output.stdout.is_empty());
    }
}

/// A job reads and writes streams like the command that printed the job.
#[test]
fn a_dash_in_a_job_is_standard_input_and_output() {
    let walk = "real/cmu_short.bvh";
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("job.json");
    for line in [
        "convert - - --to gltf",
        "edit - -o - --to bvh --step mirror",
        "robot - --robot fixtures/robots/h1.urdf -o - --to csv --fps 10",
    ] {
        let arguments: Vec<&str> = line.split(' ').collect();
        let made = mocap_with_input(&arguments, walk);
        assert!(made.status.success(), "{line}: {}", words(&made));
        let printed = mocap_with_input(&[&arguments[..], &["--print-job"]].concat(), walk);
        fs::write(&job, printed.stdout).unwrap();
        let ran = mocap_with_input(&["run", job.to_str().unwrap()], walk);
        assert!(ran.status.success(), "{line}: {}", words(&ran));
        assert!(ran.stdout == made.stdout && !made.stdout.is_empty(), "{line}");
    }
    // Standard input already has the job.
    let job = command(&["run", "-"])
        .stdin(Stdio::from(File::open(&job).unwrap()))
        .output();
    let job = job.unwrap();
    assert_eq!(job.status.code(), Some(2), "{}", words(&job));
}

#[test]
fn a_pipe_among_many_files_is_a_failed_row() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("a.bvh");
    make_fifo(&pipe);
    let out = folder.path().join("out");
    let names = [pipe.to_str().unwrap(), "fixtures/real/lecture_Test.bvh"];
    for arguments in [vec!["check"], vec!["convert", "-o", out.to_str().unwrap()]] {
        let output = mocap_with_input(&[arguments, names.to_vec()].concat(), "real/lecture_Test.bvh");
        assert_eq!(output.status.code(), Some(3), "{}", words(&output));
    }
    let mut manifest = fs::read_to_string(out.join("mocap-manifest.jsonl")).unwrap();
    manifest.retain(|c| c != '\n');
    assert!(
        manifest.contains("a pipe or a device cannot be one of many files"),
        "{manifest}"
    );
}

/// `/dev/full` acts like a full disk, and nothing reads `/dev/null`.
#[cfg(target_os = "linux")]
#[test]
fn a_device_or_a_pipe_is_an_output_and_no_folder() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.write("robot.urdf", &fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    for command in [
        "convert cmu_short.bvh -o DEVICE",
        "convert cmu_short.bvh DEVICE",
        "convert cmu_short.bvh -o DEVICE --to bvh",
        "edit cmu_short.bvh --step mirror -o DEVICE",
        "clean cmu_short.bvh -o DEVICE",
        "retarget cmu_short.bvh --character cmu_short.bvh -o DEVICE",
        "robot cmu_short.bvh --robot robot.urdf -o DEVICE",
        "fk cmu_short.bvh -o DEVICE",
        "sheet cmu_short.bvh -o DEVICE",
        "survey cmu_short.bvh -o DEVICE",
        "index cmu_short.bvh -o DEVICE",
        "view cmu_short.bvh -o DEVICE",
    ] {
        folder.refuses(
            &command.replace("DEVICE", "/dev/full"),
            1,
            "/dev/full: error[io]: No space left",
        );
        folder.succeeds(&command.replace("DEVICE", "/dev/null"));
    }
    let [device, standard] = ["/dev/stdout", "-"].map(|name| folder.run(&format!("convert cmu_short.bvh -o {name}")));
    assert!(device.stdout.starts_with(b"glTF") && device.stdout == standard.stdout);
    let pipe = folder.path("pipe");
    make_fifo(&pipe);
    let reader = thread::spawn(move || fs::read(pipe).unwrap());
    folder.succeeds("convert cmu_short.bvh -o pipe");
    assert!(reader.join().unwrap() == standard.stdout);
    // `refuses` reads every file of the folder.
    fs::remove_file(folder.path("pipe")).unwrap();
    folder.refuses("convert cmu_short.bvh -o /dev/null --to gltf", 2, "pipe or a device");
    folder.succeeds("convert cmu_short.bvh -o /dev/null --to gltf --embed");
    folder.refuses("convert cmu_short.bvh -o /dev/null --verify", 2, "not a stream");
    folder.refuses(
        "convert cmu_short.bvh robot.urdf -o /dev/null",
        2,
        "need an output folder",
    );
}

/// Every system error names a file, even if the name is empty.
#[test]
fn an_error_of_the_system_names_its_file() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    folder.succeeds("index cmu_short.bvh -o moves.mdb");
    let empty = "error[io]: the name of the file is empty";
    folder.refuses("find moves.mdb --like @0..1", 1, empty);
    folder.write(
        "job.json",
        br#"{"source": {"inputs": [""]}, "write": {"output": "out.glb"}}"#,
    );
    folder.refuses("run job.json", 1, empty);
    for arguments in [
        "info none.x",
        "convert none.x out.glb",
        "verify cmu_short.bvh none.x",
        "retarget cmu_short.bvh none.x -o out.glb",
        "robot cmu_short.bvh --robot none.x -o out.npz",
        "edit cmu_short.bvh --step concat --with none.x -o out.glb",
        "match moves.mdb --on cmu_short.bvh --gamepad none.x -o out.glb",
        "find none.x --like cmu_short.bvh@0..1",
        "graph walk none.x --seconds 1 -o out.glb",
        "run none.x",
        "merge-manifest none.x",
        "mcp --root none.x",
        "sheet cmu_short.bvh -o none.x/out.png",
        "survey cmu_short.bvh -o none.x/out.csv",
    ] {
        folder.refuses(arguments, 1, "none.x");
    }
}
