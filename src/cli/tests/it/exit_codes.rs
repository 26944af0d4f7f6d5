//! The meaning of the exit codes in every command: a table of commands and failures, as in `mocap --help`.

use std::fs;
use std::process::Command;

use crate::at_root;
use crate::program::{Folder, STATE_HOME, words};

/// A command with one motion, `IN`, and one output, `OUT`.
struct Case {
    arguments: &'static str,
    /// The extension of the output; empty if the command writes nothing.
    extension: &'static str,
    /// Whether a file without motion is an error.
    needs_motion: bool,
    /// The command for many motions, with the bad file `bad`; empty if many motions go into one output.
    many: &'static str,
}

const fn writes(arguments: &'static str, extension: &'static str, many: &'static str) -> Case {
    Case {
        arguments,
        extension,
        needs_motion: false,
        many,
    }
}

const fn moves(arguments: &'static str, extension: &'static str, many: &'static str) -> Case {
    Case {
        needs_motion: true,
        ..writes(arguments, extension, many)
    }
}

const fn prints(arguments: &'static str, many: &'static str) -> Case {
    writes(arguments, "", many)
}

/// Every command that takes a motion.
const CASES: &[Case] = &[
    writes("convert IN OUT", "glb", "convert w.bvh bad.bvh -o many"),
    moves(
        "edit IN -o OUT --step in-place",
        "glb",
        "edit w.bvh bad.bvh -o many/ --step in-place",
    ),
    moves("clean IN -o OUT", "glb", "clean w.bvh bad.bvh -o many/"),
    moves(
        "retarget IN --character w.bvh -o OUT",
        "glb",
        "retarget v.bvh bad.bvh --character w.bvh -o many/",
    ),
    moves(
        "robot IN --robot robot.urdf -o OUT",
        "glb",
        "robot w.bvh bad.bvh --robot robot.urdf -o many",
    ),
    moves("graph IN -o OUT --rate 120 --window 0.05 --threshold 1m", "json", ""),
    writes("run IN.json", "glb", "run many.json"),
    writes("fk IN -o OUT", "npz", ""),
    moves("angles IN -o OUT", "mot", ""),
    moves("gait IN", "", ""),
    writes("view IN -o OUT", "html", "view folder -o many.html"),
    writes("sheet IN -o OUT", "png", ""),
    writes("gif IN -o OUT --width 64 --height 64 --rate 2", "gif", ""),
    writes("plot IN -o OUT --joint Hips", "svg", ""),
    #[cfg(feature = "parquet")]
    writes("pack IN -o OUT", "folder", "pack w.bvh bad.bvh -o many"),
    prints("info IN", ""),
    prints("skeleton IN", ""),
    prints("dump IN", ""),
    prints("pose IN", ""),
    prints("chain IN Hips", ""),
    moves("play IN --vmc 9", "", ""),
    prints("check IN", "check w.bvh bad.bvh"),
    prints("survey IN", "survey w.bvh bad.bvh"),
    moves("index IN -o OUT", "mdb", "index w.bvh bad.bvh -o many.mdb"),
    writes("match moves.mdb --path 0/0+0/1 --on IN -o OUT", "glb", ""),
    moves("find moves.mdb --pose IN@0", "", ""),
    prints("verify IN w.glb --max-error 1m", ""),
    moves("score IN w.npz --robot robot.urdf", "", ""),
];

/// Commands that do not read the table's motion. `solve` is `convert` for positions, and `mcp` offers the other
/// commands as tools. `analog` and `forces` only read C3D, and `record` and `bridge` listen to a network.
const OTHERS: &[&str] = &[
    "analog",
    "bridge",
    "completions",
    "doctor",
    "forces",
    "formats",
    "man",
    "mcp",
    "merge-manifest",
    "record",
    "solve",
];

impl Case {
    fn name(&self) -> &str {
        self.arguments.split(' ').next().unwrap()
    }

    fn is_batch(&self) -> bool {
        ["pack", "check", "survey", "index"].contains(&self.name())
    }

    /// The arguments for an input and an output; a job is a file.
    fn with(&self, folder: &Folder, input: &str, output: &str) -> String {
        if self.name() == "run" {
            let job = serde_json::json!({"source": {"inputs": [input]}, "write": {"output": output}});
            folder.write(&format!("{input}.json"), job.to_string().as_bytes());
        }
        self.arguments.replace("IN", input).replace("OUT", output)
    }

    fn output(&self) -> String {
        format!("new.{}", self.extension)
    }

    fn ends_with(&self, folder: &Folder, status: i32, failure: &str, arguments: &str) {
        let output = folder.run(arguments);
        let said = words(&output);
        assert_eq!(output.status.code(), Some(status), "{failure}: {arguments}: {said}");
    }
}

fn folder() -> Folder {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let text = String::from_utf8(folder.read("cmu_short.bvh")).unwrap();
    for name in ["w.bvh", "v.bvh", "folder/w.bvh"] {
        folder.write(name, text.as_bytes());
    }
    for name in ["bad.bvh", "folder/bad.bvh"] {
        folder.write(name, &text.as_bytes()[..900]);
    }
    let (hierarchy, _) = text.split_once("MOTION").unwrap();
    folder.write(
        "still.bvh",
        format!("{hierarchy}MOTION\nFrames: 0\nFrame Time: 0.01\n").as_bytes(),
    );
    folder.write("robot.urdf", &fs::read(at_root("fixtures/robots/h1.urdf")).unwrap());
    folder.succeeds("convert w.bvh w.glb");
    folder.succeeds("index w.bvh -o moves.mdb");
    folder.succeeds("robot w.bvh --robot robot.urdf -o w.npz");
    folder.write(
        "many.json",
        br#"{"source": {"inputs": ["w.bvh", "bad.bvh"]}, "write": {"output": "many/", "to": "glb"}}"#,
    );
    folder
}

#[test]
fn a_file_is_at_fault() {
    let folder = folder();
    for case in CASES {
        let output = case.output();
        for (failure, input) in [("a missing file", "none.bvh"), ("a broken file", "bad.bvh")] {
            case.ends_with(&folder, 1, failure, &case.with(&folder, input, &output));
        }
        let still = case.with(&folder, "still.bvh", &output);
        let status = i32::from(case.needs_motion || case.name() == "verify");
        case.ends_with(&folder, status, "a file without motion", &still);
        if case.extension.is_empty() {
            continue;
        }
        let unwritable = case.with(&folder, "w.bvh", &format!("none/{output}"));
        // The folder of the outputs is created.
        if case.name() != "pack" {
            case.ends_with(&folder, 1, "an output that cannot be written", &unwritable);
            let input = format!("copy.{}", case.extension);
            folder.write(&input, &folder.read("w.bvh"));
            let own = case.with(&folder, &input, &input);
            case.ends_with(&folder, 1, "the input as output", &own);
            case.ends_with(&folder, 1, "the input as output", &format!("{own} --force"));
        }
        if case.extension == "glb" {
            folder.write("other.glb", br#"{"asset": {"version": "2.0"}}"#);
            let exists = case.with(&folder, "w.bvh", "other.glb");
            case.ends_with(&folder, 1, "an output that exists", &exists);
            case.ends_with(&folder, 0, "an output that exists", &format!("{exists} --force"));
        }
    }
}

#[test]
fn the_arguments_are_at_fault() {
    let folder = folder();
    for case in CASES {
        let good = case.with(&folder, "w.bvh", &case.output());
        case.ends_with(&folder, 2, "an unknown option", &format!("{good} --nonsense"));
        if case.name() != "run" {
            case.ends_with(&folder, 2, "a bad value", &format!("{good} --retime 0"));
            case.ends_with(&folder, 2, "a bad value", &format!("{good} --from xyz"));
            // A file without this clip, among many files, is a failed file.
            let status = if case.is_batch() { 1 } else { 2 };
            case.ends_with(&folder, status, "a clip that is not there", &format!("{good} --clip 7"));
            case.ends_with(
                &folder,
                status,
                "a clip that is not there",
                &format!("{good} --clip nobody"),
            );
        }
    }
    for arguments in [
        "fk w.bvh -o new.npz --joints (",
        "gif w.bvh -o new.gif --width 0",
        "gif w.bvh -o new.gif --width 16384 --height 16384",
        "gif w.bvh -o new.gif --rate 0",
        "gif w.bvh -o new.gif --speed nan",
        "sheet w.bvh -o new.png --poses 0",
        "plot w.bvh -o new.svg --joint Nobody",
        "convert w.bvh new.glb --trim 5..2",
        "view w.bvh -o new.html --trim 5..2",
        "fk w.bvh -o new.npz --trim 5..2",
        "robot w.bvh --robot robot.urdf -o new.npz --trim 5f..2f",
        "convert w.bvh new.glb --trim 75f..",
        "convert w.bvh new.glb --rest frame:75",
        "edit w.bvh -o new.glb --step nonsense",
        "edit w.bvh -o new.glb --step smooth:cut-off=0",
        "convert w.bvh new.xyz",
        "run w.bvh.json --to xyz",
    ] {
        folder.refuses(arguments, 2, "");
    }
    folder.write("wrong.json", br#"{"source": {"inputs": ["w.bvh"]}, "wirte": {}}"#);
    folder.refuses("run wrong.json", 2, "did you mean write?");
    folder.refuses("run none.json", 1, "none.json");
}

/// Commands whose inputs are not motions, with their files.
#[test]
fn another_file_is_at_fault() {
    let folder = folder();
    let points = fs::read(at_root("fixtures/arrays/points_smpl22.npy")).unwrap();
    folder.write("p.npy", &points);
    folder.write("bad.npy", &points[..900]);
    folder.write("own.glb", &points);
    folder.write("empty/notes", b"");
    for (status, arguments) in [
        (1, "solve none.npy --joint-set smpl22 -o new.glb"),
        (1, "solve bad.npy --joint-set smpl22 -o new.glb"),
        (1, "solve p.npy --joint-set smpl22 -o none/new.glb"),
        (1, "solve own.glb --joint-set smpl22 -o own.glb --force"),
        (2, "solve p.npy --joint-set nonsense -o new.glb"),
        (2, "solve p.npy --joint-set smpl22 -o new.glb --clip 7"),
        (2, "solve p.npy --joint-set smpl22 -o new.glb --nonsense"),
        (3, "solve p.npy bad.npy --joint-set smpl22 -o many/"),
        (1, "merge-manifest none"),
        (1, "merge-manifest empty"),
        (2, "merge-manifest"),
        (2, "formats --nonsense"),
        (1, "mcp --root none"),
        (1, "mcp --root w.bvh"),
        (2, "mcp"),
        (1, "record vmc:0 -o none/new.glb --seconds 0"),
        (2, "record vmc:0 -o new.xyz"),
        (2, "record vmc:0 -o new.glb --seconds nan"),
        (1, "bridge vmc:0 --onto none.vrm --vmc 9"),
        (1, "bridge vmc:0 --onto bad.bvh --vmc 9"),
        (2, "bridge vmc:0 --onto w.bvh"),
        (2, "bridge vmc:0 --onto w.bvh --vmc 0"),
        (1, "find none.mdb --pose w.bvh@0"),
        (2, "find moves.mdb --pose w.bvh@99999"),
        (1, "match w.bvh --path 0/0+0/1 --on w.bvh -o new.glb"),
        (2, "match moves.mdb --path nonsense --on w.bvh -o new.glb"),
        (1, "retarget w.bvh --character none.glb -o new.glb"),
        (1, "robot w.bvh --robot w.bvh -o new.npz"),
    ] {
        let output = folder.run(arguments);
        assert_eq!(output.status.code(), Some(status), "{arguments}: {}", words(&output));
        assert!(!folder.path("new.glb").exists(), "{arguments}");
    }
}

#[test]
fn some_of_many_files_failed() {
    let folder = folder();
    for case in CASES.iter().filter(|case| !case.many.is_empty()) {
        let output = folder.run(case.many);
        assert_eq!(output.status.code(), Some(3), "{}: {}", case.many, words(&output));
        if !case.many.starts_with("run") && !case.many.starts_with("view") {
            let all_bad = case
                .many
                .replace("w.bvh bad.bvh", "bad.bvh")
                .replace("v.bvh bad.bvh", "bad.bvh");
            let output = folder.run(&all_bad.replace("many", "none"));
            assert_eq!(output.status.code(), Some(1), "{all_bad}: {}", words(&output));
        }
    }
    // `retarget` skips bad motions. For other commands, one bad input of a single output is an error.
    let output = folder.run("retarget v.bvh bad.bvh --character w.bvh -o some.glb");
    assert_eq!(output.status.code(), Some(3), "{}", words(&output));
    assert!(words(&output).contains("bad.bvh") && folder.path("some.glb").exists());
    folder.refuses("retarget bad.bvh bad.bvh --character w.bvh -o none.glb", 1, "bad.bvh");
    folder.refuses("sheet w.bvh bad.bvh -o new.png", 1, "bad.bvh");
}

#[test]
fn every_command_is_in_the_table() {
    let help = String::from_utf8(Folder::of_real(&[]).run("--help").stdout).unwrap();
    assert!(help.contains("Exit codes:\n  0  done\n"), "{help}");
    for asks in ["--help", "-h", "help"] {
        let help = String::from_utf8(Folder::of_real(&[]).run(asks).stdout).unwrap();
        assert!(
            help.contains("\nConvert and change:\n") || help.contains("\n  Convert and change "),
            "{asks}: {help}"
        );
    }
    let (commands, _) = help.split_once("Options:").unwrap();
    let entries = commands.lines().filter_map(|line| line.strip_prefix("  "));
    let entries = entries.filter(|entry| entry.starts_with(|c: char| c.is_ascii_lowercase()));
    let names: Vec<_> = entries.filter_map(|entry| entry.split(' ').next()).collect();
    assert!(names.len() > 12, "{names:?}");
    for name in names {
        let is_known = CASES.iter().any(|case| case.name() == name) || OTHERS.contains(&name);
        assert!(is_known || name == "pack" && cfg!(not(feature = "parquet")), "{name}");
    }
}

/// `ulimit -f` stops a write like a full disk. The signal must not end the program.
#[cfg(unix)]
#[test]
fn a_full_disk_is_an_error_and_no_signal() {
    let folder = folder();
    for name in 0..30 {
        folder.write(
            &format!("takes/{name}.bvh"),
            &fs::read(at_root("fixtures/dialects/plain.bvh")).unwrap(),
        );
    }
    let limited = |kilobytes: usize, arguments: &str| {
        let output = Command::new("bash")
            .args(["-c", &format!("ulimit -f {kilobytes}; exec \"$@\""), "bash"])
            .arg(env!("CARGO_BIN_EXE_mocap"))
            .env("XDG_STATE_HOME", STATE_HOME)
            .args(arguments.split(' '))
            .current_dir(folder.path(""))
            .output()
            .unwrap();
        assert!(words(&output).contains("arge"), "{arguments}: {}", words(&output));
        output.status.code()
    };
    for case in CASES.iter().filter(|case| !case.extension.is_empty()) {
        let arguments = case.with(&folder, "w.bvh", &case.output());
        assert_eq!(limited(1, &arguments), Some(1), "{arguments}");
    }
    // There is space for all outputs, but not for the manifest.
    assert_eq!(limited(8, "convert takes -o out"), Some(3));
}

/// Every writing command has `--force`, `--to` and `--quiet`. With `--quiet` it prints nothing.
#[test]
fn every_command_that_writes_has_the_same_options() {
    let folder = folder();
    for case in CASES.iter().filter(|case| !case.extension.is_empty()) {
        let help = String::from_utf8(folder.run(&format!("{} --help", case.name())).stdout).unwrap();
        for option in ["--force", "--to <", "-q, --quiet"] {
            assert!(help.contains(option), "{}: {option}", case.name());
        }
        let arguments = format!("{} -q", case.with(&folder, "w.bvh", &case.output()));
        assert_eq!(folder.succeeds(&arguments), "", "{arguments}");
        // The name of the output determines its format.
        if !["robot", "pack"].contains(&case.name()) {
            let format = if case.extension == "html" {
                "html"
            } else {
                case.extension
            };
            let arguments = case.with(&folder, "w.bvh", &case.output());
            folder.refuses(&format!("{arguments} --to {format}"), 2, "--to would do nothing");
        }
        let to_stream = case.with(&folder, "w.bvh", "-");
        if case.name() != "pack" {
            let output = folder.run(&format!("{to_stream} -q --to {}", case.extension));
            assert!(
                output.status.success() && !output.stdout.is_empty(),
                "{to_stream}: {}",
                words(&output)
            );
            assert_eq!(words(&output), "", "{to_stream}");
        }
    }
}
