//! `mocap convert` and `mocap verify` from the outside: exit codes, outputs, and leftover files.

use std::path::{Path, PathBuf};
use std::process::Output;

use crate::at_root;
use crate::program::{Folder, run, words};

fn fixture(file: &str) -> String {
    at_root(&format!("fixtures/real/{file}"))
}

/// Runs `mocap convert` into a new folder.
fn convert(file: &str, options: &[&str]) -> (tempfile::TempDir, PathBuf, Output) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    let input = fixture(file);
    let arguments = [&["convert", &input, path.to_str().unwrap()], options].concat();
    let output = run(&arguments);
    (folder, path, output)
}

fn extras(path: &Path) -> serde_json::Value {
    let file = gltf::Gltf::open(path).unwrap();
    let extras = file.document.as_json().asset.extras.as_ref().unwrap();
    serde_json::from_str::<serde_json::Value>(extras.get()).unwrap()["mocap"].clone()
}

#[test]
fn a_converted_file_verifies_and_says_how_it_was_made() {
    let (_folder, path, output) = convert(
        "cmu_short.bvh",
        &["--verify", "--compress", "none", "--max-error", "0.02mm"],
    );
    assert!(output.status.success(), "{}", words(&output));
    assert!(output.stdout.is_empty(), "words go to standard error");
    for said in [
        "unit: cmu, because",
        "up: y, because",
        "--drop-first-frame",
        "75 frames, 31 joints, 7 end sites:",
    ] {
        assert!(words(&output).contains(said), "{said} is not in {}", words(&output));
    }
    let extras = extras(&path);
    assert_eq!(extras["source"]["name"], "cmu_short.bvh");
    // As `sha256sum` prints it.
    let sum = "2a71be7a288068df60b2f8a81a5d3505275b34eb3d9a6f32563f79e417e46f9a";
    assert_eq!(extras["source"]["sha256"], sum);
    assert_eq!(
        (&extras["frames"], &extras["source"]["frames"]),
        (&75.into(), &75.into())
    );
    assert_eq!(extras["frame_time"], 0.0083333);
    assert_eq!(extras["root_offset"]["policy"], "replace");
    let assumptions = extras["assumptions"].as_array().unwrap();
    for topic in ["unit", "up", "facing", "rest-pose", "sides", "humanoid"] {
        let one = assumptions.iter().find(|one| one["topic"] == topic).unwrap();
        assert!(one["confidence"] == "sure" || one["confidence"] == "likely", "{one}");
        assert!(one["choice"].is_string() && one["reason"].is_string(), "{one}");
    }
    assert_eq!(extras["steps"][0]["step"], "convert_units");
    assert_eq!(extras["steps"][0]["metres_per_unit"], 0.0254 / 0.45);

    let verdict = run(&["verify", &fixture("cmu_short.bvh"), path.to_str().unwrap(), "--json"]);
    assert!(verdict.status.success());
    let verdict: serde_json::Value = serde_json::from_slice(&verdict.stdout).unwrap();
    assert_eq!(
        (
            &verdict["ok"],
            &verdict["frames"],
            &verdict["joints"],
            &verdict["end_sites"]
        ),
        (&true.into(), &75.into(), &31.into(), &7.into())
    );
    assert!(verdict["max_error"].as_f64().unwrap() < 2e-5);
}

#[test]
fn what_a_reader_assumed_or_left_out_is_said() {
    let (_folder, _, output) = convert("cmu_02_01.amc", &[]);
    let said = words(&output);
    assert!(
        said.starts_with("unit: a unit of length is 0.05644 m, because the skeleton states"),
        "{said}"
    );
    assert!(said.contains("\nframe-rate: 120 frames a second, because"), "{said}");
    let (_folder, path, output) = convert("cmu_02_01.amc", &["--fps", "60"]);
    assert!(!words(&output).contains("frame-rate"), "{}", words(&output));
    assert_eq!(
        (&extras(&path)["frames"], &extras(&path)["frame_time"]),
        (&343.into(), &(1.0 / 60.0).into())
    );
    let (_folder, _, output) = convert("py_c3d_motion.c3d", &[]);
    assert!(
        words(&output).contains("2 force plates are not in the output") && !words(&output).contains("analog:"),
        "{}",
        words(&output)
    );
}

#[test]
fn options_change_the_file_and_verify_knows() {
    let cases: [(&[&str], u64); 6] = [
        (&["--unit", "1", "--up", "z"], 75),
        (&["--trim", "10f..20f", "--in-place"], 11),
        (&["--trim", "0.25.."], 45),
        (&["--drop-first-frame", "auto", "--root-motion"], 74),
        (&["--rest", "frame:5", "--mesh", "segmented", "--keep-constant"], 75),
        (&["--mesh", "none", "--drop-first-frame", "yes", "--trim", "..30f"], 30),
    ];
    for (options, frames) in cases {
        let (_folder, path, output) = convert("cmu_short.bvh", options);
        assert!(output.status.success(), "{options:?}: {}", words(&output));
        assert_eq!(extras(&path)["frames"], frames, "{options:?}");
        let verdict = run(&["verify", &fixture("cmu_short.bvh"), path.to_str().unwrap(), "--json"]);
        let verdict: serde_json::Value = serde_json::from_slice(&verdict.stdout).unwrap();
        assert_eq!(verdict["frames"], frames, "{options:?}");
        assert!(verdict["max_error"].as_f64().unwrap() < 3e-5, "{options:?}: {verdict}");
    }
}

#[test]
fn frames_that_the_motion_does_not_have_are_refused() {
    // The file has 75 frames, the last at 0.617 seconds.
    let cases = [
        (["--trim", "75f.."], "the part to keep begins after the last frame"),
        (["--trim", "2..3"], "the part to keep begins after the last frame"),
        (["--trim", "0.5..0.25"], "the part to keep ends before it begins"),
        (["--trim", "0.5..30f"], "the part to keep ends before it begins"),
        (
            ["--rest", "frame:75"],
            "the frame of the rest pose is after the last frame",
        ),
    ];
    for (options, message) in cases {
        let (_folder, path, output) = convert("cmu_short.bvh", &options);
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        assert!(words(&output).contains(message), "{}", words(&output));
        assert!(!path.exists());
    }
    let (_folder, path, _) = convert("cmu_short.bvh", &["--trim", "74f..900f", "--rest", "frame:74"]);
    assert_eq!(extras(&path)["frames"], 1);
}

/// The error about a frame time names `--retime`, so every command that can report it has this option.
#[test]
fn every_command_takes_the_rate_that_the_error_asks_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let text = std::fs::read_to_string(fixture("lecture_Test.bvh")).unwrap();
    let timeless: Vec<_> = text
        .lines()
        .map(|line| {
            if line.starts_with("Frame Time") {
                "Frame Time: 0"
            } else {
                line
            }
        })
        .collect();
    let input = path("timeless.bvh");
    std::fs::write(&input, timeless.join("\n")).unwrap();
    let to = |name: &str| vec!["-o".to_owned(), path(name)];
    let commands = [
        ("info", vec![]),
        ("check", vec![]),
        ("dump", vec![]),
        ("pose", vec!["--tick".to_owned(), "1".to_owned()]),
        ("convert", vec![path("out.glb")]),
        ("fk", to("out.csv")),
        ("view", to("out.html")),
        ("sheet", to("out.svg")),
        ("gif", to("out.gif")),
        (
            "plot",
            [to("curves.svg"), vec!["--joint".to_owned(), "Elbow".to_owned()]].concat(),
        ),
    ];
    for (command, options) in commands {
        let options: Vec<_> = options.iter().map(String::as_str).collect();
        let run = |more: &[&str]| run(&[&[command, input.as_str()], options.as_slice(), more].concat());
        let refused = run(&[]);
        assert_eq!(refused.status.code(), Some(1), "{command}");
        // `check` reports problems on standard output, because they are its result.
        let said = words(&refused) + &String::from_utf8_lossy(&refused.stdout);
        assert!(said.contains("--retime 30"), "{command}: {said}");
        let read = run(&["--retime", "30"]);
        assert!(read.status.success(), "{command}: {}", words(&read));
    }
}

#[test]
fn another_frame_rate_keeps_the_jump_and_says_what_it_lost() {
    let (_folder, path, output) = convert("cmu_short.bvh", &["--fps", "10", "--verify"]);
    assert!(output.status.success(), "{}", words(&output));
    assert!(words(&output).contains("loss by resampling: "), "{}", words(&output));
    let animation = gltf::Gltf::open(&path).unwrap();
    let input = animation
        .document
        .animations()
        .next()
        .unwrap()
        .samplers()
        .next()
        .unwrap()
        .input();
    // Frames at 0, 0.1, ..., 0.6 seconds, and frame 1 of the file: where the motion begins after the T-pose.
    assert_eq!(input.count(), 8);
}

#[test]
fn a_largest_error_makes_a_file_smaller_and_says_how_far_it_is() {
    let (_folder, plain, _) = convert("cmu_short.bvh", &[]);
    let (_other, path, output) = convert("cmu_short.bvh", &["--max-error", "1mm", "--verify"]);
    assert!(output.status.success(), "{}", words(&output));
    for said in [
        "compress: int16",
        "mm at most,",
        "times smaller than the",
        "75 frames, 31 joints, 7 end sites:",
    ] {
        assert!(words(&output).contains(said), "{said} is not in {}", words(&output));
    }
    // Reads the keys and the mesh after the JSON, whose length is in its first word.
    let size = |path: &Path| {
        let glb = std::fs::read(path).unwrap();
        let json = u32::from_le_bytes(glb[12..16].try_into().unwrap());
        glb.len() - 20 - json as usize
    };
    assert!(
        size(&path) < size(&plain) * 2 / 3,
        "{} of {}",
        size(&path),
        size(&plain)
    );
    let (_third, _, output) = convert("cmu_short.bvh", &["--compress", "int16"]);
    assert!(
        words(&output).contains("max-error: 1.0000 mm, the default"),
        "{}",
        words(&output)
    );
}

#[test]
fn a_largest_error_that_cannot_be_kept_leaves_no_output() {
    let (_folder, path, output) = convert("cmu_short.bvh", &["--max-error", "0.00001mm"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(words(&output).contains("error[error-bound]"), "{}", words(&output));
    assert!(!path.exists());
}

#[test]
fn a_folder_has_what_each_file_reached_in_its_manifest() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let (first, second) = (fixture("cmu_short.bvh"), fixture("lecture_Test.bvh"));
    let output = run(&[
        "convert",
        &first,
        &second,
        "-o",
        out.to_str().unwrap(),
        "--max-error",
        "2mm",
    ]);
    assert!(output.status.success(), "{}", words(&output));
    let manifest = std::fs::read_to_string(out.join("mocap-manifest.jsonl")).unwrap();
    for line in manifest.lines() {
        let record: serde_json::Value = serde_json::from_str(line).unwrap();
        let reached = record["max_error"].as_f64().unwrap();
        assert!(0.0 < reached && reached <= 0.002, "{record}");
    }
    assert_eq!(manifest.lines().count(), 2);
}

#[test]
fn bvh_has_no_compression() {
    for option in [["--max-error", "1mm"], ["--compress", "int16"]] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.bvh");
        let arguments = [
            "convert",
            &fixture("cmu_short.bvh"),
            path.to_str().unwrap(),
            option[0],
            option[1],
        ];
        let output = run(&arguments);
        assert_eq!(output.status.code(), Some(2), "{}", words(&output));
        assert!(!path.exists());
    }
}

#[test]
fn a_broken_file_leaves_no_output_and_an_older_one_in_peace() {
    let folder = tempfile::tempdir().unwrap();
    let [broken, output] = ["broken.bvh", "broken.glb"].map(|name| folder.path().join(name));
    let text = std::fs::read_to_string(fixture("lecture_Test.bvh")).unwrap();
    std::fs::write(&broken, text.replacen("OFFSET", "OFFSET x", 1)).unwrap();
    let run = || run(&["convert", broken.to_str().unwrap()]);
    assert_eq!(run().status.code(), Some(1));
    assert!(words(&run()).contains("error[invalid-number]"));
    assert!(!output.exists());
    std::fs::write(&output, "older").unwrap();
    run();
    assert_eq!(std::fs::read_to_string(&output).unwrap(), "older");
    assert_eq!(folder.path().read_dir().unwrap().count(), 2, "nothing else is left");
}

#[test]
fn verify_fails_on_the_wrong_source() {
    let (_folder, path, _) = convert("cmu_short.bvh", &[]);
    let path = path.to_str().unwrap();
    let far = run(&["verify", &fixture("cmu_12_01_walk.bvh"), path]);
    assert_eq!(far.status.code(), Some(1));
    assert!(words(&far).contains("it was made from another file"), "{}", words(&far));
    let strange = run(&["verify", &fixture("lecture_Test.bvh"), path]);
    assert_eq!(strange.status.code(), Some(1));
    assert!(words(&strange).contains("no joint"), "{}", words(&strange));
}

#[test]
fn what_no_option_means_is_wrong_usage() {
    for options in [
        ["--unit", "furlong"],
        ["--unit", "-1"],
        ["--trim", "5"],
        ["--trim", "1..x"],
        ["--rest", "frame"],
        ["--fps", "0"],
        ["--up", "x"],
        ["--max-error", "1inch"],
        ["--max-error", "-1mm"],
        ["--compress", "zip"],
    ] {
        let (_folder, path, output) = convert("lecture_Test.bvh", &options);
        assert_eq!(output.status.code(), Some(2), "{options:?}");
        assert!(!path.exists());
    }
}

#[test]
fn a_rate_that_the_file_does_not_state_is_taken_from_the_option() {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("still.bvh");
    let text = std::fs::read_to_string(fixture("lecture_Test.bvh")).unwrap();
    assert!(text.contains("Frame Time: .1"));
    std::fs::write(&input, text.replace("Frame Time: .1", "Frame Time: 0")).unwrap();
    let input = input.to_str().unwrap();
    assert_eq!(run(&["convert", input]).status.code(), Some(1));
    let output = run(&["convert", input, "--fps", "20", "--verify"]);
    assert!(output.status.success(), "{}", words(&output));
    assert_eq!(extras(&folder.path().join("still.glb"))["frames"], 10);
}

#[test]
fn written_files_can_be_looked_into() {
    let (_folder, path, _) = convert("cmu_short.bvh", &[]);
    let info = run(&["info", path.to_str().unwrap(), "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    for (field, value) in [("nodes", 38), ("joints", 31), ("end_sites", 7), ("frames", 75)] {
        assert_eq!(info[field], value, "{field}");
    }
    assert_eq!(info["format"], "gltf");
    assert!(
        run(&["pose", path.to_str().unwrap(), "--tick", "3", "--json"])
            .status
            .success()
    );
    assert!(run(&["dump", path.to_str().unwrap(), "tree"]).status.success());
}

#[test]
fn arrays_are_outputs_like_any_other() {
    let folder = Folder::with(&["other.bvh", "takes/b.bvh"]);
    folder.write(
        "robot.urdf",
        &std::fs::read(at_root("fixtures/robots/h1.urdf")).unwrap(),
    );
    folder.succeeds("convert takes/b.bvh b.npz --verify --trim 0..0.2 --fps 60");
    let verified = String::from_utf8(folder.run("verify takes/b.bvh b.npz").stdout).unwrap();
    assert!(verified.contains("13 frames, 31 joints, 7 end sites"), "{verified}");
    folder.succeeds("convert takes -o out --to amass --trim 0..0.2");
    assert_eq!(folder.records("out")[0]["output"], "b.npz");
    let found: serde_json::Value = serde_json::from_slice(&folder.run("info out/b.npz --json").stdout).unwrap();
    assert_eq!((&found["joints"], &found["frames"]), (&55.into(), &25.into()));
    folder.succeeds("edit takes/b.bvh -o mirrored.csv --step mirror");
    folder.succeeds("robot takes --robot robot.urdf -o robots/ --to gmr --trim 0..0.2");
    folder.succeeds("convert robots/b.pkl b.csv --to unitree-csv --body robot.urdf");
    // 24 frames at 120 frames per second, without the initial rest pose, become 6 frames at 30.
    assert_eq!(folder.read("b.csv").split(|byte| *byte == b'\n').count() - 1, 6);
    for (arguments, said) in [
        ("convert takes/b.bvh c.npz --to npz", "--to would do nothing"),
        ("convert takes/b.bvh c.csv --to amass", "must end in .npz"),
        ("convert takes/b.bvh c.pkl", "name this robot in --body"),
        (
            "convert takes/b.bvh c.npz --to amass --verify",
            "--verify compares joints by their names",
        ),
        ("convert takes other.bvh -o c.npz", "need an output folder"),
    ] {
        folder.refuses(arguments, 2, said);
    }
}
