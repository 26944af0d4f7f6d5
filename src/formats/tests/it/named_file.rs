//! Paths of files to which a file refers.

use std::path::PathBuf;

use mocap_formats::internals::named_file::{below, near};

#[test]
fn paths_that_lead_elsewhere_are_none() {
    let found = |path: Option<PathBuf>| path.map(|path| path.display().to_string());
    for (path, expected) in [("a.bin", "a.bin"), ("./b/./a.bin", "b/a.bin"), ("..a/b..", "..a/b..")] {
        assert_eq!(found(below(path)).as_deref(), Some(expected));
        assert_eq!(found(near(path)).as_deref(), Some(expected));
    }
    assert_eq!(found(near("b/c/../../../d/a.stl")).as_deref(), Some("../d/a.stl"));
    assert_eq!(below("b/../a.stl"), None);
    for path in ["../a.stl", "./../../meshes/a.stl", "../../../../../../a.stl"] {
        assert_eq!(below(path), None, "{path}");
        assert!(near(path).is_some(), "{path}");
    }
    let away = [
        "",
        ".",
        "..",
        "/",
        "/etc/passwd",
        "//host/share/a.stl",
        "a/..",
        "../../../../../../../a.stl",
        "a/../../../../../../../../a.stl",
    ];
    for path in away {
        assert_eq!((below(path), near(path)), (None, None), "{path}");
    }
}

#[cfg(windows)]
#[test]
fn drives_and_shares_are_elsewhere() {
    for path in [r"C:\a.stl", "C:a.stl", r"\\host\share\a.stl", r"\a.stl"] {
        assert_eq!((below(path), near(path)), (None, None), "{path}");
    }
}
