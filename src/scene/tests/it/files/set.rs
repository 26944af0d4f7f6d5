//! Tests outputs of several files: all are written, or none.

use std::fs;
use std::path::{Path, PathBuf};

use mocap::files::ReplacePolicy;
use mocap::{Code, Error};
use mocap_scene::files::{OutputSet, check_distinct};
use mocap_scene::internals::Replaced;

use super::names;

#[test]
fn two_files_are_replaced_together_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let [bin, text] = ["a.bin", "a.gltf"].map(|name| folder.path().join(name));
    let write = || {
        let mut set = OutputSet::new();
        set.add(&bin, [&b"new"[..]]);
        set.add(&text, [&b"new text"[..]]);
        set.save(&ReplacePolicy::default().force(true))
    };
    // A folder has the name of the second file, so that file cannot be written.
    fs::create_dir(&text).unwrap();
    assert!(write().is_err());
    assert_eq!(names(folder.path()), ["a.gltf"]);
    fs::write(&bin, "old").unwrap();
    assert!(write().is_err());
    assert_eq!(fs::read(&bin).unwrap(), b"old");
    fs::remove_dir(&text).unwrap();
    fs::write(&text, "old text").unwrap();
    write().unwrap();
    assert_eq!(names(folder.path()), ["a.bin", "a.gltf"]);
    assert_eq!(
        (fs::read(&bin).unwrap(), fs::read(&text).unwrap()),
        (b"new".to_vec(), b"new text".to_vec())
    );
}

#[test]
fn renamed_files_are_restored() {
    let folder = tempfile::tempdir().unwrap();
    let [bin, text] = ["a.bin", "a.gltf"].map(|name| folder.path().join(name));
    fs::write(&bin, "old").unwrap();
    fs::write(&text, "old text").unwrap();
    let mut replaced = Replaced::default();
    replaced.set_aside(&text).unwrap();
    assert!(!text.exists() && bin.exists());
    replaced.set_aside(&bin).unwrap();
    fs::write(&bin, "new").unwrap();
    replaced.new.push(bin.clone());
    drop(replaced);
    assert_eq!(names(folder.path()), ["a.bin", "a.gltf"]);
    assert_eq!(
        (fs::read(&bin).unwrap(), fs::read(&text).unwrap()),
        (b"old".to_vec(), b"old text".to_vec())
    );
}

/// Every file is checked before the first is written, and no name may lead out of the folder.
#[test]
fn a_set_is_checked_before_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("hero.fbx");
    let texture = folder.path().join("skin.png");
    let set = |name: &str| {
        let mut set = OutputSet::new();
        set.add_beside(&main, name, [&b"pixels"[..]])?;
        set.add(&main, [&b"motion"[..]]);
        Ok::<_, Error>(set)
    };
    for name in [
        "..",
        ".",
        "",
        "/etc/passwd",
        "../skin.png",
        "a/skin.png",
        "skin.png/",
        "a\0b",
    ] {
        assert!(set(name).is_err(), "{name:?}");
    }
    for name in ["hero.fbx", "HERO.fbx"] {
        let error = set(name).unwrap().save(&ReplacePolicy::default()).unwrap_err();
        assert!(error.to_string().contains("give each its own name"), "{error}");
    }
    fs::write(&texture, "somebody's").unwrap();
    let error = set("skin.png").unwrap().save(&ReplacePolicy::default()).unwrap_err();
    assert_eq!(
        (error.code(), error.path()),
        (Code::OutputExists, Some(texture.as_path()))
    );
    let forced = ReplacePolicy::new([&texture]).force(true);
    let error = set("skin.png").unwrap().save(&forced).unwrap_err();
    assert_eq!(error.code(), Code::OutputIsInput);
    assert_eq!(names(folder.path()), ["skin.png"]);
    set("skin.png")
        .unwrap()
        .save(&ReplacePolicy::default().force(true))
        .unwrap();
    assert_eq!(names(folder.path()), ["hero.fbx", "skin.png"]);
    assert_eq!(fs::read(&texture).unwrap(), b"pixels");
}

#[cfg(unix)]
#[test]
fn two_names_of_one_file_are_not_distinct() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("a.json"), "").unwrap();
    fs::hard_link(path("a.json"), path("hard.json")).unwrap();
    symlink("new.json", path("link.json")).unwrap();
    symlink("loop", path("loop")).unwrap();
    let check = |names: [&str; 2]| check_distinct(names.map(path).iter().map(PathBuf::as_path));
    for same in [
        ["a.json", "a.json"],
        ["a.json", "./a.json"],
        ["a.json", "A.json"],
        ["a.json", "hard.json"],
        ["link.json", "new.json"],
        ["loop", "loop"],
    ] {
        assert!(check(same).is_err(), "{same:?}");
    }
    for other in [["a.json", "b.json"], ["a.json", "new.json"], ["none/a.json", "a.json"]] {
        check(other).unwrap();
    }
}

/// Bytes that a device has received cannot be removed, so the device gets its bytes last.
#[cfg(target_os = "linux")]
#[test]
fn a_full_device_leaves_the_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let report = folder.path().join("report.json");
    fs::write(&report, "old").unwrap();
    let save = |device: &str| {
        let mut set = OutputSet::new();
        set.add(Path::new(device), [&b"bytes"[..]]);
        set.add(&report, [&b"new"[..]]);
        set.save(&ReplacePolicy::default())
    };
    let error = save("/dev/full").unwrap_err();
    assert_eq!(error.path(), Some(Path::new("/dev/full")));
    assert_eq!(
        (names(folder.path()), fs::read(&report).unwrap()),
        (vec!["report.json".to_owned()], b"old".to_vec())
    );
    save("/dev/null").unwrap();
    assert_eq!(fs::read(&report).unwrap(), b"new");
    let mut set = OutputSet::new();
    assert!(
        set.add_beside(Path::new("/dev/null"), "walk.bin", [&b"bytes"[..]])
            .is_err()
    );
}
