//! Which files a file may name: those in its folder, and for robots, whose packages have several folders, those around
//! it. A path from the root is refused, because opening it may reach another machine: a share of Windows, a folder that
//! the system mounts when it is asked for.

use std::path::{Component, Path, PathBuf};

/// How many folders above its own a robot may name: `package/urdf/left/arm.urdf` names `package/meshes`.
pub(crate) const LEVELS: usize = 6;

/// A path to a file in the folder of the file that names it, or below; `None` where it leads elsewhere.
pub fn below(path: impl AsRef<Path>) -> Option<PathBuf> {
    within(path.as_ref(), 0)
}

/// A path to a file of a robot, which may lead up as far as a robot may.
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
