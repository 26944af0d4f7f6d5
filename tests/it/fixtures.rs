//! Compares the list of fixtures in `fixtures/README.md` with the folders.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The folders that the README describes, each as the heading of its section.
const FOLDERS: [&str; 9] = [
    "real",
    "made",
    "markers",
    "characters",
    "skeletons",
    "arrays",
    "robots",
    "dialects",
    "broken",
];

fn listed(folder: &str) -> Vec<String> {
    let readme = fs::read_to_string("fixtures/README.md").unwrap();
    let section = readme
        .split("\n## ")
        .find(|section| section.starts_with(&format!("`{folder}/`")))
        .unwrap();
    let names = section
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next());
    names.map(str::to_owned).collect()
}

fn present(folder: &str, extension: &str) -> BTreeSet<String> {
    let names = fs::read_dir(Path::new("fixtures").join(folder))
        .unwrap()
        .map(|entry| entry.unwrap().file_name());
    names
        .map(|name| name.into_string().unwrap())
        .filter(|name| name.ends_with(extension))
        .collect()
}

#[test]
fn the_readme_lists_every_fixture_once_and_nothing_else() {
    for folder in FOLDERS {
        let rows = listed(folder);
        let list: BTreeSet<String> = rows.iter().cloned().collect();
        assert_eq!(rows.len(), list.len(), "{folder}: a row stands twice");
        // In the other two folders, an expected result is next to each input.
        let inputs = if ["real", "made", "markers", "characters", "skeletons", "arrays", "robots"].contains(&folder) {
            ""
        } else {
            ".bvh"
        };
        assert_eq!(list, present(folder, inputs), "{folder}");
    }
}

#[test]
fn every_fixture_has_its_expected_result() {
    for (folder, extension) in [("dialects", ".expected"), ("broken", ".error")] {
        let results = present(folder, extension);
        let inputs: BTreeSet<String> = results.iter().map(|name| name.replace(extension, ".bvh")).collect();
        assert_eq!(inputs, present(folder, ".bvh"), "{folder}");
        let files = fs::read_dir(Path::new("fixtures").join(folder)).unwrap().count();
        assert_eq!(files, 2 * results.len(), "{folder} holds something else");
    }
}
