//! `--json` of the commands that write one file.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::ROOT;
use crate::program::Folder;

/// The complete standard output of a command.
fn printed(folder: &Folder, line: &str) -> Value {
    let ran = folder.run(line);
    assert!(ran.status.success(), "{line}: {}", String::from_utf8_lossy(&ran.stderr));
    serde_json::from_slice(&ran.stdout).unwrap_or_else(|error| panic!("{line}: {error}"))
}

#[test]
fn pictures_say_how_large_they_are() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    for (line, output) in [
        ("plot cmu_short.bvh --joint Head -o p.png --width 300 --json", "p.png"),
        ("sheet cmu_short.bvh -o s.svg --json", "s.svg"),
        (
            "gif cmu_short.bvh -o g.gif --width 64 --height 48 --rate 5 --json",
            "g.gif",
        ),
    ] {
        let said = printed(&folder, line);
        assert_eq!(said["output"], output, "{line}");
        assert_eq!(said["bytes"], folder.read(output).len(), "{line}");
    }
    let said = printed(
        &folder,
        "gif cmu_short.bvh -o g.gif --width 64 --height 48 --rate 5 --json",
    );
    assert_eq!((&said["width"], &said["height"]), (&64.into(), &48.into()));
    // A GIF has its size in bytes 6 to 9.
    assert_eq!(folder.read("g.gif")[6..10], [64, 0, 48, 0]);
}

#[test]
fn searches_and_surveys_say_what_they_found() {
    let folder = Folder::of_real(&["cmu_short.bvh", "cmu_12_01_walk.bvh"]);
    let said = printed(&folder, "index cmu_short.bvh cmu_12_01_walk.bvh -o moves.mdb --json");
    assert_eq!((&said["clips"], &said["output"]), (&2.into(), &"moves.mdb".into()));

    let rows = printed(&folder, "survey cmu_short.bvh cmu_12_01_walk.bvh --json");
    let files: Vec<&str> = rows
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["file"].as_str().unwrap())
        .collect();
    assert_eq!(files, ["cmu_12_01_walk.bvh", "cmu_short.bvh"]);
    folder.succeeds("survey cmu_short.bvh cmu_12_01_walk.bvh -o rows.json");
    assert_eq!(
        rows,
        serde_json::from_slice::<Value>(&folder.read("rows.json")).unwrap()
    );

    let line = "graph cmu_12_01_walk.bvh --threshold 5cm --rate 15 -o graph.json --json";
    assert_eq!(printed(&folder, line)["graph"]["clips"], 1);
}

#[test]
fn series_say_their_columns() {
    let folder = Folder::of_real(&[]);
    let plates = Path::new(ROOT).join("fixtures/made/plates.c3d");
    folder.write("plates.c3d", &fs::read(plates).unwrap());
    let said = printed(&folder, "forces plates.c3d -o f.csv --json");
    let text = String::from_utf8(folder.read("f.csv")).unwrap();
    let rows = text.lines().filter(|line| !line.starts_with('#')).count() - 1;
    assert_eq!(said["samples"], rows);
    assert!(said["columns"].as_array().unwrap().len() > 5, "{said}");
    assert_eq!(printed(&folder, "analog plates.c3d -o a.csv --json")["output"], "a.csv");
}

#[test]
fn json_and_an_output_do_not_share_standard_output() {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    for line in [
        "plot cmu_short.bvh --joint Head -o - --json",
        "index cmu_short.bvh -o - --json",
        "survey cmu_short.bvh -o - --json",
        "gif cmu_short.bvh -o - --json",
    ] {
        folder.refuses(line, 2, "--json and -o - would both write to standard output");
    }
}

#[cfg(feature = "fbx")]
#[test]
fn pictures_question_an_up_axis_that_contradicts_the_file() {
    let folder = Folder::with(&[]);
    folder.write(
        "z.fbx",
        &fs::read(Path::new(ROOT).join("fixtures/made/fbx_zup.fbx")).unwrap(),
    );
    for line in ["sheet z.fbx -o z.svg", "gif z.fbx -o z.gif"] {
        let as_stated = folder.succeeds(&format!("{line} --up z --force"));
        assert!(!as_stated.contains("stated-otherwise"), "{as_stated}");
        let otherwise = folder.succeeds(&format!("{line} --up y --force"));
        assert_eq!(otherwise.matches("stated-otherwise").count(), 1, "{otherwise}");
    }
}
