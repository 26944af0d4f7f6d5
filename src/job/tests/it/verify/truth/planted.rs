//! Corruptions that are planted in the files themselves, by code that is independent of the writers, the readers and
//! `verify`. The corruptions change the JSON and the bytes of glTF, the elements of FBX, the lines of text, the arrays
//! of NumPy and the columns of Parquet.

mod fbx;
mod gltf;
mod lines;
#[cfg(feature = "parquet")]
mod parquet;
mod tables;

use std::collections::BTreeMap;
use std::path::Path;

/// The files of an output, by name.
#[derive(Clone, PartialEq)]
pub(super) struct Files {
    /// The name of the output.
    pub(super) main: String,
    pub(super) all: BTreeMap<String, Vec<u8>>,
}

impl Files {
    /// All files of a folder.
    pub(super) fn of(folder: &Path, main: &str) -> Self {
        let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let named = files.map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read(path).unwrap())
        });
        let main = main.to_owned();
        Self {
            main,
            all: named.collect(),
        }
    }

    pub(super) fn write(&self, folder: &Path) {
        for (name, bytes) in &self.all {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    }

    fn main(&mut self) -> &mut Vec<u8> {
        self.all.get_mut(&self.main).unwrap()
    }

    fn extension(&self) -> &str {
        self.main.rsplit('.').next().unwrap()
    }
}

/// The kind of source from which the output was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Of {
    /// A motion.
    Walk,
    /// A character with a skin, a texture, a morph target and two clips.
    Character,
    /// A motion that was retargeted to this character, compared with the character.
    Onto,
}

/// A corruption of files.
pub(super) struct Plant {
    pub(super) name: &'static str,
    pub(super) of: Of,
    pub(super) formats: &'static [&'static str],
    /// Changes the files; returns `false` if the file has nothing of this kind.
    pub(super) plant: fn(&mut Files) -> bool,
}

/// All corruptions.
pub(super) fn plants() -> Vec<&'static Plant> {
    let mut all: Vec<&Plant> = Vec::new();
    all.extend(gltf::PLANTS);
    all.extend(fbx::PLANTS);
    all.extend(lines::PLANTS);
    all.extend(tables::PLANTS);
    #[cfg(feature = "parquet")]
    all.extend(parquet::PLANTS);
    all
}

const fn of_walk(name: &'static str, formats: &'static [&'static str], plant: fn(&mut Files) -> bool) -> Plant {
    Plant {
        name,
        of: Of::Walk,
        formats,
        plant,
    }
}

const fn of_character(name: &'static str, formats: &'static [&'static str], plant: fn(&mut Files) -> bool) -> Plant {
    Plant {
        of: Of::Character,
        ..of_walk(name, formats, plant)
    }
}

const fn onto(name: &'static str, formats: &'static [&'static str], plant: fn(&mut Files) -> bool) -> Plant {
    Plant {
        of: Of::Onto,
        ..of_walk(name, formats, plant)
    }
}
