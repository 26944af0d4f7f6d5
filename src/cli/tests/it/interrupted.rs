//! Every command that writes files, killed and on a full disk. An output is complete (new or old) or absent. No input
//! changes, and no temporary file remains.
//!
//! A separate disk would need permissions that a test lacks. A limit on file sizes (`ulimit -f`) stops writing at the
//! same byte every time, like a full disk. The tests also send SIGKILL at several times of a run, and as soon as an
//! output has some of its bytes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::at_root;
use crate::program::{STATE_HOME, command_in, words};
use crate::sample::Sample;

/// Commands that write no file by themselves, `mcp`, which runs other commands, and `record`, which needs a sender and
/// is tested in `live.rs`.
const WRITE_NOTHING: &[&str] = &[
    "verify",
    "score",
    "info",
    "gait",
    "skeleton",
    "check",
    "dump",
    "pose",
    "chain",
    "doctor",
    "formats",
    "find",
    "mcp",
    "completions",
    "man",
    "play",
    "record",
    "bridge",
];

struct Case {
    arguments: &'static str,
    /// Commands that prepare the folder for the command.
    before: &'static [&'static str],
    /// Whether the outputs are a folder.
    many: bool,
    /// The main file of an output with several files, which refers to the others.
    main: Option<&'static str>,
}

const fn one(arguments: &'static str) -> Case {
    Case {
        arguments,
        before: &[],
        many: false,
        main: None,
    }
}

/// An output of several files, of which `main` refers to the others.
const fn set(arguments: &'static str, main: &'static str) -> Case {
    Case {
        main: Some(main),
        ..one(arguments)
    }
}

const fn many(arguments: &'static str, before: &'static [&'static str]) -> Case {
    Case {
        arguments,
        before,
        many: true,
        main: None,
    }
}

/// The inputs are `walk.bvh`, the folder `clips`, `character.bvh`, `plates.c3d`, `robot.urdf`, and `job.json`.
const CASES: &[Case] = &[
    one("convert walk.bvh out.glb"),
    set("convert walk.bvh out.gltf", "out.gltf"),
    set("convert hero.gltf out.fbx --textures beside --force", "out.fbx"),
    set("convert hero.gltf out.usda --force", "out.usda"),
    many("convert heroes -o out --to usda --force", &[]),
    set("convert walk.bvh out.bvh --sidecar --force", "out.bvh"),
    one("solve points.npy --joint-set smpl22 -o out.glb"),
    one("convert walk.bvh out.bvh --force"),
    many("convert clips -o out", &[]),
    many("convert clips -o out --to bvh --force", &[]),
    set(
        "edit walk.bvh -o out.gltf --step mirror --contacts out.json --curves out.png --joint Hips --force",
        "out.gltf",
    ),
    many("edit clips -o out/ --step mirror", &[]),
    set("clean walk.bvh -o out.glb --report out.json --force", "out.glb"),
    set(
        "survey walk.bvh -o out.json --html out.html --sarif out.sarif --force",
        "out.json",
    ),
    one("index walk.bvh -o out.mdb"),
    Case {
        before: &["index walk.bvh -o moves.mdb"],
        ..one("match moves.mdb --path 0/0+0/1 --on walk.bvh -o out.glb")
    },
    Case {
        before: &["index walk.bvh -o moves.mdb"],
        ..one("match moves.mdb --on walk.bvh -o out.bin --force")
    },
    Case {
        before: &["index walk.bvh -o moves.mdb"],
        ..one("find moves.mdb --like walk.bvh@0..0.2 --sheet out.png --page out.html --force")
    },
    one("graph points.npy --window 0.07 --threshold 2m -o out.json --matrix out.png --force"),
    set("run job.json", "out.gltf"),
    one("retarget walk.bvh character.bvh -o out.glb --force"),
    many("retarget clips --character character.bvh -o out/", &[]),
    one("robot walk.bvh --robot robot.urdf -o out.npz"),
    many("robot clips --robot robot.urdf -o out --to csv", &[]),
    one("fk walk.bvh -o out.npz"),
    one("fk walk.bvh -o out.csv"),
    one("angles walk.bvh -o out.mot"),
    one("forces plates.c3d -o out.mot"),
    one("analog plates.c3d -o out.csv --force"),
    #[cfg(feature = "parquet")]
    one("fk walk.bvh -o out.parquet"),
    #[cfg(feature = "parquet")]
    many("pack clips -o out", &[]),
    one("view walk.bvh -o out.html --force"),
    many("view clips -o out.html --force", &[]),
    one("sheet walk.bvh -o out.png --force"),
    one("gif walk.bvh -o out.gif --width 160 --height 120 --rate 5 --force"),
    one("plot walk.bvh -o out.svg --joint Hips --force"),
    many(
        "merge-manifest out",
        &["convert clips -o out --shard 1/2", "convert clips -o out --shard 2/2"],
    ),
];

/// The names and the bytes of all files below a folder.
type Files = BTreeMap<PathBuf, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let mut files = Files::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.strip_prefix(folder).unwrap().to_owned(), fs::read(&path).unwrap());
            }
        }
    }
    files
}

fn folder_with(files: &Files) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    folder
}

fn inputs(source: &str) -> Files {
    let bytes = fs::read(at_root(&format!("fixtures/real/{source}"))).unwrap();
    let names = ["walk.bvh", "clips/a.bvh", "clips/below/b.bvh"];
    let mut files: Files = names.into_iter().map(|name| (name.into(), bytes.clone())).collect();
    files.insert(
        "points.npy".into(),
        fs::read(at_root("fixtures/arrays/points_smpl22.npy")).unwrap(),
    );
    files.insert(
        "plates.c3d".into(),
        fs::read(at_root("fixtures/made/plates.c3d")).unwrap(),
    );
    files.insert(
        "character.bvh".into(),
        fs::read(at_root("fixtures/real/biovision_example1.bvh")).unwrap(),
    );
    let job =
        r#"{"source": {"inputs": ["walk.bvh"]}, "steps": ["mirror"], "write": {"output": "out.gltf", "force": true}}"#;
    files.insert("job.json".into(), job.into());
    // A character with a texture as large as a motion. The pixels do not matter.
    let hero = fs::read_to_string(at_root("fixtures/made/two_bones_textured.gltf")).unwrap();
    let mut hero: serde_json::Value = serde_json::from_str(&hero).unwrap();
    hero["images"][0] = serde_json::json!({"uri": "hero.png", "name": "skin"});
    for folder in ["", "heroes/a/", "heroes/b/"] {
        files.insert(format!("{folder}hero.gltf").into(), hero.to_string().into());
        let image = [b"\x89PNG", folder.as_bytes(), &bytes].concat();
        files.insert(format!("{folder}hero.png").into(), image);
    }
    files.insert(
        "robot.urdf".into(),
        fs::read(at_root("fixtures/robots/h1.urdf")).unwrap(),
    );
    files
}

fn succeeds(folder: &Path, arguments: &str) {
    let output = command_in(folder, arguments).output().unwrap();
    assert!(output.status.success(), "{arguments}: {}", words(&output));
}

/// Runs a command with a limit on file sizes, in units of 1024 bytes.
fn limited(folder: &Path, arguments: &str, blocks: usize) -> Output {
    Command::new("bash")
        .args(["-c", &format!("ulimit -f {blocks}; exec \"$@\""), "bash"])
        .arg(env!("CARGO_BIN_EXE_mocap"))
        .env("XDG_STATE_HOME", STATE_HOME)
        .args(arguments.split(' '))
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Whether a process has written some bytes to a file below a folder, including unnamed files. Only Linux shows this;
/// on other systems the process is killed immediately.
fn has_written(process: u32, folder: &Path, bytes: usize) -> bool {
    if cfg!(not(target_os = "linux")) {
        return true;
    }
    let folder = folder.canonicalize().unwrap();
    let open = fs::read_dir(format!("/proc/{process}/fd"))
        .into_iter()
        .flatten()
        .flatten();
    let mut links = open.map(|entry| entry.path());
    links.any(|link| {
        let is_below = fs::read_link(&link).is_ok_and(|target| target.starts_with(&folder));
        let is_output = |text: String| {
            text.lines()
                .any(|line| line.starts_with("flags:") && line.ends_with(['1', '2']))
        };
        let flags = link.to_string_lossy().replace("/fd/", "/fdinfo/");
        is_below
            && fs::read_to_string(flags).is_ok_and(is_output)
            && fs::metadata(&link).is_ok_and(|file| file.len() > bytes as u64)
    })
}

fn is_unfinished(path: &Path) -> bool {
    path.file_name().unwrap().to_string_lossy().contains(".unfinished-")
}

/// A manifest grows line by line, and its times differ between runs.
fn is_manifest(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "jsonl")
}

/// A command, and the files before it and after it.
struct CommandCase<'a> {
    case: &'a Case,
    inputs: Files,
    /// The inputs and the outputs of another run.
    old: Files,
    new: Files,
    /// The duration of the command.
    duration: Duration,
}

impl<'a> CommandCase<'a> {
    fn new(case: &'a Case) -> Self {
        let run = |source: &str| {
            let folder = folder_with(&inputs(source));
            for command in case.before {
                succeeds(folder.path(), command);
            }
            let before = files(folder.path());
            let start = Instant::now();
            succeeds(folder.path(), case.arguments);
            (before, files(folder.path()), start.elapsed())
        };
        let (_, mut old, _) = run("biovision_example1.bvh");
        let (inputs, new, duration) = run("cmu_short.bvh");
        old.extend(inputs.clone());
        if !case.before.is_empty() {
            // The outputs of another run have other inputs.
            old = inputs.clone();
        }
        Self {
            case,
            inputs,
            old,
            new,
            duration,
        }
    }

    /// Checks a folder after an interrupted command.
    fn check(&self, folder: &Path, before: &Files, how: &str) {
        let how = format!("{}, {how}", self.case.arguments);
        let found = files(folder);
        let mut age = BTreeMap::new();
        for (path, bytes) in found.iter().filter(|(path, _)| !is_unfinished(path)) {
            let is = |files: &Files| files.get(path) == Some(bytes);
            if is_manifest(path) && self.case.before.is_empty() {
                let text = String::from_utf8_lossy(bytes);
                let (whole, rest) = text.split_at(text.rfind('\n').map_or(0, |end| end + 1));
                let is_json = |line: &str| serde_json::from_str::<serde_json::Value>(line).is_ok();
                assert!(whole.lines().all(is_json), "{how}: {text}");
                // Ignore the partial line at which the process stopped.
                assert!(!rest.contains('\n'), "{how}: {text}");
                continue;
            }
            // The list of clips also has the failed clips.
            if self.case.many && path.ends_with("out.html") {
                assert!(bytes.trim_ascii_end().ends_with(b"</html>"), "{how}: a part of a list");
                continue;
            }
            assert!(
                is(&self.new) || is(before),
                "{how}: {} is neither new nor old",
                path.display()
            );
            age.insert(path.clone(), is(&self.new));
        }
        for path in self.inputs.keys().filter(|path| self.new.contains_key(*path)) {
            assert!(
                found.get(path) == self.inputs.get(path),
                "{how}: {} changed",
                path.display()
            );
        }
        // A shard's manifest may only be removed after its lines are in the folder's manifest.
        let is_merged = found.contains_key(Path::new("out/mocap-manifest.jsonl"));
        for path in self.inputs.keys().filter(|path| !self.new.contains_key(*path)) {
            assert!(
                is_merged || found.contains_key(path),
                "{how}: {} is lost",
                path.display()
            );
        }
        // If the main file exists, all files come from one run. Files that are equal in both runs do not show which
        // run.
        let has_main = self.case.main.is_some_and(|main| age.contains_key(Path::new(main)));
        let has_changed =
            |path: &&PathBuf| !self.inputs.contains_key(*path) && before.get(*path) != self.new.get(*path);
        let changed: Vec<_> = self.new.keys().filter(has_changed).filter(|_| has_main).collect();
        for path in &changed {
            let (first, own) = (age.get(changed[0]), age.get(*path));
            assert_eq!(
                own,
                first,
                "{how}: {} is of another run than {}",
                path.display(),
                changed[0].display()
            );
        }
    }

    /// Checks that running the command again after an interruption repairs everything.
    fn check_again(&self, folder: &Path, how: &str) {
        let how = format!("{}, {how}", self.case.arguments);
        // An almost finished merge may have nothing left to do.
        if self.case.before.is_empty() || files(folder) != self.new {
            succeeds(folder, self.case.arguments);
        }
        let found = files(folder);
        let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&found), names(&self.new), "{how}");
        for (path, bytes) in found.iter().filter(|(path, _)| !is_manifest(path)) {
            assert!(Some(bytes) == self.new.get(path), "{how}: {}", path.display());
        }
    }

    fn on_a_full_disk(&self) {
        for (state, before) in [("no output", &self.inputs), ("old outputs", &self.old)] {
            for blocks in self.limits() {
                let how = format!("{state}, a full disk at {blocks} KiB");
                let folder = folder_with(before);
                let output = limited(folder.path(), self.case.arguments, blocks);
                assert!(matches!(output.status.code(), Some(1 | 3)), "{how}: {}", words(&output));
                assert!(!words(&output).is_empty(), "{how}");
                self.check(folder.path(), before, &how);
                let found = files(folder.path());
                assert!(
                    !found.keys().any(|path| is_unfinished(path)),
                    "{how}: {:?}",
                    found.keys()
                );
                if !self.case.many {
                    assert!(found == *before, "{}, {how}", self.case.arguments);
                }
            }
        }
    }

    fn killed_while_it_writes(&self) {
        for blocks in self.limits() {
            let how = format!("killed at {blocks} KiB");
            let folder = folder_with(&self.old);
            let mut child = command_in(folder.path(), self.case.arguments)
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            while child.try_wait().unwrap().is_none() && !has_written(child.id(), folder.path(), 1024 * blocks) {}
            child.kill().unwrap();
            child.wait().unwrap();
            self.check(folder.path(), &self.old, &how);
            self.check_again(folder.path(), &how);
        }
    }

    fn killed_at_any_time(&self) {
        for part in [1, 5, 7, 9] {
            let before = if self.case.many { &self.inputs } else { &self.old };
            let moment = self.duration * part / 10;
            let how = format!("killed after {moment:?} of {:?}", self.duration);
            let folder = folder_with(before);
            let mut child = command_in(folder.path(), self.case.arguments)
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(moment);
            child.kill().unwrap();
            child.wait().unwrap();
            self.check(folder.path(), before, &how);
            self.check_again(folder.path(), &how);
        }
    }

    /// File sizes below the size of the largest output, in units of 1024 bytes.
    fn limits(&self) -> [usize; 2] {
        let outputs = self.new.iter().filter(|(path, _)| !self.inputs.contains_key(*path));
        let largest = outputs.map(|(_, bytes)| bytes.len()).max().unwrap();
        [0, largest / 2048]
    }
}

#[test]
fn no_command_leaves_a_part_of_an_output() {
    let cases = Sample::new().some(CASES, 6);
    std::thread::scope(|scope| {
        for cases in cases.chunks(cases.len().div_ceil(2)) {
            scope.spawn(move || {
                for &case in cases {
                    let tried = CommandCase::new(case);
                    tried.on_a_full_disk();
                    tried.killed_while_it_writes();
                    tried.killed_at_any_time();
                }
            });
        }
    });
}

#[test]
fn every_command_is_interrupted_or_writes_nothing() {
    let help = command_in(Path::new("."), "--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    // `  convert         Convert motion files`, but not the options, which begin with a hyphen.
    let (commands, _) = help.split_once("Options:").unwrap();
    let entries = commands.lines().filter_map(|line| line.strip_prefix("  "));
    let entries = entries.filter(|entry| entry.starts_with(|c: char| c.is_ascii_lowercase()));
    let names: Vec<_> = entries.filter_map(|entry| entry.split(' ').next()).collect();
    assert!(names.len() > 12 && names.contains(&"plot"), "{names:?}");
    let is_tried = |name: &str| CASES.iter().any(|case| case.arguments.split(' ').next() == Some(name));
    for name in names {
        let known = is_tried(name) || WRITE_NOTHING.contains(&name) || name == "pack" && cfg!(not(feature = "parquet"));
        assert!(known, "{name} is in neither list of this file");
    }
}
