//! Tests the search of folders for files.

use std::convert::Infallible;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use mocap_cli::internals::{Entry, Failure, Pattern, Search};

/// A folder with files, links as `name -> target`, and nothing else.
fn folder(entries: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for entry in entries {
        let (name, target) = entry.split_once(" -> ").unwrap_or((entry, ""));
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        match target {
            "" => fs::write(path, "").unwrap(),
            target => symlink(target, path).unwrap(),
        }
    }
    folder
}

/// The entries found below `root`: `!` precedes problems, `=` precedes folders that were already searched.
fn search(folder: &tempfile::TempDir, root: &str) -> Vec<String> {
    let root = folder.path().join(root);
    let (base, pattern) = match root.is_dir() {
        true => (root, Pattern::default()),
        false => Pattern::of(&root).map_err(Failure::into_words).unwrap(),
    };
    let mut found = Vec::new();
    let search = Search {
        base: &base,
        pattern: &pattern,
        is_excluded: &|_| false,
    };
    let name = |path: &Path| path.strip_prefix(folder.path()).unwrap().display().to_string();
    let take = |entry: Entry| {
        found.push(match entry {
            Entry::File(path) => name(&path),
            Entry::Problem(path, problem) => format!("!{}: {problem}", name(&path)),
            Entry::Again(path) => format!("={}", name(&path)),
        });
        Ok::<_, Infallible>(())
    };
    let Ok(()) = search.run(take);
    found.sort();
    found
}

#[test]
fn a_folder_is_searched_once_however_links_lead_to_it() {
    let two_loops = folder(&["in/a", "in/x -> .", "in/y -> ."]);
    for root in ["in", "in/**"] {
        let found = search(&two_loops, root);
        assert_eq!(found.len(), 3, "{found:?}");
        assert_eq!(found[2], "in/a");
        assert!(
            found[..2].iter().all(|found| found.contains("which contains it")),
            "{found:?}"
        );
    }
    // Each folder has a link to the other folder, and the link comes first.
    let crossed = folder(&["a/to_b -> ../b", "b/to_a -> ../a", "a/1", "b/2", "0 -> b"]);
    assert_eq!(search(&crossed, ""), ["=0", "=a/to_b", "=b/to_a", "a/1", "b/2"]);
    // Many links to a folder give one path.
    let links: Vec<String> = (0..50).map(|link| format!("in/{link:02} -> ../far")).collect();
    let entries: Vec<&str> = links
        .iter()
        .map(String::as_str)
        .chain(["far/a/b", "far/c -> a"])
        .collect();
    let found = search(&folder(&entries), "in");
    assert_eq!(
        found.iter().filter(|found| !found.starts_with('=')).collect::<Vec<_>>(),
        ["in/00/a/b"]
    );
}

#[test]
fn links_lead_to_data_elsewhere_and_never_up() {
    let linked = folder(&[
        "data/set/1",
        "data/set/deep/2",
        "in/set -> ../data/set",
        "in/deep -> ../data/set/deep",
        "in/file -> ../data/set/1",
        "in/up -> ..",
        "data/set/back -> ../../in",
        "other/3",
    ]);
    let found = search(&linked, "in");
    assert_eq!(
        &found[1..],
        ["=in/set/back", "=in/set/deep", "in/deep/2", "in/file", "in/set/1"]
    );
    assert!(found[0].starts_with("!in/up: the link points to"), "{found:?}");
    // A wildcard follows links like a folder, and only enters folders that may match.
    assert_eq!(search(&linked, "in/s*/1"), ["in/set/1"]);
    assert_eq!(search(&linked, "in/*/2")[1..], ["in/deep/2"]);
}

#[test]
fn what_cannot_be_followed_is_told_and_ends_nothing() {
    let broken = folder(&["in/gone -> nowhere", "in/p -> q", "in/q -> p", "in/a"]);
    let found = search(&broken, "in");
    assert_eq!(found[0], "!in/gone: the target of the link does not exist");
    assert!(found[1].starts_with("!in/p: the link cannot be followed"), "{found:?}");
    assert_eq!((found.len(), found[3].as_str()), (4, "in/a"));
    assert!(search(&broken, "in/n*").is_empty());
}

#[test]
fn a_deep_tree_is_searched_whole() {
    let deep = folder(&[]);
    let path = deep.path().join("d/".repeat(400));
    fs::create_dir_all(&path).unwrap();
    fs::write(path.join("a"), "").unwrap();
    assert_eq!(search(&deep, ""), ["d/".repeat(400) + "a"]);
    assert_eq!(search(&deep, "**/a"), ["d/".repeat(400) + "a"]);
}
