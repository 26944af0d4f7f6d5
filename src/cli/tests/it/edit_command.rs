//! `mocap edit`: applies steps in order, records them in the file, and `verify` repeats them.

use std::path::{Path, PathBuf};

use mocap::edit::EditStep;

use crate::at_root;
use crate::program::{command, run, words};

fn real(file: &str) -> String {
    at_root(&format!("fixtures/real/{file}"))
}

fn folder() -> (tempfile::TempDir, impl Fn(&str) -> String) {
    let folder = tempfile::tempdir().unwrap();
    let root: PathBuf = folder.path().to_owned();
    (folder, move |name: &str| root.join(name).to_str().unwrap().to_owned())
}

#[test]
fn steps_are_recorded_and_verified() {
    let (_folder, path) = folder();
    let (walk, output, contacts) = (real("cmu_12_01_walk.bvh"), path("walk.glb"), path("contacts.json"));
    let found = run(&[
        "edit",
        &walk,
        "-o",
        &output,
        "--step",
        "foot-lock:speed=0.3",
        "--step",
        "smooth:cut-off=20",
        "--step",
        "mirror",
        "--contacts",
        &contacts,
        "--json",
    ]);
    assert!(found.status.success(), "{}", words(&found));
    let reports: serde_json::Value = serde_json::from_slice(&found.stdout).unwrap();
    let steps: Vec<&str> = reports
        .as_array()
        .unwrap()
        .iter()
        .map(|report| report["step"].as_str().unwrap())
        .collect();
    assert!(
        steps[0].starts_with("foot-lock:blend=0.2,") && steps[0].contains("speed=0.3"),
        "{steps:?}"
    );
    assert_eq!(
        steps[1..],
        ["smooth:cut-off=20.0,ease=0.2,filter=butterworth,range=..", "mirror"]
    );
    assert!(reports[0]["changed"]["slide_after"].as_f64() < reports[0]["changed"]["slide_before"].as_f64());

    // The file records its steps with all values.
    let bytes = std::fs::read(&output).unwrap();
    for step in &steps {
        let step: EditStep = step.parse().unwrap();
        let recorded = serde_json::to_value(&step).unwrap().to_string();
        assert!(
            bytes.windows(recorded.len()).any(|part| part == recorded.as_bytes()),
            "{recorded}"
        );
    }

    let verified = run(&["verify", &walk, &output, "--max-error", "0.01mm"]);
    assert!(verified.status.success(), "{}", words(&verified));
    let points: serde_json::Value = serde_json::from_slice(&std::fs::read(&contacts).unwrap()).unwrap();
    assert_eq!(points["points"].as_array().unwrap().len(), 6);

    // Other steps give another motion.
    let other = path("other.glb");
    assert!(
        run(&["edit", &walk, "-o", &other, "--step", "smooth:cut-off=2"])
            .status
            .success()
    );
    let one = mocap::import(&other).unwrap();
    let mut scene = mocap::import(&walk).unwrap();
    mocap::Conversion::new()
        .first_frame(mocap::convert::FirstFrame::DropRestPose)
        .apply(&mut scene)
        .unwrap();
    assert_ne!(
        one.animations[0].channels[5].rotation_keys.values[100],
        scene.animations[0].channels[5].rotation_keys.values[100]
    );
}

#[test]
fn motions_are_joined_in_the_order_of_the_inputs() {
    let (_folder, path) = folder();
    let (walk, output) = (real("cmu_12_01_walk.bvh"), path("both.bvh"));
    let found = run(&[
        "edit",
        &walk,
        &walk,
        &walk,
        "-o",
        &output,
        "--step",
        "concat",
        "--step",
        "concat",
        "--step",
        "warp:speed=2",
    ]);
    assert!(found.status.success(), "{}", words(&found));
    // Three motions of 523 frames are joined at two frames that they share, and then played at twice the speed.
    assert_eq!(
        mocap::import(&output).unwrap().animations[0].frame_count(),
        (523usize * 3 - 2).div_ceil(2)
    );

    for (step, message) in [
        (
            "concat:with=3",
            "the step concat uses the motion number 3, but the number of motions is 1",
        ),
        ("shake", "there is no step \"shake\"; the steps are foot-lock, mirror,"),
        ("smoth", "there is no step \"smoth\"; did you mean smooth?"),
        ("smooth:cutoff=8", "has no key \"cutoff\"; did you mean cut-off?"),
        ("smooth:cutoff=8", "such as smooth:cut-off=8"),
        (
            "fill:longest=soon",
            "longest takes a time in seconds such as 0.5, got \"soon\"",
        ),
    ] {
        let refused = run(&["edit", &walk, "-o", &path("x.glb"), "--step", step]);
        assert_eq!(refused.status.code(), Some(2), "{step}");
        assert!(words(&refused).contains(message), "{}", words(&refused));
    }
    let refused = run(&[
        "edit",
        &real("lecture_Test.bvh"),
        "-o",
        &path("x.glb"),
        "--step",
        "mirror",
    ]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        words(&refused).contains("the skeleton is not a humanoid"),
        "{}",
        words(&refused)
    );
    assert!(!std::fs::exists(path("x.glb")).unwrap());
}

#[test]
fn second_motions_are_recorded_and_verified() {
    let (_folder, path) = folder();
    let (walk, other, output) = (real("cmu_12_01_walk.bvh"), path("mirrored.bvh"), path("both.glb"));
    assert!(run(&["edit", &walk, "-o", &other, "--step", "mirror"]).status.success());
    let found = run(&[
        "edit",
        &walk,
        &other,
        "-o",
        &output,
        "--step",
        "blend:weight=0.5:0+2:1",
        "--loop-frames",
        "10..100",
        "--step",
        "concat:with=2,blend=0.1",
    ]);
    assert!(found.status.success(), "{}", words(&found));
    // The steps are applied in the given order.
    let told = words(&found);
    let places =
        ["blend with mirrored.bvh: ", "loop: ", "concat with mirrored.bvh: "].map(|name| told.find(name).unwrap());
    assert!(places.is_sorted(), "{told}");
    assert!(told.contains("loop: from frame 10 to frame 100; "), "{told}");
    assert_eq!(
        mocap::import(&output).unwrap().animations[0].frame_count(),
        91 + 523 - 1
    );

    let verified = run(&["verify", &walk, &output, "--with", &other, "--max-error", "0.01mm"]);
    assert!(verified.status.success(), "{}", words(&verified));
    for more in [&[][..], &["--with", &walk]] {
        let refused = run(&[&["verify", &walk, &output][..], more].concat());
        assert_eq!(refused.status.code(), Some(2));
        assert!(
            words(&refused).contains("the second motion of the file, \"mirrored.bvh\", is not among the files given"),
            "{}",
            words(&refused)
        );
    }
    // The second motion is also prepared: its rest pose in the first frame is dropped.
    let twice = path("twice.glb");
    assert!(
        run(&["edit", &walk, &walk, "-o", &twice, "--step", "concat"])
            .status
            .success()
    );
    assert!(
        run(&["verify", &walk, &twice, "--max-error", "0.01mm"])
            .status
            .success()
    );
}

#[test]
fn keys_are_marked_on_the_curves() {
    let (_folder, path) = folder();
    let (walk, output, curves) = (real("cmu_12_01_walk.bvh"), path("keys.glb"), path("keys.svg"));
    let between = |curves: &str, joints: &[&str]| {
        let arguments = [
            "edit",
            &walk,
            "-o",
            &output,
            "--force",
            "--step",
            "in-between:every=100",
            "--curves",
            curves,
        ];
        run(&[&arguments[..], joints].concat())
    };
    let found = between(&curves, &["--joint", "leftUpperLeg"]);
    assert!(found.status.success(), "{}", words(&found));
    let picture = std::fs::read_to_string(&curves).unwrap();
    // Frames 0, 100, ... 500 and 522, on three curves of the position and three of the rotation.
    assert_eq!(picture.matches("<circle").count(), 7 * 6);
    let refused = between(&path("other.svg"), &["--joint", "Tail"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        words(&refused).contains("no node or bone is called \"Tail\""),
        "{}",
        words(&refused)
    );
    assert_eq!(between(&curves, &[]).status.code(), Some(2));
    let refused = run(&["edit", &walk, "-o", &path("x.glb"), "--loop-frames", "10-40"]);
    assert!(
        words(&refused).contains("it must be two frames, such as 10..140"),
        "{}",
        words(&refused)
    );
}

/// Files of earlier versions record steps as text.
#[test]
fn steps_that_were_recorded_as_text_are_verified() {
    let (_folder, path) = folder();
    let (walk, output) = (real("cmu_short.bvh"), path("walk.gltf"));
    let found = run(&["edit", &walk, "-o", &output, "--step", "smooth:cut-off=20"]);
    assert!(found.status.success(), "{}", words(&found));
    let text = std::fs::read_to_string(&output).unwrap();
    let step: EditStep = "smooth:cut-off=20".parse().unwrap();
    let (value, old) = (serde_json::to_value(&step).unwrap().to_string(), format!("\"{step}\""));
    assert_eq!(text.matches(&value).count(), 1, "{value}");
    std::fs::write(&output, text.replace(&value, &old)).unwrap();
    let verified = run(&["verify", &walk, &output, "--max-error", "0.01mm"]);
    assert!(verified.status.success(), "{}", words(&verified));
    // Another step gives another motion.
    std::fs::write(&output, text.replace(&value, "\"smooth:cut-off=2\"")).unwrap();
    assert_eq!(
        run(&["verify", &walk, &output, "--max-error", "0.01mm"]).status.code(),
        Some(1)
    );
}

/// A map states the joints of bones. The file records the map, so `verify` needs none.
#[test]
fn bones_of_a_map_are_used_and_recorded() {
    let (_folder, path) = folder();
    let (walk, output, map) = (real("cmu_12_01_walk.bvh"), path("walk.glb"), path("map.json"));
    // The tips of the toes touch the ground. The joints of the toes do not.
    let tips = r#"{"bones": {"leftToes": "EndSite_LeftToeBase", "rightToes": "EndSite_RightToeBase"}}"#;
    std::fs::write(&map, tips).unwrap();
    let plain = path("plain.glb");
    for (output, more) in [(&plain, &[][..]), (&output, &["--map", &map])] {
        let arguments = ["edit", &walk, "-o", output, "--step", "foot-lock", "--step", "smooth"];
        let found = run(&[&arguments[..], more].concat());
        assert!(found.status.success(), "{}", words(&found));
    }
    let keys = |file: &str| mocap::import(file).unwrap().animations[0].channels.clone();
    assert!(keys(&plain) != keys(&output));
    let verified = run(&["verify", &walk, &output, "--max-error", "0.01mm"]);
    assert!(verified.status.success(), "{}", words(&verified));
    std::fs::write(&map, r#"{"bones": {"hips": "Tail"}}"#).unwrap();
    let refused = run(&["edit", &walk, "-o", &path("x.glb"), "--step", "mirror", "--map", &map]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        words(&refused).contains("no joint is called \"Tail\""),
        "{}",
        words(&refused)
    );
}

/// The paths below a folder, and the bytes of the files.
fn all_below(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.push((path.clone(), Vec::new()));
            found.extend(all_below(&path));
        } else {
            let bytes = std::fs::read(&path).unwrap();
            found.push((path, bytes));
        }
    }
    found.sort();
    found
}

#[test]
fn a_dry_run_says_what_it_would_write_and_writes_nothing() {
    let (folder, path) = folder();
    let (walk, character) = (real("cmu_short.bvh"), real("../characters/human_default.glb"));
    std::fs::create_dir(path("takes")).unwrap();
    std::fs::copy(&walk, path("takes/walk.bvh")).unwrap();
    std::fs::write(path("broken.bvh"), "HIERARCHY").unwrap();
    std::fs::copy(&walk, path("mine.bvh")).unwrap();
    let job = |name: &str, input: &str, output: &str, to: Option<&str>| {
        let job = serde_json::json!({
            "source": {"inputs": [input]},
            "steps": ["mirror"],
            "write": {"output": output, "to": to},
            "verify": true,
        });
        std::fs::write(path(name), job.to_string()).unwrap();
        path(name)
    };
    let one = job("one.json", &walk, &path("one.glb"), None);
    let many = job("many.json", &path("takes"), &format!("{}/", path("out")), Some("glb"));
    let before = all_below(folder.path());
    let (takes, out) = (path("takes"), path("out"));
    for (args, said) in [
        (vec!["convert", &walk, &path("walk.glb")], "walk.glb would be written, "),
        (vec!["convert", &walk, "-"], " bytes would go to standard output"),
        (vec!["convert", &takes, "-o", &out], "walk.bvh -> "),
        (
            vec!["edit", &walk, "-o", &path("walk.fbx"), "--step", "mirror"],
            "mirror: ",
        ),
        (
            vec!["edit", &takes, "-o", &format!("{out}/"), "--step", "mirror"],
            "dry run: 1 of 1 files would be written",
        ),
        (
            vec!["clean", &walk, "-o", &path("walk.gltf")],
            "walk.bin would be written, ",
        ),
        (
            vec!["retarget", &walk, &character, "-o", &path("hero.glb")],
            "1 clip would be added",
        ),
        (vec!["run", &one], "one.glb would be written, "),
        (vec!["run", &many], "dry run: 1 of 1 files would be written"),
    ] {
        let found = run(&[args.clone(), vec!["--dry-run"]].concat());
        assert!(found.status.success(), "{args:?}: {}", words(&found));
        assert!(words(&found).contains(said), "{args:?}: {}", words(&found));
        assert!(words(&found).contains("unit: "), "{args:?}: {}", words(&found));
        assert!(found.stdout.is_empty());
        assert!(before == all_below(folder.path()), "{args:?}");
    }
    // A dry run reports the errors of a real run.
    for (args, code, said) in [
        (vec!["convert", &path("broken.bvh"), &path("x.glb")], 1, "error["),
        (
            vec!["edit", &walk, "-o", &path("mine.bvh"), "--step", "mirror"],
            1,
            "output-exists",
        ),
        (
            vec!["edit", &walk, "-o", &path("x.glb"), "--step", "mirror", "--verify"],
            2,
            "--verify would do nothing",
        ),
        (
            vec!["convert", &walk, &path("x.glb"), "--print-job"],
            2,
            "cannot be used with",
        ),
    ] {
        let found = run(&[args.clone(), vec!["--dry-run"]].concat());
        assert_eq!(found.status.code(), Some(code), "{args:?}: {}", words(&found));
        assert!(words(&found).contains(said), "{args:?}: {}", words(&found));
        assert!(before == all_below(folder.path()), "{args:?}");
    }
}

/// Run without a browser: the search path is an empty folder.
#[test]
fn the_result_is_viewed_beside_the_source() {
    let (folder, path) = folder();
    let empty = path("empty");
    std::fs::create_dir(&empty).unwrap();
    let mut program = command::<&str>(&[]);
    program.env("PATH", &empty).env("TMPDIR", folder.path());
    let args = [
        "edit",
        &real("cmu_short.bvh"),
        "-o",
        &path("walk.glb"),
        "--step",
        "mirror",
        "--view",
    ];
    let found = program.args(args).output().unwrap();
    assert!(found.status.success(), "{}", words(&found));
    let said = words(&found);
    let page = said.split_once("no browser was found; open ").unwrap().1;
    let page = std::fs::read_to_string(page.split_once(" in a browser").unwrap().0).unwrap();
    assert!(page.contains("cmu_short (before)") && page.contains("walk (after)"));
    for args in [
        vec!["edit", "-", "-o", &path("x.glb")],
        vec!["edit", &real("cmu_short.bvh"), "-o", "-"],
        vec!["edit", &real("cmu_short.bvh"), "-o", &format!("{empty}/")],
    ] {
        let found = run(&[args, vec!["--step", "mirror", "--view"]].concat());
        assert_eq!(found.status.code(), Some(2), "{}", words(&found));
        assert!(words(&found).contains("--view"), "{}", words(&found));
    }
}
