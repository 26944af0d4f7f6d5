//! The rules of `ARCHITECTURE.md` that Cargo does not enforce.

use std::collections::BTreeSet;
use std::fs;

use crate::source::{Crossing, Source, crossings, sources};

/// The packages from the bottom up. A package imports only packages of earlier lines. Its tests may also import
/// packages of the same line.
const LINES: &str = "scene, compress figure, formats solve, io edit, retarget render, corpus, job, cli";
/// Files with more than 450 lines of code. A new file of this size must be a table, or be split.
const LONG: &str = "src/figure/names/words.rs src/formats/bvh/read/rows.rs src/formats/bvh/read/scene.rs";
/// Vague names of modules.
const VAGUE: [&str; 4] = ["util", "common", "helper", "manager"];
/// Code that is only allowed in these files and folders.
const ONLY_IN: &[(&str, &str)] = &[
    ("allow(unsafe_code", "src/scene/math/wide.rs"),
    ("#[path", "src/formats/fbx.rs"),
    ("File::open fs::read", "src/cli src/io/import src/scene/files"),
    ("fs::metadata", "src/cli src/io/import src/scene/files"),
    (
        "File::create fs::write tempfile",
        "src/cli src/scene/files src/job/build.rs src/render/build.rs",
    ),
    (
        "println! eprintln! print! eprint!",
        "src/cli src/job/build.rs src/render/build.rs",
    ),
    (".unwrap() dbg! _str!(\"../.. _bytes!(\"..", "no file"),
    // The manifests disable unit tests, so a unit test would never run. Only tests may use the items in `internals`.
    ("#[test] cfg(test internals::", "no file"),
];

/// Fails for a violation that is not in the list of exceptions, and for an exception without a violation.
pub(super) fn compare(rule: &str, found: &BTreeSet<String>, exceptions: &str) {
    let known = exceptions.split_whitespace().map(str::to_owned).collect();
    let changed: Vec<&String> = found.symmetric_difference(&known).collect();
    assert!(changed.is_empty(), "{rule}; found or mended: {changed:#?}");
}

#[test]
fn packages_import_lower_lines_and_have_every_profile() {
    let pages = fs::read_to_string("ARCHITECTURE.md").unwrap();
    let workspace = fs::read_to_string("Cargo.toml").unwrap();
    let lines: Vec<&str> = LINES.split(", ").collect();
    let packages = |from: usize| lines[from..].iter().flat_map(|names| names.split(' '));
    let is_in = |own: &str, line: usize| packages(line).any(|name| name == own);
    let mut found = BTreeSet::new();
    for own in packages(0) {
        let line = (0..lines.len()).rfind(|line| is_in(own, *line)).unwrap();
        let manifest = fs::read_to_string(format!("src/{own}/Cargo.toml")).unwrap();
        for (text, from) in manifest.split("[dev-dependencies]").zip([line, line + 1]) {
            let imported = packages(from).filter(|name| text.contains(&format!("\nmocap-{name}")));
            found.extend(imported.map(|name| format!("{own} imports {name}")));
        }
        for profile in ["dev", "test", "release", "dist", "wasm"] {
            let table = format!("[profile.{profile}.package]\n");
            let rest = workspace.split(&table).nth(1).expect(&table);
            let rows = rest.split("\n\n").next().unwrap();
            if !rows.contains(&format!("mocap-{own}.")) && (own, profile) != ("cli", "wasm") {
                found.insert(format!("{table} lacks mocap-{own}"));
            }
        }
        // One line of the README states what to change in the package, and what never to do.
        let readme = fs::read_to_string(format!("src/{own}/README.md")).unwrap();
        let rule = readme.lines().find(|line| line.contains("; never ")).expect(own);
        let has = |part: &str| manifest.contains(part);
        if !pages.contains(rule) || !has("[lints]\nworkspace = true") || !has("\ntest = false") {
            found.insert(format!(
                "{own}: ARCHITECTURE.md lacks \"{rule}\", or the manifest [lints] or test"
            ));
        }
    }
    // `lib.rs` of the root is the library that re-exports the packages.
    let entries = fs::read_dir("src").unwrap().count();
    assert_eq!(entries, packages(0).count() + 1, "a package is not in LINES");
    compare("packages import lower lines and are in every profile", &found, "");
}

#[test]
fn modules_import_without_circles() {
    let sources = sources();
    let edge = |crossing: Crossing<'_>| (crossing.from.join("/"), crossing.to.join("/"));
    let mut edges: BTreeSet<(String, String)> = crossings(&sources).into_iter().map(edge).collect();
    // Removes modules without imports and modules that nobody imports, round by round. The remaining modules are on
    // cycles, or between cycles.
    let mut before = 0;
    while before != edges.len() {
        before = edges.len();
        let (from, to): (BTreeSet<String>, BTreeSet<String>) = edges.iter().cloned().unzip();
        edges.retain(|(a, b)| to.contains(a) && from.contains(b));
    }
    assert!(edges.is_empty(), "modules import in circles: {edges:#?}");
}

#[test]
fn formats_and_steps_stay_apart() {
    let sources = sources();
    let has_row = |source: &&Source| source.code.contains(": FormatInfo = ");
    let rows = sources.iter().filter(has_row);
    let formats: BTreeSet<&[String]> = rows.map(|source| &source.module[..2]).collect();
    let steps = fs::read_to_string("src/edit/lib.rs").unwrap();
    let steps = steps.split("steps! {").nth(1).unwrap();
    let (mut calls, mut found) = (BTreeSet::new(), BTreeSet::new());
    let imports = crossings(&sources);
    let between = |import: &&Crossing<'_>| import.to.len() == 2 && import.from[1] != "internals";
    for Crossing { source, name, from, to } in imports.iter().filter(between) {
        let row = format!("\n    {}: ", to[1]);
        let is_called = name.starts_with(char::is_lowercase) || steps.contains(&format!("{row}{name}"));
        let is_call = to[0] == "edit" && steps.contains(&row) && is_called;
        calls.extend(is_call.then(|| format!("{} calls {name}", source.path)));
        let is_format = formats.contains(&from[..]) && formats.contains(&to[..]);
        found.extend(is_format.then(|| format!("{} imports {}", source.path, to[1])));
    }
    // A step of `process` is a method of the scene.
    let is_process = |source: &&Source| source.path.starts_with("src/scene/process");
    let process = || sources.iter().filter(is_process);
    let declares = |source: &Source, name: &str| source.code.contains(&format!("pub fn {name}(&mut self"));
    for source in process() {
        let parts = source.code.split('.').filter_map(|text| text.split_once('('));
        for (name, _) in parts.filter(|(name, _)| !declares(source, name)) {
            let is_call = process().any(|other| declares(other, name));
            calls.extend(is_call.then(|| format!("{} calls {name}", source.path)));
        }
    }
    compare("a format imports no other format", &found, "");
    compare("a step calls no other step", &calls, "");
}

#[test]
fn files_are_short_and_hold_only_what_belongs_there() {
    let (mut long, mut found) = (BTreeSet::new(), BTreeSet::new());
    for source in sources() {
        long.extend((source.code.lines().count() > 450).then(|| source.path.clone()));
        for (code, places) in ONLY_IN {
            let is_allowed = places.split(' ').any(|place| source.path.starts_with(place));
            for code in code.split(' ').filter(|code| !is_allowed && source.code.contains(code)) {
                found.insert(format!("{} has {code}", source.path));
            }
        }
        let is_wide = |line: &str| line.trim_start().starts_with("//") && line.chars().count() > 120;
        let wide = source.text.lines().find(|line| is_wide(line) && !line.ends_with('|'));
        found.extend(wide.map(|line| format!("{} has more than 120 columns: {line}", source.path)));
        let vague = VAGUE.iter().filter(|name| source.path.contains(**name));
        found.extend(vague.map(|name| format!("{} is named {name}", source.path)));
    }
    compare("each place has its code", &found, "");
    compare("a file has at most 450 lines", &long, LONG);
}
