//! The files to which a file may refer: files in its folder and in its subfolders. Robots, whose packages have several
//! folders, may also refer to nearby parent folders. An absolute path is refused, because opening it may reach another
//! machine: a Windows share, or a folder that is mounted on access.

use std::path::{Component, Path, PathBuf};

/// The number of parent folders that a robot's path may use: `package/urdf/left/arm.urdf` refers to `package/meshes`.
pub(crate) const LEVELS: usize = 6;

/// A path to a file in the folder of the referring file, or in its subfolders; `None` if the path leads elsewhere.
pub fn below(path: impl AsRef<Path>) -> Option<PathBuf> {
    within(path.as_ref(), 0)
}

/// A path to a file of a robot, which may lead up by six folders.
pub fn near(path: impl AsRef<Path>) -> Option<PathBuf> {
    within(path.as_ref(), LEVELS)
}

fn within(path: &Path, most: usize) -> Option<PathBuf> {
    let (mut above, mut below) = (0_usize, 0_usize);
    let mut kept = PathBuf::new();
    for part in path.components() {
        match part {
            Component::Normal(_) => below += 1,
            Component::CurDir => continue,
            // `meshes/../a.stl` is `a.stl`, even if `meshes` is a link.
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
