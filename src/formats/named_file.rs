//! Which files a file may name: those in its folder, and for robots, whose packages have several folders, those around
//! it. A path from the root is refused, because opening it may reach another machine: a share of Windows, a folder that
//! the system mounts when it is asked for.

use std::path::{Component, Path, PathBuf};

/// How many folders above its own a robot may name: `package/urdf/left/arm.urdf` names `package/meshes`.
pub(crate) const LEVELS: usize = 6;

/// A path to a file in the folder of the file that names it, or below; `None` where it leads elsewhere.
pub(crate) fn below(path: impl AsRef<Path>) -> Option<PathBuf> {
    within(path.as_ref(), 0)
}

/// A path to a file of a robot, which may lead up as far as a robot may.
pub(crate) fn near(path: impl AsRef<Path>) -> Option<PathBuf> {
    within(path.as_ref(), LEVELS)
}

fn within(path: &Path, most: usize) -> Option<PathBuf> {
    let (mut above, mut below) = (0_usize, 0_usize);
    let mut kept = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(_) => below += 1,
            Component::CurDir => continue,
            // `meshes/../a.stl` is `a.stl`, also where `meshes` is a link.
            Component::ParentDir if below > 0 && most > 0 => {
                below -= 1;
                kept.pop();
                continue;
            }
            Component::ParentDir if above < most => above += 1,
            _ => return None,
        }
        kept.push(part);
    }
    path.file_name().is_some().then_some(kept)
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
