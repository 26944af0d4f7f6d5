//! Converts many files: no output is missing or partial, and all ways to run the program give the same files.

mod each;
mod pattern;
mod shard;
#[cfg(unix)]
mod walk;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use mocap::Pose;
use mocap::bvh::BvhOptions;
use mocap::figure::{Humanoid, HumanoidBone};
use mocap::glam::{Quat, Vec3};
use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::at_root;
use crate::cut;
use crate::program::{Folder, MANIFEST, command};

fn mocap(args: &[&str]) -> Command {
    let mut command = command(args);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

fn run(args: &[&str]) -> Output {
    mocap(args).output().unwrap()
}

/// An input folder with nested folders, and a place for outputs.
struct Corpus {
    folder: tempfile::TempDir,
}

impl Corpus {
    /// `copies` of a real capture, each with a different length.
    fn new(copies: usize) -> Self {
        let corpus = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        let text = fs::read_to_string(at_root("fixtures/real/cmu_short.bvh")).unwrap();
        let rows = cut::count(&text);
        for copy in 0..copies {
            let shorter = cut::frames(&text, 0..rows - copy % rows);
            corpus.add(&format!("{}/take {copy:03}.bvh", copy % 3), &shorter);
        }
        corpus
    }

    fn add(&self, relative: &str, text: &str) {
        let path = self.inputs().join(relative);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    fn inputs(&self) -> PathBuf {
        self.folder.path().join("in")
    }

    fn output(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Converts everything to a folder with this name. Returns the exit code.
    fn convert(&self, name: &str, options: &[&str]) -> Option<i32> {
        let (inputs, output) = (self.inputs(), self.output(name));
        let mut args = vec![
            "convert",
            inputs.to_str().unwrap(),
            "-o",
            output.to_str().unwrap(),
            "-q",
        ];
        args.extend(options);
        run(&args).status.code()
    }
}

/// Every file below `folder` by its relative path. Removes the seconds in a manifest, because they differ between runs.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for path in fs::read_dir(next).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                let mut bytes = fs::read(&path).unwrap();
                if path.ends_with(MANIFEST) {
                    bytes = records(folder)
                        .iter()
                        .map(|record| record.to_string() + "\n")
                        .collect::<String>()
                        .into();
                }
                files.insert(path.strip_prefix(folder).unwrap().to_owned(), bytes);
            }
        }
    }
    files
}

/// The manifest in `folder`, without seconds.
fn records(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join(MANIFEST)).unwrap();
    let record = |line: &str| {
        let mut record: Value = serde_json::from_str(line).unwrap();
        assert!(record["seconds"].as_f64().unwrap() > 0.0);
        record.as_object_mut().unwrap().remove("seconds");
        record
    };
    text.lines().map(record).collect()
}

#[test]
fn many_files_become_what_each_becomes_alone() {
    let corpus = Corpus::new(7);
    assert_eq!(corpus.convert("out", &[]), Some(0));
    let files = contents(&corpus.output("out"));
    assert_eq!(files.len(), 8);
    for copy in 0..7 {
        let input = corpus.inputs().join(format!("{}/take {copy:03}.bvh", copy % 3));
        let alone = corpus.output("alone.glb");
        assert!(
            run(&["convert", input.to_str().unwrap(), alone.to_str().unwrap()])
                .status
                .success()
        );
        let of_many = &files[Path::new(&format!("{}/take {copy:03}.glb", copy % 3))];
        assert!(fs::read(alone).unwrap() == *of_many, "{}", input.display());
    }
    let records = records(&corpus.output("out"));
    let inputs: Vec<&str> = records.iter().map(|record| record["input"].as_str().unwrap()).collect();
    assert!(inputs.is_sorted() && inputs.len() == 7, "{inputs:?}");
    let first = fs::read(corpus.inputs().join("0/take 000.bvh")).unwrap();
    assert_eq!(records[0]["sha256"], format!("{:x}", Sha256::digest(&first)));
    assert_eq!(records[0]["bytes"], first.len());
    assert_eq!(records[0]["output"], "0/take 000.glb");
}

#[test]
fn any_number_of_threads_and_shards_makes_the_same_folder() {
    let corpus = Corpus::new(12);
    assert_eq!(corpus.convert("1", &["--threads", "1"]), Some(0));
    let expected = contents(&corpus.output("1"));
    for threads in ["2", "7"] {
        assert_eq!(corpus.convert(threads, &["--threads", threads]), Some(0));
        assert!(contents(&corpus.output(threads)) == expected, "{threads} threads");
    }
    for shard in ["1/3", "2/3", "3/3"] {
        assert_eq!(corpus.convert("shards", &["--shard", shard]), Some(0));
    }
    let shards = corpus.output("shards");
    assert!(run(&["merge-manifest", shards.to_str().unwrap()]).status.success());
    assert!(contents(&shards) == expected);
    // A run without shards has nothing left to do.
    assert_eq!(corpus.convert("shards", &["--resume"]), Some(0));
    assert!(contents(&shards) == expected);
}

#[test]
fn a_bad_file_stops_no_other() {
    let corpus = Corpus::new(4);
    corpus.add("0/bad.bvh", "HIERARCHY\nROOT a {\n  OFFSET 0 zero 0\n}\n");
    corpus.add("0/empty.bvh", "");
    corpus.add("notes.txt", "no motion, and not looked at");
    let (inputs, output) = (corpus.inputs(), corpus.output("out"));
    let missing = corpus.output("missing.bvh");
    let paths = [&inputs, &missing].map(|path| path.to_str().unwrap());
    let out = run(&["convert", paths[0], paths[1], "-o", output.to_str().unwrap()]);
    assert_eq!(out.status.code(), Some(3));
    let words = String::from_utf8(out.stderr).unwrap();
    assert!(
        words.contains("4 of 7 files converted, 0 done before, 3 failed"),
        "{words}"
    );
    assert!(words.contains("bad.bvh:3:12: error[invalid-number]"), "{words}");
    let failed: Vec<_> = records(&output)
        .into_iter()
        .filter(|record| !record["error"].is_null())
        .collect();
    let inputs: Vec<&str> = failed.iter().map(|record| record["input"].as_str().unwrap()).collect();
    assert_eq!(inputs, ["0/bad.bvh", "0/empty.bvh", "missing.bvh"]);
    assert!(failed.iter().all(|record| record["output"].is_null()));
    assert_eq!(contents(&output).len(), 5);
}

#[test]
fn only_what_changed_is_converted_again() {
    let corpus = Corpus::new(3);
    assert_eq!(corpus.convert("out", &[]), Some(0));
    let made = |name: &str| {
        fs::metadata(corpus.output("out").join(name))
            .unwrap()
            .modified()
            .unwrap()
    };
    let names = ["0/take 000.glb", "1/take 001.glb", "2/take 002.glb"];
    let before = names.map(made);
    let text = fs::read_to_string(corpus.inputs().join("1/take 001.bvh")).unwrap();
    corpus.add(
        "1/take 001.bvh",
        &text.replace("Frame Time: .0083333", "Frame Time: .01"),
    );
    fs::remove_file(corpus.output("out").join(names[2])).unwrap();
    assert_eq!(corpus.convert("out", &["--resume"]), Some(0));
    assert_eq!(made(names[0]), before[0]);
    assert!(made(names[1]) > before[1] && made(names[2]) > before[2]);
    assert_eq!(corpus.convert("out", &["--resume", "--mesh", "none"]), Some(0));
    assert!(made(names[0]) > before[0]);
}

#[test]
fn a_killed_run_leaves_nothing_half_and_goes_on() {
    let corpus = Corpus::new(60);
    assert_eq!(corpus.convert("whole", &[]), Some(0));
    let expected = contents(&corpus.output("whole"));
    let (inputs, output) = (corpus.inputs(), corpus.output("killed"));
    let args = [
        "convert",
        inputs.to_str().unwrap(),
        "-o",
        output.to_str().unwrap(),
        "--resume",
    ];
    for milliseconds in [1, 3, 5, 8, 12, 17, 4, 9, 2, 6] {
        let mut child = mocap(&args).spawn().unwrap();
        sleep(Duration::from_millis(milliseconds));
        child.kill().unwrap();
        child.wait().unwrap();
        for path in expected.keys().filter(|path| !path.ends_with(MANIFEST)) {
            if let Ok(bytes) = fs::read(output.join(path)) {
                assert!(bytes == expected[path], "{} is not whole", path.display());
            }
        }
    }
    assert!(run(&args).status.success());
    assert!(contents(&output) == expected);
}

#[test]
fn progress_is_lines_of_json_for_programs() {
    let corpus = Corpus::new(3);
    let (inputs, output) = (corpus.inputs(), corpus.output("out"));
    let args = [
        "convert",
        inputs.to_str().unwrap(),
        "-o",
        output.to_str().unwrap(),
        "--progress",
        "json",
    ];
    let words = String::from_utf8(run(&args).stderr).unwrap();
    let last = words.lines().rfind(|line| line.starts_with('{')).unwrap();
    let counts: Value = serde_json::from_str(last).unwrap();
    assert_eq!(counts["files"], 3);
    assert_eq!(counts["done"], 3);
    assert_eq!(counts["failed"], 0);
    assert_eq!(counts["bytes"], counts["bytes_done"]);
}

// This test runs only on file systems that distinguish upper and lower case.
#[cfg(target_os = "linux")]
#[test]
fn inputs_that_claim_one_output_keep_their_extensions() {
    let corpus = Corpus::new(1);
    let text = fs::read_to_string(corpus.inputs().join("0/take 000.bvh")).unwrap();
    corpus.add("0/take 000.BVH", &text);
    assert_eq!(corpus.convert("out", &[]), Some(0));
    let names: Vec<_> = contents(&corpus.output("out")).into_keys().collect();
    assert_eq!(
        names,
        ["0/take 000.BVH.glb", "0/take 000.bvh.glb", MANIFEST].map(PathBuf::from)
    );
}

#[test]
fn check_prints_a_folder_in_its_order() {
    let corpus = Corpus::new(40);
    corpus.add("0/bad.bvh", "HIERARCHY");
    let lines = |threads: &str| {
        let out = run(&[
            "check",
            corpus.inputs().to_str().unwrap(),
            "--json",
            "--threads",
            threads,
        ]);
        assert_eq!(out.status.code(), Some(3));
        String::from_utf8(out.stdout).unwrap()
    };
    let one = lines("1");
    let files: Vec<Value> = one.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let names: Vec<&str> = files.iter().map(|line| line["file"].as_str().unwrap()).collect();
    assert!(names.is_sorted() && names.len() == 41, "{names:?}");
    assert_eq!(one, lines("7"));
}

#[test]
fn check_names_the_file_to_blame() {
    let corpus = Corpus::new(0);
    corpus.add("walk.amc", include_str!("../../../../fixtures/made/tiny.amc"));
    corpus.add("walk.asf", ":bonedata\n  begin\n");
    let walk = corpus.inputs().join("walk.amc");
    let stdout = |args: &[&str]| String::from_utf8(run(args).stdout).unwrap();
    let text = stdout(&["check", walk.to_str().unwrap()]);
    let skeleton = walk.with_extension("asf");
    assert!(
        text.starts_with(&format!("{}:2:8: error[unexpected-end]", skeleton.display())),
        "{text}"
    );
    let json: Value = serde_json::from_str(&stdout(&["check", walk.to_str().unwrap(), "--json"])).unwrap();
    assert_eq!(json["file"], walk.to_str().unwrap());
    assert_eq!(json["diagnostics"][0]["file"], skeleton.to_str().unwrap());
}

/// A clip of a lying body and a clip of a standing body with the same skeleton, as BVH. Rokoko's rest pose is not a
/// figure, so only the standing clip shows the up axis.
fn lying_and_standing() -> [(&'static str, String); 2] {
    let mut standing = mocap::import(at_root("fixtures/real/rokoko_dance.bvh")).unwrap();
    standing.trim(0.0, 40.0);
    let mut lying = standing.clone();
    let turn = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let root = &mut lying.animations[0].channels[0];
    for place in &mut root.position_keys.values {
        *place = turn * *place + Vec3::new(0.0, 50.0, -80.0);
    }
    for rotation in &mut root.rotation_keys.values {
        *rotation = turn * *rotation;
    }
    [("1 lying.bvh", lying), ("2 standing.bvh", standing)].map(|(name, scene)| {
        let text = BvhOptions::default().write(&scene).unwrap();
        (name, String::from_utf8(text).unwrap())
    })
}

const CHARACTER: &str = "fixtures/skeletons/human_default.gltf";

/// Several clips in one output also determine the up axis for each other.
#[test]
fn clips_of_one_output_have_one_up_axis() {
    let corpus = Corpus::new(0);
    let [lying, standing] = lying_and_standing().map(|(name, text)| {
        corpus.add(name, &text);
        corpus.inputs().join(name).display().to_string()
    });
    let both = corpus.output("both.gltf");
    let output = both.to_str().unwrap();
    let ended = run(&["retarget", &standing, &lying, "--character", CHARACTER, "-o", output]);
    let words = String::from_utf8_lossy(&ended.stderr);
    assert!(
        ended.status.success() && words.contains("other motions of the same skeleton stand along this axis"),
        "{words}"
    );
    let lying = foot_to_head(&both);
    assert!(lying.z > 1.0, "{lying}");
}

/// New files of a folder can determine the up axis of earlier outputs. Only these outputs are made again.
#[test]
fn a_folder_that_grows_makes_outputs_anew_that_learn_from_it() {
    let corpus = Corpus::new(0);
    let inputs = corpus.inputs().display().to_string();
    let convert = |output: &str| vec!["convert".to_owned(), inputs.clone(), "-o".into(), output.into()];
    let retarget = |output: &str| {
        let to = format!("{output}/");
        vec![
            "retarget".to_owned(),
            inputs.clone(),
            "--character".into(),
            CHARACTER.into(),
            "-o".into(),
            to,
        ]
    };
    type Command<'a> = &'a dyn Fn(&str) -> Vec<String>;
    let commands: [(&str, Command<'_>, &str); 2] = [("converted", &convert, "glb"), ("body", &retarget, "gltf")];
    let runs = || {
        commands.map(|(name, command, extension)| {
            let output = corpus.output(name);
            let mut words = command(output.to_str().unwrap());
            words.push("--resume".to_owned());
            let ended = run(&Vec::from_iter(words.iter().map(String::as_str)));
            let lying = foot_to_head(&output.join(format!("1 lying.{extension}")));
            (String::from_utf8_lossy(&ended.stderr).into_owned(), lying)
        })
    };
    let [lying, standing] = lying_and_standing();
    corpus.add(lying.0, &lying.1);
    for (words, lying) in runs() {
        assert!(lying.y > 1.0, "alone it stands: {lying} {words}");
    }
    corpus.add(standing.0, &standing.1);
    for (words, lying) in runs() {
        assert!(
            words.contains("2 of 2 files converted") && lying.z > 1.0,
            "{lying} {words}"
        );
    }
    for (words, _) in runs() {
        assert!(words.contains("0 of 2 files converted, 2 done before"), "{words}");
    }
}

#[test]
fn clips_of_one_skeleton_have_one_unit_and_one_up_axis() {
    let corpus = Corpus::new(0);
    for (name, text) in lying_and_standing() {
        corpus.add(name, &text);
    }
    let alone = corpus.output("alone.glb");
    let input = corpus.inputs().join("1 lying.bvh");
    assert!(
        run(&["convert", input.to_str().unwrap(), alone.to_str().unwrap()])
            .status
            .success()
    );
    for threads in ["1", "4"] {
        let output = corpus.output(threads);
        let ended = run(&[
            "convert",
            corpus.inputs().to_str().unwrap(),
            "-o",
            output.to_str().unwrap(),
            "--threads",
            threads,
        ]);
        let words = String::from_utf8_lossy(&ended.stderr);
        assert!(
            ended.status.success() && words.contains("unit: cm in 2 files"),
            "{words}"
        );
        let records = records(&output);
        assert_eq!(records[0]["skeleton"], records[1]["skeleton"]);
        for record in &records {
            let choice = |topic: &str| {
                let guesses = record["guesses"].as_array().unwrap();
                let guess = guesses.iter().find(|guess| guess["topic"] == topic).unwrap();
                guess["choice"].as_str().unwrap().to_owned()
            };
            assert_eq!((choice("unit"), choice("up")), ("cm".to_owned(), "y".to_owned()));
        }
        // Without other clips, the lying body would be turned.
        let lying = foot_to_head(&output.join("1 lying.glb"));
        assert!(lying.z > 1.0, "{lying}");
        assert!(foot_to_head(&output.join("2 standing.glb")).y > 1.0);
        assert!(foot_to_head(&alone).y > 1.0);
    }
    let output = corpus.output("on a body");
    let ended = run(&[
        "retarget",
        corpus.inputs().to_str().unwrap(),
        "--character",
        "fixtures/skeletons/human_default.gltf",
        "-o",
        &format!("{}/", output.display()),
    ]);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let lying = foot_to_head(&output.join("1 lying.gltf"));
    assert!(lying.z > 1.0, "{lying}");
    assert!(foot_to_head(&output.join("2 standing.gltf")).y > 1.0);
    let record = &records(&output)[0];
    let told = record["warnings"].to_string();
    assert!(
        told.contains("other clips of the same skeleton stand along this axis"),
        "{told}"
    );
}

/// The vector from the left foot to the head in the first frame of a file.
fn foot_to_head(path: &Path) -> Vec3 {
    let scene = mocap::import(path).unwrap();
    let bones = Humanoid::of(&scene);
    let clip = scene.animations.len() - 1;
    let pose = Pose::at_tick(&scene, clip, 0.0).unwrap();
    let at = |bone| pose.position(bones.joint(bone).unwrap());
    at(HumanoidBone::Head) - at(HumanoidBone::LeftFoot)
}

/// mocap reads the outputs of an earlier run if the user names their folder. It does not read the output folder of the
/// same run, output folders inside the named folder, and outputs beside their sources.
#[test]
fn the_outputs_of_one_run_are_the_inputs_of_another() {
    let folder = Folder::with(&["in/a.bvh", "in/b.bvh"]);
    let outputs = |name: &str| {
        let mut names: Vec<String> = fs::read_dir(folder.path(name))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| !name.starts_with("mocap-manifest"))
            .collect();
        names.sort();
        names
    };
    folder.succeeds("convert in -o glb");
    folder.succeeds("convert glb -o back --to bvh");
    assert_eq!(outputs("back"), ["a.bvh", "b.bvh"]);
    folder.succeeds("convert back -o again");
    assert_eq!(outputs("again"), ["a.glb", "b.glb"]);
    folder.write("moved/a.glb", &folder.read("glb/a.glb"));
    folder.succeeds("convert moved -o of_moved --to bvh");
    assert_eq!(outputs("of_moved"), ["a.bvh"]);
    // mocap does not read outputs in the input folder: of the same run, of another run, or beside their source.
    for (command, made) in [
        ("convert in -o in/glb", "in/glb"),
        ("convert in -o in/glb", "in/glb"),
        ("convert in -o in/fbx --to fbx", "in/fbx"),
        ("convert in/a.bvh", "in/fbx"),
        ("convert in -o in/fbx --to fbx", "in/fbx"),
    ] {
        folder.succeeds(command);
        assert_eq!(outputs(made).len(), 2, "{command}: {:?}", outputs(made));
    }
}

/// If an output holds one clip, each clip of a file gets an output in a folder with the name of the file.
#[test]
fn each_clip_of_a_file_gets_an_output() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    for name in ["again/cmu_short.bvh", "in/cmu_short.bvh"] {
        folder.write(name, &folder.read("cmu_short.bvh"));
    }
    folder.succeeds("retarget cmu_short.bvh again/cmu_short.bvh --character cmu_short.bvh -o in/two.gltf");
    // Two names that differ only in case, and that would lead out of the folder.
    let text = String::from_utf8(folder.read("in/two.gltf")).unwrap();
    let renamed = text
        .replace("\"cmu_short_2\"", "\"../Walk\"")
        .replace("\"cmu_short\"", "\"../walk\"");
    folder.write("in/two.gltf", renamed.as_bytes());
    folder.succeeds("convert in -o out --to bvh --verify");
    let names = ["out/cmu_short.bvh", "out/two/_walk.bvh", "out/two/_Walk-1.bvh"];
    for name in names {
        assert!(folder.path(name).is_file(), "{name}");
    }
    folder.succeeds("convert in/two.gltf alone.bvh --clip 1");
    assert!(folder.read("alone.bvh") == folder.read(names[2]));
    let resumed = folder.succeeds("convert in -o out --to bvh --verify --resume");
    assert!(resumed.contains("3 done before"), "{resumed}");
    // A chosen clip is the only one, and a format with several clips keeps them in one file.
    folder.succeeds("convert in -o chosen --to bvh --clip 0");
    assert!(folder.path("chosen/two.bvh").is_file() && !folder.path("chosen/two").exists());
    folder.succeeds("convert in -o glb");
    assert!(folder.path("glb/two.glb").is_file() && !folder.path("glb/two").exists());
}
