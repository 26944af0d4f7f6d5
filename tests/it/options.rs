//! The options of the program: one meaning in every command, every guess said, and none that does nothing.

use std::path::PathBuf;
use std::process::{Command, Output};

use mocap::Pose;
use mocap::glam::Vec3;
use mocap::scene::NodeId;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for name in ["lecture_Test.bvh", "cmu_short.bvh", "z_up_dab.bvh"] {
            std::fs::copy(format!("fixtures/real/{name}"), folder.path(name)).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs the program with arguments that are separated by spaces.
    fn run(&self, arguments: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_mocap"))
            .args(arguments.split(' '))
            .current_dir(self.0.path())
            .output()
            .unwrap()
    }

    /// What a command says that succeeds.
    fn words(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let words = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{arguments}: {words}");
        words
    }

    /// Checks that a command is wrong usage for this reason, and writes nothing.
    fn is_wrong_usage(&self, arguments: &str, reason: &str) {
        let count = || self.0.path().read_dir().unwrap().count();
        let before = count();
        let output = self.run(arguments);
        let words = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments}: {words}");
        assert!(words.contains(reason), "{arguments}: {words}");
        assert_eq!(count(), before, "{arguments}");
    }

    /// The JSON in the first line of a CSV file.
    fn header(&self, name: &str) -> serde_json::Value {
        let text = std::fs::read_to_string(self.path(name)).unwrap();
        let line = text.lines().next().unwrap();
        serde_json::from_str(line.strip_prefix("# ").unwrap()).unwrap()
    }

    /// The position of the elbow in the last frame.
    fn elbow(&self, name: &str) -> Vec3 {
        let scene = mocap::import(self.path(name)).unwrap();
        Pose::at_tick(&scene, 0, 9.0).unwrap().position(NodeId(1))
    }
}

/// The shoulder of frame n is at (0.1 (n + 1), 0.02 n, 0), the elbow is 2 from it.
#[test]
fn unit_and_up_are_those_of_the_input_in_every_command() {
    let folder = Folder::new();
    let input = folder.elbow("lecture_Test.bvh");
    // To glTF: inches with +Z up become metres with +Y up.
    folder.words("convert lecture_Test.bvh out.glb --unit inch --up z");
    let expected = 0.0254 * Vec3::new(input.x, input.z, -input.y);
    assert!(folder.elbow("out.glb").abs_diff_eq(expected, 1e-6));
    // To BVH and to arrays: inches with +Z up become centimetres with +Y up.
    let expected = 100.0 * expected;
    let options = "--unit inch --up z --out-unit cm --out-up y";
    let words = folder.words(&format!("convert lecture_Test.bvh out.bvh --verify {options}"));
    assert!(!words.contains("unit:") && !words.contains("up:"), "{words}");
    assert!(folder.elbow("out.bvh").abs_diff_eq(expected, 1e-4));
    let words = folder.words(&format!("fk lecture_Test.bvh -o out.csv {options}"));
    assert!(!words.contains("unit:") && !words.contains("up:"), "{words}");
    let text = std::fs::read_to_string(folder.path("out.csv")).unwrap();
    let row: Vec<&str> = text
        .lines()
        .rfind(|line| line.contains(",Elbow,"))
        .unwrap()
        .split(',')
        .collect();
    let found = Vec3::from_array([row[3], row[4], row[5]].map(|cell| cell.parse().unwrap()));
    assert!(found.abs_diff_eq(expected, 1e-4), "{found} {expected}");
    // Where nothing is converted, arrays state what is named.
    folder.words("fk lecture_Test.bvh -o out.csv --unit inch --up z");
    let header = folder.header("out.csv");
    assert_eq!(
        (&header["metres_per_unit"], &header["up"]),
        (&0.0254.into(), &"z".into())
    );
    let shown = folder.run("skeleton lecture_Test.bvh --unit inch --up z --json");
    let shown: serde_json::Value = serde_json::from_slice(&shown.stdout).unwrap();
    assert_eq!(
        (&shown["unit"]["name"], &shown["up"]["value"]),
        (&"inch".into(), &"z".into())
    );
    assert_eq!(shown["up"]["reason"], "--up says so");
}

#[test]
fn a_picture_stands_on_the_axis_that_is_named() {
    let folder = Folder::new();
    for command in ["sheet", "gif"] {
        let extension = if command == "sheet" { "svg" } else { "gif" };
        let mut files = Vec::new();
        for up in ["auto", "y", "z"] {
            let output = format!("{up}.{extension}");
            folder.words(&format!("{command} cmu_short.bvh -o {output} --up {up}"));
            files.push(std::fs::read(folder.path(&output)).unwrap());
        }
        assert!(files[0] == files[1] && files[0] != files[2], "{command}");
    }
}

#[test]
fn every_guess_in_a_header_is_said() {
    let folder = Folder::new();
    for (options, unit, up) in [
        ("", false, false),
        ("--out-unit m", true, false),
        ("--out-up z", false, true),
        ("--out-unit m --out-up z", true, true),
        ("--contacts", true, true),
        ("--contacts --unit cm", false, true),
    ] {
        let options = if options.is_empty() {
            String::new()
        } else {
            format!(" {options}")
        };
        let words = folder.words(&format!("fk cmu_short.bvh -o out.csv{options}"));
        let said = |topic: &str| words.lines().any(|line| line.starts_with(&format!("{topic}: ")));
        assert_eq!((said("unit"), said("up")), (unit, up), "{options}: {words}");
        let header = folder.header("out.csv");
        // Nobody but a guess or the caller knows them.
        assert_eq!(
            header["metres_per_unit"].is_null(),
            !unit && !options.contains("unit"),
            "{options}"
        );
        assert_eq!(header["up"].is_null(), !up, "{options}");
        let guesses = header["provenance"]["assumptions"].as_array();
        assert_eq!(
            guesses.map_or(0, Vec::len),
            usize::from(unit) + usize::from(up),
            "{options}"
        );
    }
}

#[test]
fn bvh_stays_upright_where_z_is_up() {
    let folder = Folder::new();
    let words = folder.words("convert z_up_dab.bvh out.bvh --in-place --verify");
    assert!(words.contains("up: z, because"), "{words}");
    let words = folder.words("convert z_up_dab.bvh out.bvh --root-motion --out-up y --out-unit m --verify --force");
    assert!(words.contains("unit: "), "{words}");
}

#[test]
fn a_map_of_bones_is_understood_by_every_command_that_uses_bones() {
    let folder = Folder::new();
    let map = folder.run("skeleton cmu_short.bvh --json").stdout;
    std::fs::write(folder.path("whole.json"), &map).unwrap();
    let wrong = String::from_utf8(map).unwrap().replace("\"LeftFoot\"", "\"Leftfoot\"");
    std::fs::write(folder.path("wrong.json"), wrong).unwrap();
    std::fs::write(
        folder.path("short.json"),
        r#"{"bones": {"head": "Neck", "neck": null}}"#,
    )
    .unwrap();
    for command in [
        "convert cmu_short.bvh out.glb",
        "convert cmu_short.bvh out.bvh --out-unit m --force",
        "fk cmu_short.bvh -o out.npz --out-unit m",
        "sheet cmu_short.bvh -o out.svg --t-pose",
        "skeleton cmu_short.bvh",
    ] {
        let plain = folder.run(command);
        let words = folder.words(&format!("{command} --map whole.json"));
        assert_eq!(words, String::from_utf8(plain.stderr).unwrap(), "{command}");
        let output = folder.run(&format!("{command} --map wrong.json"));
        let words = String::from_utf8(output.stderr).unwrap();
        assert!(
            !output.status.success() && words.contains("\"Leftfoot\""),
            "{command}: {words}"
        );
    }
    // A shorter body has greater units.
    let unit = |options: &str| {
        let words = folder.words(&format!("convert cmu_short.bvh out.glb{options}"));
        words
            .lines()
            .find(|line| line.starts_with("unit: "))
            .unwrap()
            .to_owned()
    };
    assert_ne!(unit(""), unit(" --map short.json"));
    folder.is_wrong_usage("convert cmu_short.bvh new.glb --map none.json", "No such file");
    std::fs::write(folder.path("empty.json"), "{}").unwrap();
    folder.is_wrong_usage(
        "convert cmu_short.bvh new.glb --map empty.json",
        "there is no object \"bones\"",
    );
}

#[test]
fn an_option_that_would_do_nothing_is_refused() {
    let folder = Folder::new();
    let bvh = "lecture_Test.bvh new.bvh";
    let glb = "lecture_Test.bvh new.glb";
    for (arguments, option, advice) in [
        (format!("convert {glb} --order XYZ"), "--order", "write .bvh"),
        (format!("convert {glb} --digits 3"), "--digits", "write .bvh"),
        (format!("convert {glb} --channels 6"), "--channels", "write .bvh"),
        (format!("convert {glb} --out-unit m"), "--out-unit", "write .bvh"),
        (format!("convert {glb} --out-up y"), "--out-up", "write .bvh"),
        (format!("convert {glb} --embed"), "--embed", "write .gltf"),
        (format!("convert {glb} --to glb"), "--to", "the name of the output"),
        (format!("convert {glb} --shard 1/2"), "--shard", "-o FOLDER"),
        (format!("convert {glb} --allow-empty"), "--allow-empty", "-o FOLDER"),
        (format!("convert {glb} --progress none"), "--progress", "-o FOLDER"),
        (format!("convert {bvh} --mesh none"), "--mesh", "leave it out"),
        (
            format!("convert {bvh} --keep-constant"),
            "--keep-constant",
            "leave it out",
        ),
        (format!("convert {bvh} --embed"), "--embed", "leave it out"),
        (format!("convert {bvh} --compress int16"), "--compress", "--digits"),
        (format!("convert {bvh} --max-error 1mm"), "--max-error", "--digits"),
        (format!("convert {bvh} --unit cm"), "--unit", "--out-unit"),
        (format!("convert {bvh} --up z"), "--up", "--out-up"),
        (
            "convert . -o new --to bvh --mesh none".to_owned(),
            "--mesh",
            "leave it out",
        ),
        ("convert . -o new --digits 3".to_owned(), "--digits", "write .bvh"),
        (
            "fk lecture_Test.bvh -o new.npz --spreadsheet".to_owned(),
            "--spreadsheet",
            ".csv",
        ),
        (
            "pose lecture_Test.bvh --tick 0 --spreadsheet".to_owned(),
            "--spreadsheet",
            "--csv",
        ),
    ] {
        folder.is_wrong_usage(&arguments, &format!("{option} would do nothing: "));
        folder.is_wrong_usage(&arguments, advice);
    }
    // What is the default does something no more than another value.
    folder.is_wrong_usage(&format!("convert {bvh} --mesh skinned"), "--mesh would do nothing");
    std::fs::write(folder.path("map.json"), r#"{"bones": {}}"#).unwrap();
    for arguments in [
        format!("convert {bvh} --map map.json"),
        format!("convert {glb} --unit m --up y --map map.json"),
        "fk lecture_Test.bvh -o new.npz --map map.json".to_owned(),
        "sheet lecture_Test.bvh -o new.svg --map map.json".to_owned(),
    ] {
        folder.is_wrong_usage(&arguments, "--map would do nothing: ");
    }
}

#[cfg(feature = "parquet")]
#[test]
fn an_inventory_takes_no_options_of_arrays() {
    let folder = Folder::new();
    for option in ["--rot 6d", "--fps 30", "--unit m", "--out-up z", "--velocities"] {
        let name = option.split(' ').next().unwrap();
        folder.is_wrong_usage(
            &format!("pack lecture_Test.bvh -o new --inventory {option}"),
            &format!("{name} would do nothing: "),
        );
    }
}

/// A spreadsheet takes a cell that begins with one of these for a formula, whether it is quoted or not.
#[test]
fn no_cell_for_a_spreadsheet_is_a_formula() {
    let folder = Folder::new();
    let mut text = std::fs::read_to_string("fixtures/real/lecture_Test.bvh").unwrap();
    let names = ["=1+1", "@SUM(A1,\"b\")", "-x"];
    for (name, new) in std::iter::zip(["Shoulder", "Elbow", "Wrist"], names) {
        text = text.replace(name, new);
    }
    std::fs::write(folder.path("names.bvh"), text).unwrap();
    for option in ["", " --spreadsheet"] {
        folder.words(&format!("fk names.bvh -o out.csv --up z --out-up y{option}"));
        let arrays = cells(&std::fs::read_to_string(folder.path("out.csv")).unwrap());
        let pose = folder.run(&format!("pose names.bvh --tick 3 --csv{option}"));
        let pose = cells(&String::from_utf8(pose.stdout).unwrap());
        // Numbers stay numbers.
        let is_negative = |cell: &String| cell.starts_with('-') && cell.parse::<f64>().is_ok();
        assert!(arrays.iter().any(is_negative));
        for cells in [arrays, pose] {
            let is_formula = |cell: &str| cell.starts_with(['=', '+', '-', '@']) && cell.parse::<f64>().is_err();
            for name in names {
                let expected = if option.is_empty() {
                    name.to_owned()
                } else {
                    format!("'{name}")
                };
                assert!(cells.contains(&expected), "{name}: {cells:?}");
            }
            assert_eq!(cells.iter().any(|cell| is_formula(cell)), option.is_empty());
        }
    }
    // The header is one cell, whatever it holds.
    let text = std::fs::read_to_string(folder.path("out.csv")).unwrap();
    let header = cells(&text).swap_remove(0);
    let header: serde_json::Value = serde_json::from_str(header.strip_prefix("# ").unwrap()).unwrap();
    assert_eq!(header["joints"][0]["name"], names[0]);
}

/// The cells of a text as RFC 4180 has them.
fn cells(text: &str) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    let mut characters = text.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if is_quoted && characters.peek() == Some(&'"') => {
                characters.next();
                cell.push('"');
            }
            '"' if is_quoted || cell.is_empty() => is_quoted = !is_quoted,
            ',' | '\n' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            _ => cell.push(c),
        }
    }
    cells
}

#[cfg(not(feature = "parquet"))]
#[test]
fn a_build_without_parquet_names_the_feature() {
    let folder = Folder::new();
    for arguments in [
        "pack lecture_Test.bvh -o new --rot 6d",
        "pack",
        "fk lecture_Test.bvh -o new.parquet",
    ] {
        folder.is_wrong_usage(arguments, "build it with `--features parquet`");
    }
}

#[cfg(not(feature = "fbx"))]
#[test]
fn a_build_without_fbx_names_the_feature() {
    let folder = Folder::new();
    std::fs::copy("fixtures/real/huesitos.fbx", folder.path("a.fbx")).unwrap();
    for arguments in ["info a.fbx", "info a.fbx --from fbx", "convert a.fbx a.glb"] {
        let output = folder.run(arguments);
        let words = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments}: {words}");
        assert!(words.contains("error[missing-feature]"), "{arguments}: {words}");
        assert!(words.contains("build it with `--features fbx`"), "{arguments}: {words}");
    }
}

#[test]
fn a_page_shows_the_part_and_the_rate_that_are_asked_for() {
    let folder = Folder::new();
    folder.words("view lecture_Test.bvh -o all.html");
    // Ten frames a second; from the third to the ninth at five frames a second are four.
    folder.words("view lecture_Test.bvh -o part.html --trim 2f..8f --fps 5 --unit dm --up z");
    let page = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    let all = r#""frames":10,"ticksPerSecond":10.0,"metresPerUnit":1.0,"up":"+y""#;
    assert!(page("all.html").contains(all));
    let part = r#""frames":4,"ticksPerSecond":5.0,"metresPerUnit":0.1,"up":"+z""#;
    assert!(page("part.html").contains(part));
    std::fs::write(folder.path("wrong.json"), r#"{"bones": {"head": "Haed"}}"#).unwrap();
    let output = folder.run("view cmu_short.bvh -o new.html --map wrong.json");
    assert!(!output.status.success() && String::from_utf8(output.stderr).unwrap().contains("Haed"));
    folder.is_wrong_usage("view lecture_Test.bvh -o new.html --fps 0", "frame rate must be");
}
