//! The files that folders and wildcards find: links, loops, unusual names.

use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::program::{Folder, words};

/// The inputs and the errors of a manifest.
fn rows(folder: &Folder, name: &str) -> Vec<(String, String)> {
    let text = |value: &Value| value.as_str().unwrap_or("").to_owned();
    let records = folder.records(name);
    records
        .iter()
        .map(|row| (text(&row["input"]), text(&row["error"])))
        .collect()
}

/// With one link to its own folder, a wildcard search once found the file by 41 paths. With two such links, the search
/// never ended.
#[test]
fn a_link_to_its_own_folder_gives_no_output_twice() {
    let folder = Folder::with(&["in/a.bvh"]);
    symlink(".", folder.path("in/self")).unwrap();
    symlink("../in", folder.path("in/again")).unwrap();
    let start = Instant::now();
    for (number, inputs) in ["in", "in/**/*.bvh", "in/**", "i?"].iter().enumerate() {
        let output = folder.run(&format!("convert {inputs} -o out{number}"));
        // Each link has a row, and its target has an output.
        assert_eq!(output.status.code(), Some(3), "{inputs}: {}", words(&output));
        let rows = rows(&folder, &format!("out{number}"));
        let (done, told): (Vec<_>, Vec<_>) = rows.iter().partition(|(_, error)| error.is_empty());
        assert!(
            matches!(&done[..], [(input, _)] if input.ends_with("a.bvh")),
            "{rows:?}"
        );
        assert!(
            told.len() == 2 && told.iter().all(|(_, error)| error.contains("which contains it")),
            "{rows:?}"
        );
    }
    folder.succeeds("convert in/*.bvh -o flat");
    assert_eq!(rows(&folder, "flat").len(), 1);
    assert!(start.elapsed() < Duration::from_secs(60));
}

/// Datasets are often linked into a folder. The folder itself comes before a link to it, with any names.
#[test]
fn links_to_data_elsewhere_are_followed_once() {
    let folder = Folder::with(&["data/set/a.bvh", "in/own/b.bvh"]);
    symlink(folder.path("data/set"), folder.path("in/set")).unwrap();
    symlink("../data/set", folder.path("in/twice")).unwrap();
    symlink("own", folder.path("in/a_link")).unwrap();
    symlink("../data/set/a.bvh", folder.path("in/one.bvh")).unwrap();
    for inputs in ["in", "in/**/*.bvh"] {
        let said = folder.succeeds(&format!("convert {inputs} -o out"));
        let found = rows(&folder, "out");
        let names: Vec<&str> = found.iter().map(|(input, _)| input.as_str()).collect();
        assert_eq!(names, ["one.bvh", "own/b.bvh", "set/a.bvh"]);
        assert!(said.contains("in/a_link, in/twice"), "{said}");
        fs::remove_dir_all(folder.path("out")).unwrap();
    }
    // A wildcard that only matches the link reads the folder by the name of the link.
    folder.succeeds("convert in/a_*/*.bvh -o out");
    assert_eq!(rows(&folder, "out")[0].0, "a_link/b.bvh");
}

/// Only Linux allows names that are not UTF-8. Two of them look alike in a message.
#[cfg(target_os = "linux")]
#[test]
fn names_that_look_alike_are_two_files() {
    let folder = Folder::with(&["in/a.bvh"]);
    let bytes = folder.read("in/a.bvh");
    for name in [
        &b"in/\xff.bvh"[..],
        b"in/\xfe.bvh",
        b"in/\xff/c\xe9.bvh",
        b"in/\xfe/c\xe9.bvh",
        b"in/\n\x1b[2J.bvh",
    ] {
        let path = folder.path("").join(std::ffi::OsStr::from_bytes(name));
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, &bytes).unwrap();
    }
    for inputs in ["in", "in/**/*.bvh"] {
        let said = folder.succeeds(&format!("convert {inputs} -o out"));
        assert!(!said.contains('\u{1b}'), "{said}");
        let found = rows(&folder, "out");
        let names: Vec<&str> = found.iter().map(|(input, _)| input.as_str()).collect();
        let expected = [
            "\n\u{1b}[2J.bvh",
            "%FE.bvh",
            "%FE/c%E9.bvh",
            "%FF.bvh",
            "%FF/c%E9.bvh",
            "a.bvh",
        ];
        assert_eq!(names, expected);
        assert!(folder.path("out/%FE/c%E9.glb").is_file() && folder.path("out/%FF.glb").is_file());
        fs::remove_dir_all(folder.path("out")).unwrap();
    }
}

/// A pipe without a writer would block the program.
#[test]
fn pipes_in_a_folder_are_no_inputs() {
    let folder = Folder::with(&["in/a.bvh"]);
    for name in ["in/p.bvh", "in/p.csv"] {
        let made = std::process::Command::new("mkfifo").arg(folder.path(name)).status();
        assert!(made.unwrap().success());
    }
    symlink("p.csv", folder.path("in/link.csv")).unwrap();
    for inputs in ["in", "in/*"] {
        folder.succeeds(&format!("convert {inputs} -o out"));
        assert_eq!(rows(&folder, "out").len(), 1);
    }
}

#[test]
fn wildcards_that_mean_nothing_are_refused() {
    let folder = Folder::with(&["in/a.bvh"]);
    folder.refuses("convert in/[a -o out", 2, "the [ of a wildcard lacks its ]");
    folder.refuses(
        "convert in/**.bvh -o out",
        2,
        "write it as a name of its own, as in **/*.bvh",
    );
    folder.refuses(
        "convert i*/../in/a.bvh -o out",
        2,
        "after a wildcard a path must not have ..",
    );
    folder.refuses("convert none/*.bvh -o out", 2, "no motion files found");
}
