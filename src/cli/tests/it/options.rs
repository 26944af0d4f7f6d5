//! The options of the program: one meaning in every command, every assumption reported, and no option without effect.

use mocap::Pose;
use mocap::glam::Vec3;
use mocap::scene::NodeId;

use crate::at_root;
use crate::program::Folder;
use crate::sample::Sample;

fn folder() -> Folder {
    Folder::of_real(&["lecture_Test.bvh", "cmu_short.bvh", "z_up_dab.bvh"])
}

/// The JSON in the first line of a CSV file.
fn header(folder: &Folder, name: &str) -> serde_json::Value {
    let text = String::from_utf8(folder.read(name)).unwrap();
    let line = text.lines().next().unwrap();
    serde_json::from_str(line.strip_prefix("# ").unwrap()).unwrap()
}

/// The position of the elbow in the last frame.
fn elbow(folder: &Folder, name: &str) -> Vec3 {
    let scene = mocap::import(folder.path(name)).unwrap();
    Pose::at_tick(&scene, 0, 9.0).unwrap().position(NodeId(1))
}

/// The shoulder in frame n is at (0.1 (n + 1), 0.02 n, 0), and the elbow is 2 units away.
#[test]
fn unit_and_up_are_those_of_the_input_in_every_command() {
    let folder = folder();
    let input = elbow(&folder, "lecture_Test.bvh");
    // To glTF: inches with +Z up become metres with +Y up.
    folder.succeeds("convert lecture_Test.bvh out.glb --unit inch --up z");
    let expected = 0.0254 * Vec3::new(input.x, input.z, -input.y);
    assert!(elbow(&folder, "out.glb").abs_diff_eq(expected, 1e-6));
    // To BVH and to arrays: inches with +Z up become centimetres with +Y up.
    let expected = 100.0 * expected;
    let options = "--unit inch --up z --out-unit cm --out-up y";
    let words = folder.succeeds(&format!("convert lecture_Test.bvh out.bvh --verify {options}"));
    assert!(!words.contains("unit:") && !words.contains("up:"), "{words}");
    assert!(elbow(&folder, "out.bvh").abs_diff_eq(expected, 1e-4));
    let words = folder.succeeds(&format!("fk lecture_Test.bvh -o out.csv {options}"));
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
    // Without a conversion, arrays have the stated unit and axis.
    folder.succeeds("fk lecture_Test.bvh -o out.csv --unit inch --up z");
    let header = header(&folder, "out.csv");
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
    assert_eq!(shown["up"]["reason"], "--up states it");
}

#[test]
fn a_picture_stands_on_the_axis_that_is_named() {
    let folder = folder();
    for command in Sample::new().some(["sheet", "gif"], 2) {
        let extension = if command == "sheet" { "svg" } else { "gif" };
        let mut files = Vec::new();
        for up in ["auto", "y", "z"] {
            let output = format!("{up}.{extension}");
            folder.succeeds(&format!("{command} cmu_short.bvh -o {output} --up {up}"));
            files.push(std::fs::read(folder.path(&output)).unwrap());
        }
        assert!(files[0] == files[1] && files[0] != files[2], "{command}");
    }
}

#[test]
fn every_guess_in_a_header_is_said() {
    let folder = folder();
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
        let words = folder.succeeds(&format!("fk cmu_short.bvh -o out.csv{options}"));
        let said = |topic: &str| words.lines().any(|line| line.starts_with(&format!("{topic}: ")));
        assert_eq!((said("unit"), said("up")), (unit, up), "{options}: {words}");
        let header = header(&folder, "out.csv");
        // The unit and the axis are inferred or stated by the caller.
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
    let folder = folder();
    let words = folder.succeeds("convert z_up_dab.bvh out.bvh --in-place --verify");
    assert!(words.contains("up: z, because"), "{words}");
    let words = folder.succeeds("convert z_up_dab.bvh out.bvh --root-motion --out-up y --out-unit m --verify --force");
    assert!(words.contains("unit: "), "{words}");
}

#[test]
fn a_map_of_bones_is_understood_by_every_command_that_uses_bones() {
    let folder = folder();
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
        let words = folder.succeeds(&format!("{command} --map whole.json"));
        // The provenance in the file says how sure the bones are, so files may differ by some bytes.
        let lines = |words: &str| {
            let kept = words
                .lines()
                .filter(|line| !line.ends_with(": replaced an earlier output of mocap"));
            let same = kept.map(|line| {
                line.rsplit_once(", ")
                    .filter(|(_, end)| end.ends_with(" bytes"))
                    .map_or(line, |(begin, _)| begin)
            });
            same.map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(
            lines(&words),
            lines(&String::from_utf8(plain.stderr).unwrap()),
            "{command}"
        );
        let output = folder.run(&format!("{command} --map wrong.json"));
        let words = String::from_utf8(output.stderr).unwrap();
        assert!(
            !output.status.success() && words.contains("\"Leftfoot\""),
            "{command}: {words}"
        );
    }
    // A shorter body has a larger inferred unit.
    let unit = |options: &str| {
        let words = folder.succeeds(&format!("convert cmu_short.bvh out.glb{options}"));
        words
            .lines()
            .find(|line| line.starts_with("unit: "))
            .unwrap()
            .to_owned()
    };
    assert_ne!(unit(""), unit(" --map short.json"));
    folder.refuses(
        "convert cmu_short.bvh new.glb --map none.json",
        2,
        "the file or folder does not exist",
    );
    std::fs::write(folder.path("empty.json"), "{}").unwrap();
    folder.refuses(
        "convert cmu_short.bvh new.glb --map empty.json",
        2,
        "there is no object \"bones\": write {\"bones\": {\"hips\": \"NAME\", ...}}",
    );
}

#[test]
fn an_option_that_would_do_nothing_is_refused() {
    let folder = folder();
    let bvh = "lecture_Test.bvh new.bvh";
    let glb = "lecture_Test.bvh new.glb";
    for (arguments, option, advice) in [
        (format!("convert {glb} --to glb"), "--to", "the extension of the output"),
        (format!("convert {glb} --shard 1/2"), "--shard", "-o FOLDER"),
        (format!("convert {glb} --allow-empty"), "--allow-empty", "-o FOLDER"),
        (format!("convert {glb} --progress none"), "--progress", "-o FOLDER"),
        (
            format!("convert {glb} --shell-distance 3cm"),
            "--shell-distance",
            "add --max-error",
        ),
        (format!("convert {bvh} --unit cm"), "--unit", "--out-unit"),
        (format!("convert {bvh} --up z"), "--up", "--out-up"),
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
        folder.refuses(&arguments, 2, &format!("{option} would do nothing: "));
        folder.refuses(&arguments, 2, advice);
    }
    // An option without effect is rejected even with its default value.
    folder.refuses(
        &format!("convert {bvh} --mesh skinned"),
        2,
        "--mesh has no effect on BVH",
    );
    folder.refuses(
        "convert . -o new --to bvh --mesh none",
        2,
        "--mesh has no effect on BVH",
    );
    folder.refuses("convert . -o new --digits 3", 2, "--digits has no effect on glTF");
    for (arguments, refusal) in [
        (
            "edit lecture_Test.bvh -o new.glb --step mirror --target unity",
            "--target has no effect on glTF",
        ),
        (
            "edit lecture_Test.bvh -o new.bvh --step mirror --max-error 1mm",
            "--max-error has no effect on BVH",
        ),
        (
            "retarget cmu_short.bvh cmu_short.bvh -o new.glb --fbx-rest rotation",
            "--fbx-rest has no effect on glTF",
        ),
        (
            "retarget cmu_short.bvh cmu_short.bvh -o new.vrma --fbx-version 7.4",
            "--fbx-version has no effect on a VRM animation",
        ),
    ] {
        folder.refuses(arguments, 2, refusal);
    }
    std::fs::write(folder.path("map.json"), r#"{"bones": {}}"#).unwrap();
    for (arguments, name) in [
        ("edit lecture_Test.bvh -o new.glb --step mirror --to glb", "--to"),
        (
            "edit lecture_Test.bvh cmu_short.bvh -o new.glb --step smooth",
            "cmu_short.bvh",
        ),
        (
            "edit lecture_Test.bvh cmu_short.bvh z_up_dab.bvh -o new.glb --step concat:with=3",
            "cmu_short.bvh",
        ),
        ("retarget cmu_short.bvh cmu_short.bvh -o new.glb --to glb", "--to"),
        (
            "retarget cmu_short.bvh cmu_short.bvh -o new.glb --replace-animations",
            "--replace-animations",
        ),
    ] {
        folder.refuses(arguments, 2, &format!("{name} would do nothing: "));
    }
    for arguments in [
        format!("convert {bvh} --map map.json"),
        format!("convert {glb} --unit m --up y --map map.json"),
        "fk lecture_Test.bvh -o new.npz --map map.json".to_owned(),
        "sheet lecture_Test.bvh -o new.svg --map map.json".to_owned(),
    ] {
        folder.refuses(&arguments, 2, "--map would do nothing: ");
    }
}

#[cfg(feature = "parquet")]
#[test]
fn an_inventory_takes_no_options_of_arrays() {
    let folder = folder();
    for option in ["--rot 6d", "--fps 30", "--unit m", "--out-up z", "--velocities"] {
        let name = option.split(' ').next().unwrap();
        folder.refuses(
            &format!("pack lecture_Test.bvh -o new --inventory {option}"),
            2,
            &format!("{name} would do nothing: "),
        );
    }
}

/// A spreadsheet reads a cell that begins with one of these characters as a formula, even if the cell is quoted.
#[test]
fn no_cell_for_a_spreadsheet_is_a_formula() {
    let folder = folder();
    let mut text = std::fs::read_to_string(at_root("fixtures/real/lecture_Test.bvh")).unwrap();
    let names = ["=1+1", "@SUM(A1,\"b\")", "-x"];
    for (name, new) in std::iter::zip(["Shoulder", "Elbow", "Wrist"], names) {
        text = text.replace(name, new);
    }
    std::fs::write(folder.path("names.bvh"), text).unwrap();
    for option in ["", " --spreadsheet"] {
        folder.succeeds(&format!("fk names.bvh -o out.csv --up z --out-up y{option}"));
        let arrays = cells(&std::fs::read_to_string(folder.path("out.csv")).unwrap());
        let pose = folder.run(&format!("pose names.bvh --tick 3 --csv{option}"));
        let pose = cells(&String::from_utf8(pose.stdout).unwrap());
        // Numbers are not escaped.
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
    // The header is one cell with any contents.
    let text = std::fs::read_to_string(folder.path("out.csv")).unwrap();
    let header = cells(&text).swap_remove(0);
    let header: serde_json::Value = serde_json::from_str(header.strip_prefix("# ").unwrap()).unwrap();
    assert_eq!(header["joints"][0]["name"], names[0]);
}

/// The cells of a text by RFC 4180.
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
    let folder = folder();
    for arguments in [
        "pack lecture_Test.bvh -o new --rot 6d",
        "pack",
        "fk lecture_Test.bvh -o new.parquet",
    ] {
        folder.refuses(arguments, 2, "build it with `--features parquet`");
    }
}

#[cfg(not(feature = "fbx"))]
#[test]
fn a_build_without_fbx_names_the_feature() {
    let folder = folder();
    std::fs::copy(at_root("fixtures/real/huesitos.fbx"), folder.path("a.fbx")).unwrap();
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
    let folder = folder();
    folder.succeeds("view lecture_Test.bvh -o all.html");
    // The file has 10 frames per second. From the third to the ninth frame, 5 frames per second give four frames.
    folder.succeeds("view lecture_Test.bvh -o part.html --trim 2f..8f --fps 5 --unit dm --up z");
    let page = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    let all = r#""frames":10,"ticksPerSecond":10.0,"firstTick":0,"metresPerUnit":1.0,"up":"+y""#;
    assert!(page("all.html").contains(all));
    let part = r#""frames":4,"ticksPerSecond":5.0,"firstTick":0,"metresPerUnit":0.1,"up":"+z""#;
    assert!(page("part.html").contains(part));
    // The first frame of this file is a T-pose.
    folder.succeeds(&format!(
        "view {} -o short.html",
        at_root("fixtures/real/cmu_12_01_walk.bvh")
    ));
    assert!(page("short.html").contains(r#""firstTick":1,"#));
    std::fs::write(folder.path("wrong.json"), r#"{"bones": {"head": "Haed"}}"#).unwrap();
    let output = folder.run("view cmu_short.bvh -o new.html --map wrong.json");
    assert!(!output.status.success() && String::from_utf8(output.stderr).unwrap().contains("Haed"));
    folder.refuses("view lecture_Test.bvh -o new.html --fps 0", 2, "frame rate must be");
}

/// `dump --layout` accepts every year in the book.
#[test]
fn every_year_of_the_course_has_a_layout() {
    let page = std::fs::read_to_string(at_root("docs/commands.md")).unwrap();
    assert!(page.contains("(`--layout 2017` to `2024`)"));
    let folder = Folder::of_real(&["lecture_Test.bvh"]);
    let text = |year: u32| {
        let ran = folder.run(&format!("dump lecture_Test.bvh --layout {year}"));
        assert!(ran.status.success(), "{year}: {}", String::from_utf8_lossy(&ran.stderr));
        String::from_utf8(ran.stdout).unwrap()
    };
    let texts: Vec<String> = (2017..=2024).map(text).collect();
    assert_eq!(texts[2], texts[3]);
    assert!(texts[4..].iter().all(|text| *text == texts[4]));
    assert!(texts[0] != texts[1] && texts[1] != texts[2]);
}
