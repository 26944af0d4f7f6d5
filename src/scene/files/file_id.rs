//! The identity of the file at a path.

use std::fs;
use std::path::Path;
#[cfg(not(unix))]
use std::path::PathBuf;
#[cfg(unix)]
use std::{fs::File, io};

use serde::{Deserialize, Serialize};

/// Identifies a file. Two paths to one file have one id.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub(super) enum FileId {
    #[cfg(unix)]
    Inode { device: u64, inode: u64 },
    #[cfg(not(unix))]
    Path(PathBuf),
}

impl FileId {
    /// `None` if there is no file.
    #[cfg(unix)]
    pub(super) fn of(path: &Path) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        let metadata = fs::metadata(path).ok()?;
        Some(Self::Inode {
            device: metadata.dev(),
            inode: metadata.ino(),
        })
    }

    /// The file that a shell redirected to standard input; `None` for a terminal or a pipe.
    #[cfg(unix)]
    pub(super) fn of_standard_input() -> Option<Self> {
        use std::os::fd::AsFd;
        use std::os::unix::fs::MetadataExt;
        let input = File::from(io::stdin().as_fd().try_clone_to_owned().ok()?);
        let metadata = input.metadata().ok().filter(fs::Metadata::is_file)?;
        Some(Self::Inode {
            device: metadata.dev(),
            inode: metadata.ino(),
        })
    }

    /// Standard input has no name on this system.
    #[cfg(not(unix))]
    pub(super) fn of_standard_input() -> Option<Self> {
        None
    }

    /// `None` if there is no file.
    #[cfg(not(unix))]
    pub(super) fn of(path: &Path) -> Option<Self> {
        fs::canonicalize(path).ok().map(Self::Path)
    }
}
