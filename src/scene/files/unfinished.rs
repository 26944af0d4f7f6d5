//! A file that is being written. Until it is complete it has no name, or a temporary one.
//!
//! On Linux the file has no name (`O_TMPFILE`), so that nothing remains if the process is killed. A nameless file can
//! get a name, but cannot replace another file. To replace another file, the file gets a temporary name and is then
//! renamed. If the system or the file system has no nameless files, the file has the temporary name from the start.

use std::ffi::OsString;
use std::fs::{self, File, Metadata};
use std::io::{self, Read, Seek, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use super::{UNFINISHED, folder_of};

/// A complete file that does not have its final name yet.
pub(super) enum UnfinishedFile {
    Named(NamedTempFile),
    #[cfg(target_os = "linux")]
    Unnamed(File),
    #[cfg(target_os = "linux")]
    Linked(NamedTempFile<File>),
}

impl UnfinishedFile {
    /// Creates a file in the folder of `target`, with the output of `write`. Dropping the value removes the file.
    pub(super) fn new(target: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<Self> {
        let mut file = Self::create(target)?;
        if let Some(permissions) = fs::metadata(target).ok().as_ref().map(Metadata::permissions) {
            // Ignore an error, because some file systems have no permissions.
            let _ = file.file().set_permissions(permissions);
        }
        write(file.file_mut())?;
        Ok(file)
    }

    #[cfg(target_os = "linux")]
    fn create(target: &Path) -> io::Result<Self> {
        match unnamed::create(folder_of(target)) {
            Ok(file) => Ok(Self::Unnamed(file)),
            Err(_) => Ok(Self::Named(named(target)?)),
        }
    }

    #[cfg(not(target_os = "linux"))]
    fn create(target: &Path) -> io::Result<Self> {
        Ok(Self::Named(named(target)?))
    }

    pub(super) fn file(&self) -> &File {
        match self {
            Self::Named(file) => file.as_file(),
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => file,
            #[cfg(target_os = "linux")]
            Self::Linked(file) => file.as_file(),
        }
    }

    /// The contents of the file.
    pub(super) fn contents(&self) -> io::Result<Box<dyn Read>> {
        let mut file = self.file().try_clone()?;
        file.rewind()?;
        Ok(Box::new(file))
    }

    fn file_mut(&mut self) -> &mut File {
        match self {
            Self::Named(file) => file.as_file_mut(),
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => file,
            #[cfg(target_os = "linux")]
            Self::Linked(file) => file.as_file_mut(),
        }
    }

    /// Gives the file its temporary name.
    #[cfg_attr(
        not(target_os = "linux"),
        expect(unused_variables, reason = "it has that name from the start")
    )]
    pub(super) fn with_name(self, target: &Path) -> io::Result<Self> {
        match self {
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => {
                let link = |name: &Path| {
                    unnamed::link(&file, name)?;
                    file.try_clone()
                };
                let linked = with_builder(target, |builder| builder.make_in(folder_of(target), link))?;
                Ok(Self::Linked(linked))
            }
            named => Ok(named),
        }
    }

    /// Gives the file the name `target`, and replaces an existing file.
    pub(super) fn persist(self, target: &Path) -> io::Result<()> {
        match self {
            Self::Named(file) => {
                file.persist(target)?;
                Ok(())
            }
            #[cfg(target_os = "linux")]
            Self::Unnamed(file) => match unnamed::link(&file, target) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                    Self::Unnamed(file).with_name(target)?.persist(target)
                }
                linked => linked,
            },
            #[cfg(target_os = "linux")]
            Self::Linked(file) => {
                file.persist(target)?;
                Ok(())
            }
        }
    }
}

/// An empty file with a temporary name in the folder of `target`.
pub(super) fn named(target: &Path) -> io::Result<NamedTempFile> {
    with_builder(target, |builder| builder.tempfile_in(folder_of(target)))
}

fn with_builder<T>(target: &Path, make: impl FnOnce(&tempfile::Builder<'_, '_>) -> T) -> T {
    let mut prefix = OsString::from(".");
    prefix.push(target.file_name().unwrap_or_default());
    prefix.push(UNFINISHED);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix);
    // A temporary file is private by default. An output has the permissions of any new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    make(&builder)
}

/// Nameless files, as `open(2)` describes them under `O_TMPFILE`.
#[cfg(target_os = "linux")]
mod unnamed {
    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::{Path, PathBuf};

    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open};

    /// The path of an open file, through which it can be linked.
    fn path_of(file: &File) -> PathBuf {
        PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()))
    }

    pub(super) fn create(folder: &Path) -> io::Result<File> {
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        let file = File::from(open(folder, flags, Mode::from_raw_mode(0o666))?);
        // Without /proc the file could not get a name.
        path_of(&file).symlink_metadata()?;
        Ok(file)
    }

    pub(super) fn link(file: &File, path: &Path) -> io::Result<()> {
        Ok(linkat(CWD, path_of(file), CWD, path, AtFlags::SYMLINK_FOLLOW)?)
    }
}
