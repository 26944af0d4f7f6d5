//! The folder that confines all files: no file outside is opened.

use std::fs;

use mocap_scene::internals::check_within;

#[cfg(unix)]
#[test]
fn what_leads_out_of_the_folder_is_outside() {
    use std::os::unix::fs::symlink;
    let whole = tempfile::tempdir().unwrap();
    let whole = whole.path().canonicalize().unwrap();
    let folder = whole.join("inside");
    fs::create_dir_all(folder.join("below")).unwrap();
    fs::create_dir(whole.join("inside too")).unwrap();
    fs::write(whole.join("secret.bvh"), "").unwrap();
    fs::write(folder.join("a.bvh"), "").unwrap();
    symlink(whole.join("secret.bvh"), folder.join("link.bvh")).unwrap();
    symlink(whole.join("new.bvh"), folder.join("dangling.bvh")).unwrap();
    symlink(&whole, folder.join("out")).unwrap();
    symlink(folder.join("a.bvh"), folder.join("own.bvh")).unwrap();
    let is_within = |path: &str| check_within(&folder.join(path), &folder).is_ok();
    for path in [
        "a.bvh",
        "new.bvh",
        "below/../a.bvh",
        "below/new/new.bvh",
        "own.bvh",
        ".",
    ] {
        assert!(is_within(path), "{path}");
    }
    let out = [
        "..",
        "../secret.bvh",
        "../none.bvh",
        "link.bvh",
        "dangling.bvh",
        "out/secret.bvh",
        "out/new.bvh",
        "none/../../secret.bvh",
        "../inside too/a.bvh",
        "/etc/passwd",
    ];
    for path in out {
        assert!(!is_within(path), "{path}");
    }
}
