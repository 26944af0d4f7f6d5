//! Tests the tool of `mocap mcp` that lists the files of a folder.

use std::fs;

use serde_json::{Value, json};

use super::{answers, call, error};
use crate::at_root;
use crate::program::Folder;

#[test]
fn a_folder_is_listed_with_formats_and_sizes() {
    let folder = Folder::with(&["takes/a.bvh", "takes/deep/b.bvh"]);
    let copy = |from: &str, to: &str| folder.write(to, &fs::read(at_root(from)).unwrap());
    copy("fixtures/characters/human_vrm0.vrm", "hero.vrm");
    copy("fixtures/robots/h1_nomesh.xml", "h1.xml");
    // The contents determine the format, or else the extension.
    copy("fixtures/real/cmu_short.bvh", "really.txt");
    folder.write("broken.bvh", b"nothing");
    folder.write("notes.txt", b"a list of takes");
    folder.write("table.csv", b"file,size\na,1\n");
    folder.write("page.xml", b"<page/>");
    let found = answers(
        &folder,
        &[
            call("list", json!({})),
            call("list", json!({"folder": "takes"})),
            call("list", json!({"folder": "takes/deep/"})),
            call("list", json!({"folder": "."})),
        ],
    );
    let content = |index: usize| &found[index]["result"]["structuredContent"];
    let files = |index: usize| -> Vec<(&str, &str)> {
        let files = content(index)["files"].as_array().unwrap().iter();
        files
            .map(|file| (file["file"].as_str().unwrap(), file["format"].as_str().unwrap()))
            .collect()
    };
    let expected = [
        ("broken.bvh", "bvh"),
        ("h1.xml", "mjcf"),
        ("hero.vrm", "gltf"),
        ("really.txt", "bvh"),
        ("takes/a.bvh", "bvh"),
        ("takes/deep/b.bvh", "bvh"),
    ];
    assert_eq!(files(0), expected);
    assert_eq!(content(0)["count"], 6);
    assert_eq!(content(0)["others"], json!(["notes.txt", "page.xml", "table.csv"]));
    for file in content(0)["files"].as_array().unwrap() {
        let path = folder.path(file["file"].as_str().unwrap());
        assert_eq!(file["bytes"], fs::metadata(path).unwrap().len(), "{file}");
    }
    // Paths are relative to the root folder, so that a client can pass them to other tools unchanged.
    assert_eq!(files(1), expected[4..]);
    assert_eq!(files(2), expected[5..]);
    assert_eq!(files(3), expected);
}

/// A long list is cut, and its report is complete.
#[test]
fn a_long_list_is_counted_and_cut() {
    let folder = Folder::of_real(&[]);
    for number in 0..450 {
        folder.write(&format!("{number:03}.bvh"), b"HIERARCHY\n");
    }
    let found = answers(
        &folder,
        &[
            call("list", json!({})),
            call(
                "read",
                json!({"uri": "mocap://reports/1", "pointer": "/files/449/file"}),
            ),
        ],
    );
    let content = |index: usize| &found[index]["result"]["structuredContent"];
    assert_eq!(
        (&content(0)["count"], content(0)["files"].as_array().unwrap().len()),
        (&json!(450), 200)
    );
    assert!(content(0)["note"].is_string());
    assert!(found[0].to_string().len() < 60_000);
    assert_eq!(content(1)["value"], "449.bvh");
}

#[cfg(unix)]
#[test]
fn a_list_stays_in_the_root_folder() {
    use std::os::unix::fs::symlink;
    let outside = Folder::with(&["secret/secret.bvh", "secret.bvh"]);
    let root = Folder::with(&["in/a.bvh"]);
    symlink(".", root.path("in/again")).unwrap();
    symlink("/", root.path("in/system")).unwrap();
    symlink(outside.path("secret"), root.path("in/linked")).unwrap();
    symlink(outside.path("secret.bvh"), root.path("in/one.bvh")).unwrap();
    let whole = [call("list", json!({})), call("list", json!({"folder": "in"}))];
    for answer in answers(&root, &whole) {
        let found = &answer["result"]["structuredContent"];
        let files: Vec<&Value> = found["files"]
            .as_array()
            .unwrap()
            .iter()
            .map(|file| &file["file"])
            .collect();
        assert_eq!(files, ["in/a.bvh"], "{answer}");
        assert!(!answer.to_string().contains("secret"), "{answer}");
    }
    let away = outside.path("secret").display().to_string();
    let refused =
        ["in/linked", "in/system", "..", "in/../..", &away, "-"].map(|folder| call("list", json!({"folder": folder})));
    for answer in answers(&root, &refused) {
        let error = error(&answer)["error"].to_string();
        assert!(
            error.contains("leads out of") || error.contains("- is standard"),
            "{error}"
        );
    }
}
