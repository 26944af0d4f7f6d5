//! Reads files that are in memory. Opens only the file that the caller names.

use std::path::{Path, PathBuf};

use mocap_formats::Source;
use mocap_scene::error::{Error, Result};
use mocap_scene::scene::Scene;

use super::Importer;
use super::contents::{check_size, refused_from_memory};
#[cfg(feature = "gltf")]
use mocap_formats::gltf::Character;

/// A file in memory.
///
/// [`Importer::read_among`](crate::Importer::read_among) has an example.
#[derive(Clone, Copy, Debug)]
pub struct MemoryFile<'a> {
    /// The file name in errors, with its folder if there is one. The extension sets the format if the contents do not.
    pub name: &'a str,
    /// The contents of the file.
    pub bytes: &'a [u8],
}

impl<'a> MemoryFile<'a> {
    /// A file with this name.
    pub fn new(name: &'a str, bytes: &'a [u8]) -> Self {
        Self { name, bytes }
    }
}

impl Importer {
    /// Reads bytes into a scene. `name` is the file name in errors. The extension of the name sets the format if the
    /// contents do not. Opens no file except the file of [`Importer::skeleton`].
    ///
    /// # Errors
    /// - [`Code::UnknownFormat`](mocap_scene::Code::UnknownFormat): the format is unknown.
    /// - [`Code::MissingFile`](mocap_scene::Code::MissingFile): the bytes refer to another file.
    /// - Other codes: the contents are not valid.
    pub fn read(&self, bytes: &[u8], name: impl AsRef<Path>) -> Result<Scene> {
        self.read_source(&Source {
            bytes,
            blocks: None,
            name: name.as_ref(),
            release: &|_| {},
            open: &|other| match &self.skeleton {
                Some(named) if named == other => self.open(named),
                _ => Err(refused_from_memory(other)),
            },
            list: &|_| self.skeleton.clone().into_iter().collect(),
        })
    }

    /// Like [`Importer::read`]. `open` reads the files to which the bytes refer.
    #[doc(hidden)]
    pub fn read_beside(&self, bytes: &[u8], name: &Path, open: &dyn Fn(&Path) -> Result<Vec<u8>>) -> Result<Scene> {
        self.read_source(&Source {
            bytes,
            blocks: None,
            name,
            release: &|_| {},
            open,
            list: &|_| Vec::new(),
        })
    }

    /// Like [`Importer::read`], with other files to which the bytes may refer, such as the skeleton of a motion or the
    /// buffers of a `.gltf`. Opens no file. Looks for a skeleton in the folder of `file` first.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::{Importer, MemoryFile};
    ///
    /// let motion = std::fs::read("fixtures/real/cmu_02_01.amc").unwrap();
    /// let skeleton = std::fs::read("fixtures/real/cmu_02.asf").unwrap();
    /// let motion = MemoryFile { name: "walk.amc", bytes: &motion };
    /// let skeleton = MemoryFile { name: "person.asf", bytes: &skeleton };
    /// let scene = Importer::new().read_among(motion, &[skeleton])?;
    /// assert_eq!(scene.nodes[0].name, "root");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`Importer::read`].
    pub fn read_among(&self, file: MemoryFile<'_>, others: &[MemoryFile<'_>]) -> Result<Scene> {
        self.among(file, others, |source| self.read_source(source))
    }

    /// Like [`Importer::import_character`], for a file in memory and the files to which it refers.
    ///
    /// # Errors
    /// The errors of [`Importer::import_character`].
    #[cfg(feature = "gltf")]
    pub fn read_character(&self, file: MemoryFile<'_>, others: &[MemoryFile<'_>]) -> Result<Character> {
        check_size(file.bytes.len() as u64, Path::new(file.name), &self.read.limits)?;
        self.among(file, others, |source| self.character(source))
    }

    pub(super) fn among<T>(
        &self,
        file: MemoryFile<'_>,
        others: &[MemoryFile<'_>],
        read: impl FnOnce(&Source<'_>) -> Result<T>,
    ) -> Result<T> {
        let name = Path::new(file.name);
        read(&Source {
            bytes: file.bytes,
            blocks: None,
            name,
            release: &|_| {},
            open: &|path| self.open_in_memory(path, others),
            list: &|extension| list(name, others, extension),
        })
    }

    fn open_in_memory(&self, path: &Path, files: &[MemoryFile<'_>]) -> Result<Vec<u8>> {
        let file = files.iter().find(|file| Path::new(file.name) == path);
        let bytes = file.ok_or_else(|| refused_from_memory(path))?.bytes;
        check_size(bytes.len() as u64, path, &self.read.limits)?;
        let mut copy = Vec::new();
        let reserved = copy.try_reserve_exact(bytes.len());
        reserved.map_err(|error| Error::io(path, std::io::Error::new(std::io::ErrorKind::OutOfMemory, error)))?;
        copy.extend_from_slice(bytes);
        Ok(copy)
    }
}

/// The files with this extension in the folder of `name`, or else in any folder, sorted.
fn list(name: &Path, files: &[MemoryFile<'_>], extension: &str) -> Vec<PathBuf> {
    let has_extension = |path: &&Path| {
        path.extension()
            .is_some_and(|found| found.eq_ignore_ascii_case(extension))
    };
    let all = files.iter().map(|file| Path::new(file.name)).filter(has_extension);
    let mut all: Vec<PathBuf> = all.map(Path::to_owned).collect();
    all.sort_unstable();
    let beside: Vec<PathBuf> = all
        .iter()
        .filter(|path| path.parent() == name.parent())
        .cloned()
        .collect();
    if beside.is_empty() { all } else { beside }
}
