//! The notices of a run with many files: failures, doubtful clips and skipped files.

use std::fs;
use std::process::{Command, Output};

use crate::at_root;
use crate::program::{Folder, STATE_HOME, command, words};

/// A motion that fits a character, a motion with a wrong trunk, and a motion with a backward head.
const TAKES: [&str; 3] = ["cmu_short.bvh", "nan_tokens.bvh", "slimevr_headset_root.bvh"];

fn folder() -> Folder {
    let folder = Folder::of_real(&[]);
    for name in TAKES {
        let bytes = fs::read(at_root(&format!("fixtures/real/{name}"))).unwrap();
        folder.write(&format!("my takes/{name}"), &bytes);
    }
    let hero = fs::read(at_root("fixtures/characters/human_default.glb")).unwrap();
    folder.write("hero.glb", &hero);
    folder
}

fn run(folder: &Folder, arguments: &[&str]) -> Output {
    let mut command = command(arguments);
    command.current_dir(folder.path("")).output().unwrap()
}

/// Runs the lines of a shell, in which `mocap` is the program.
fn shell(folder: &Folder, lines: &str) -> Output {
    let lines = format!("mocap() {{ {:?} \"$@\"; }}\n{lines}", env!("CARGO_BIN_EXE_mocap"));
    let mut command = Command::new("bash");
    command.args(["-c", &lines]).env("XDG_STATE_HOME", STATE_HOME);
    command.current_dir(folder.path("")).output().unwrap()
}

/// The printed commands can be pasted into a shell.
fn are_commands(folder: &Folder, said: &str, count: usize) {
    let lines = said
        .lines()
        .map(str::trim)
        .filter(|line| line.starts_with("mocap view "));
    let lines: Vec<&str> = lines.collect();
    assert_eq!(lines.len(), count, "{said}");
    for line in lines {
        let output = shell(folder, &format!("{line} -o look.html"));
        assert!(output.status.success(), "{line}: {}", words(&output));
        fs::remove_file(folder.path("look.html")).unwrap();
    }
}

#[test]
fn a_folder_lists_the_clips_that_are_not_good() {
    let folder = folder();
    let output = run(
        &folder,
        &["retarget", "my takes", "--character", "hero.glb", "-o", "out/"],
    );
    let said = words(&output);
    assert!(output.status.success() && output.stdout.is_empty(), "{said}");
    assert!(said.contains("1 good, 1 fair, 1 poor"), "{said}");
    // The manifest has the same angles.
    for record in folder.records("out") {
        let (name, report) = (record["input"].as_str().unwrap(), &record["retarget"][0]);
        let verdict = report["verdict"].as_str().unwrap();
        let line = said.lines().find(|line| line.contains(&format!("my takes/{name}: ")));
        let Some(line) = line else {
            assert_eq!(verdict, "good", "{said}");
            continue;
        };
        assert!(line.starts_with(&format!("  {verdict}  ")), "{line}");
        let degrees = report["seen"][0]["mean_degrees"].as_f64().unwrap();
        assert!(line.contains(&format!(": mean error {degrees:.1} degrees")), "{line}");
        let aspect = report["seen"][0]["aspect"].as_str().unwrap();
        assert!(line.contains(aspect), "{line}");
    }
    are_commands(&folder, &said, 2);
}

#[test]
fn motions_on_a_robot_that_are_not_good_are_listed() {
    let folder = folder();
    folder.write("h1.urdf", &fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    let arguments = ["robot", "my takes/slimevr_headset_root.bvh", "my takes/cmu_short.bvh"];
    let arguments = [
        &arguments[..],
        &["--robot", "h1.urdf", "-o", "out/", "--trim", "0f..20f"],
    ]
    .concat();
    let output = run(&folder, &arguments);
    let said = words(&output);
    assert!(output.status.success(), "{said}");
    let records = folder.records("out");
    let doubtful = records.iter().filter(|record| record["robot"]["verdict"] != "good");
    let doubtful: Vec<&str> = doubtful.map(|record| record["input"].as_str().unwrap()).collect();
    assert!(!doubtful.is_empty(), "{records:?}");
    for name in &doubtful {
        assert!(said.contains(&format!("  my takes/{name}: ")), "{said}");
    }
    are_commands(&folder, &said, doubtful.len());
}

/// With four motions in one file, each line names its motion, and each row has the reason for its verdict.
#[test]
fn the_notes_of_many_motions_name_their_files() {
    let folder = folder();
    folder.write("my takes/again.bvh", &folder.read("my takes/cmu_short.bvh"));
    let names = ["again.bvh", TAKES[0], TAKES[1], TAKES[2]].map(|name| format!("my takes/{name}"));
    let mut arguments = vec!["retarget"];
    arguments.extend(names.iter().map(String::as_str));
    arguments.extend(["hero.glb", "-o", "all.glb"]);
    let output = run(&folder, &arguments);
    let said = words(&output);
    assert!(output.status.success(), "{said}");
    let notes = said
        .lines()
        .filter(|line| line.contains("unit: ") || line.contains("up: "));
    let notes: Vec<&str> = notes.collect();
    assert!(notes.len() >= 8, "{said}");
    for note in notes {
        assert!(
            names.iter().any(|name| note.starts_with(&format!("{name}: "))),
            "{note}"
        );
    }
    assert!(said.contains("\n  head: mean error 117.0 degrees; "), "{said}");
    are_commands(&folder, &said, 2);
}

/// The notice comes before the summary, and not on standard output.
#[test]
fn failures_are_told_as_they_happen() {
    let folder = Folder::with(&["in/good.bvh"]);
    for number in 0..25 {
        folder.write(&format!("in/{number}.bvh"), b"HIERARCHY\nnothing");
    }
    let output = folder.run("convert in -o out");
    let said = words(&output);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(output.stdout.is_empty());
    let (before, _) = said.split_once("1 of 26 files converted").unwrap();
    assert_eq!(before.matches("error: in/").count(), 20, "{said}");
    assert!(
        before.contains("more files failed; the manifest lists all of them"),
        "{said}"
    );
    let folder = Folder::with(&[]);
    folder.write("in/a.bvh", b"HIERARCHY\nnothing");
    let output = folder.run("convert in -o out -q");
    assert_eq!(output.status.code(), Some(1));
    assert!(
        words(&output).starts_with("error: in/a.bvh:2:1: "),
        "{}",
        words(&output)
    );
}

#[test]
fn a_source_that_is_not_there_makes_no_folder() {
    let folder = Folder::with(&["takes/w.bvh"]);
    for arguments in [
        "convert takez -o out",
        "convert takez/ -o out",
        "edit takez -o out/ --step mirror",
    ] {
        folder.refuses(arguments, 1, "did you mean takes?");
    }
    folder.refuses("convert none.bvh -o out", 1, "none.bvh");
    // One failed motion of several is a partial failure.
    folder.ends_with(3, "convert takes/w.bvh none.bvh -o out");
}

#[test]
fn a_folder_names_the_robots_that_it_leaves_out() {
    let folder = Folder::with(&["in/w.bvh"]);
    folder.write(
        "in/h1.xml",
        &fs::read(at_root("fixtures/robots/h1_nomesh.xml")).unwrap(),
    );
    folder.write("in/notes.xml", b"<notes/>");
    let said = folder.succeeds("convert in -o out");
    assert!(
        said.contains("skipped 1 robot, not a motion: in/h1.xml; mocap robot"),
        "{said}"
    );
}

#[test]
fn robot_says_what_it_wrote() {
    let folder = folder();
    folder.write("h1.urdf", &fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    folder.write("w.bvh", &folder.read("my takes/cmu_short.bvh"));
    let said = folder.succeeds("robot w.bvh --robot h1.urdf -o w.npz --trim 0f..9f");
    let bytes = folder.read("w.npz").len();
    assert!(
        said.contains("w.bvh -> w.npz: ") && said.contains(&format!(" frames, {bytes} bytes")),
        "{said}"
    );
}

/// The terminal output of a command that waits for its input. `script` provides the terminal.
#[cfg(target_os = "linux")]
#[test]
fn a_command_on_one_file_shows_on_a_terminal_that_it_works() {
    let folder = Folder::with(&["w.bvh"]);
    let shown = |output: &str, program: &str| {
        let line = format!(
            "(sleep 2.5; cat w.bvh) | {:?} convert - {output}",
            env!("CARGO_BIN_EXE_mocap")
        );
        let lines = format!("{program} {}", format_args!("'{}'", line.replace('\'', "'\\''")));
        let lines = match program {
            "bash -c" => format!("{lines} 2>&1"),
            _ => format!("{lines} /dev/null"),
        };
        let run = shell(&folder, &format!("export TERM=xterm; {lines}"));
        assert!(run.status.success(), "{output}: {}", words(&run));
        String::from_utf8(run.stdout).unwrap()
    };
    let cases = [
        ("", "script -qec", true),
        (" -q", "script -qec", false),
        ("", "bash -c", false),
    ];
    // Start all commands first, because each waits.
    std::thread::scope(|scope| {
        for (at, (options, program, is_shown)) in cases.into_iter().enumerate() {
            let shown = &shown;
            scope.spawn(move || {
                let said = shown(&format!("out{at}.glb{options}"), program);
                let has_time = said.contains("convert 1s") || said.contains("convert 2s");
                assert_eq!(has_time, is_shown, "{said:?}");
            });
        }
    });
}

#[test]
fn a_statement_that_the_file_contradicts_is_questioned() {
    let folder = Folder::of_real(&[]);
    let z_up = fs::read(at_root("fixtures/made/fbx_zup.fbx")).unwrap();
    folder.write("walk.fbx", &z_up);
    for (options, is_told) in [
        (["--unit", "cm", "--up", "z"], false),
        (["--unit", "cm", "--up", "y"], true),
        (["--unit", "m", "--up", "z"], true),
    ] {
        for output in ["walk.glb", "walk.usda", "arrays.csv"] {
            let command: &[&str] = match output {
                "arrays.csv" => &["fk", "walk.fbx", "-o", output],
                _ => &["convert", "walk.fbx", output],
            };
            let arguments = [command, &["--force"], &options[..]].concat();
            let output = run(&folder, &arguments);
            let said = words(&output);
            assert!(output.status.success(), "{arguments:?}: {said}");
            assert_eq!(
                said.matches("the file states another").count(),
                usize::from(is_told),
                "{arguments:?}: {said}"
            );
        }
    }
}

/// Positions keep the unit of their file, and the units of a folder may differ.
#[test]
fn a_folder_with_several_units_is_a_warning() {
    let (cmu, cm) = ("cmu_12_01_walk.bvh", "mocopi_jump_six_channels.bvh");
    let folder = Folder::of_real(&[cmu, cm, "perception_neuron_moving_positions.bvh"]);
    let warning = "warning: positions keep the unit of each file: cm in 2 files, cmu in 1 file; --out-unit m writes all \
                   positions in metres";
    for (command, warns) in [
        ("convert *.bvh -o npz/ --to npz", true),
        // The files of an earlier run also count.
        ("convert *.bvh -o npz/ --to npz --resume", true),
        ("convert *.bvh -o bvh/ --to bvh", true),
        ("convert *.bvh -o metres/ --to npz --out-unit m", false),
        ("convert *.bvh -o glb/ --to glb", false),
        (&format!("convert {cm} -o one/ --to npz"), false),
    ] {
        let said = folder.succeeds(command);
        assert_eq!(said.matches(warning).count(), usize::from(warns), "{command}: {said}");
        assert_eq!(said.contains("keep the unit"), warns, "{command}: {said}");
    }
}

/// The files of a pose estimator may be frames of one take, or poses.
#[test]
fn a_folder_of_frames_says_that_it_is_one_take() {
    let folder = Folder::of_real(&[]);
    let body = std::fs::read(at_root("fixtures/arrays/sam3d_body.npz")).unwrap();
    std::fs::create_dir(folder.path("frames")).unwrap();
    for frame in 0..3 {
        folder.write(&format!("frames/img_{frame}.npz"), &body);
    }
    let refused = folder.ends_with(1, "convert frames take.glb");
    assert!(
        refused.contains("the file states no frame rate") && refused.contains("--fps 30"),
        "{refused}"
    );
    let said = folder.succeeds("convert frames take.glb --fps 30");
    assert!(said.contains("3 files are the frames 0, 1, 2 of one take"), "{said}");
    assert!(
        said.contains("name an output folder: --output FOLDER --to glb"),
        "{said}"
    );
    let said = folder.succeeds("convert frames --output each --to glb");
    assert!(
        said.contains("3 of 3 files converted") && !said.contains("one take"),
        "{said}"
    );
}
