//! The result of a writer: files in memory, and a report about them.

use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use mocap_compress::CompressedClip;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::files::{FilePart, OutputSet, ReplacePolicy};
use mocap_scene::scene::Scene;
use mocap_scene::scene::report::DataLoss;

/// A scene as files of a format in memory, with a report about them.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::{Conversion, Exporter, Format};
///
/// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// Conversion::new().apply(&mut scene)?;
/// let written = Exporter::new().max_error(0.001).write(&scene, Format::Gltf)?;
/// assert!(written.error.as_ref().unwrap().max_error <= 0.001);
/// assert!(written.into_bytes()?.starts_with(b"glTF"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Export {
    /// The files. The last one is the requested file. It refers to the others, which belong in its folder.
    pub files: Vec<ExportFile>,
    /// Sentences about dropped data and decisions.
    pub notes: Vec<String>,
    /// Warnings about what a reader of the files may misinterpret, such as [`Code::UnknownUnit`].
    pub warnings: Vec<Diagnostic>,
    /// Data that the scene or its source file has, but that the files lack. Each loss is also a warning:
    /// [`Code::NotCarriedOver`].
    pub losses: Vec<DataLoss>,
    /// The renamed nodes.
    pub renamed: Vec<NodeRename>,
    /// The deviation of the files from the scene, the largest of all animations. Absent if every key was kept
    /// unchanged.
    pub error: Option<Deviation>,
    /// The number of skeleton nodes in the files, including end sites.
    pub nodes: usize,
}

/// An output of one file that was not written by a format's writer, such as a character with added animations.
impl From<Vec<u8>> for Export {
    fn from(bytes: Vec<u8>) -> Self {
        Self::of(vec![ExportFile::new("", bytes)])
    }
}

impl Export {
    /// Files without a report.
    #[doc(hidden)]
    pub fn of(files: Vec<ExportFile>) -> Self {
        Self {
            files,
            ..Self::default()
        }
    }

    /// The size of all files in bytes.
    pub fn len(&self) -> usize {
        self.files.iter().map(ExportFile::len).sum()
    }

    /// Whether the files have no bytes. Every format writes some bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bytes of an output that is a single file.
    ///
    /// # Errors
    /// [`Code::InvalidValue`] if there are other files.
    pub fn into_bytes(mut self) -> Result<Vec<u8>> {
        match (self.files.pop(), self.files.as_slice()) {
            (Some(file), []) => Ok(file.into_bytes()),
            (_, beside) => {
                let names: Vec<&str> = beside.iter().map(ExportFile::name).collect();
                let message = "the output is several files, but a single stream of bytes was requested";
                Err(Diagnostic::new(Code::InvalidValue, message)
                    .expected_found("one file", format!("{} beside it", names.join(", ")))
                    .help(
                        "write to a path, or embed the buffer (BufferPlace::Embedded) and the textures \
                        (FbxTextures::Embedded)",
                    )
                    .into())
            }
        }
    }

    /// Makes the checks of [`save`](Self::save), and writes nothing. Returns the paths of the files, the requested one
    /// last.
    ///
    /// # Errors
    /// [`Code::OutputIsInput`] and [`Code::OutputExists`], by the rules of [`ReplacePolicy`].
    pub fn check(&self, path: impl AsRef<Path>, policy: &ReplacePolicy) -> Result<Vec<PathBuf>> {
        let set = self.output_set(path)?;
        set.check(policy)?;
        Ok(set.files().map(|(path, _)| path.to_owned()).collect())
    }

    /// Writes the files to `path` and into its folder: all or none, if `policy` allows them to replace existing files.
    /// `path` must have the name for which they were made.
    ///
    /// # Errors
    /// The errors of [`check`](Self::check), and [`Code::Io`].
    pub fn save(&self, path: impl AsRef<Path>, policy: &ReplacePolicy) -> Result<()> {
        self.output_set(path)?.save(policy)
    }

    /// The files, with their paths at `path` and in its folder.
    ///
    /// # Errors
    /// The errors of [`OutputSet::add_beside`].
    #[doc(hidden)]
    pub fn output_set(&self, path: impl AsRef<Path>) -> Result<OutputSet<'_>> {
        let mut set = OutputSet::new();
        self.add_to(&mut set, path.as_ref())?;
        Ok(set)
    }

    /// Adds the files, at `path` and in its folder, to an output.
    ///
    /// # Errors
    /// The errors of [`OutputSet::add_beside`].
    #[doc(hidden)]
    pub fn add_to<'a>(&'a self, set: &mut OutputSet<'a>, path: &Path) -> Result<()> {
        let Some((main, beside)) = self.files.split_last() else {
            return Ok(());
        };
        for file in beside {
            set.add_beside(path, &file.name, file.stored())?;
        }
        set.add(path, main.stored());
        Ok(())
    }
}

/// A file of an [`Export`].
///
/// [`Export`](crate::Export) has an example.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExportFile {
    name: String,
    /// The bytes in parts, so that a large buffer is never copied.
    parts: Vec<FilePart<'static>>,
}

impl ExportFile {
    #[doc(hidden)]
    pub fn new(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self::of_parts(name, [bytes])
    }

    pub(crate) fn of_parts(
        name: impl Into<String>,
        parts: impl IntoIterator<Item = impl Into<FilePart<'static>>>,
    ) -> Self {
        Self {
            name: name.into(),
            parts: parts.into_iter().map(Into::into).collect(),
        }
    }

    /// The name, without a folder.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of bytes.
    pub fn len(&self) -> usize {
        self.parts.iter().map(FilePart::len).sum()
    }

    /// Whether the file has no bytes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The bytes. They are copied if they are in several parts.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        match self.parts.as_slice() {
            [only] => only.bytes(),
            _ => Cow::Owned(self.concatenated()),
        }
    }

    /// The bytes, part by part. A large buffer is a separate part. A long text is unpacked.
    pub fn parts(&self) -> impl Iterator<Item = Cow<'_, [u8]>> {
        self.parts.iter().map(FilePart::bytes)
    }

    /// The parts, without unpacking long texts.
    fn stored(&self) -> impl Iterator<Item = FilePart<'_>> {
        self.parts.iter().map(FilePart::borrowed)
    }

    fn concatenated(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.len());
        self.parts().for_each(|part| bytes.extend_from_slice(&part));
        bytes
    }

    /// The bytes. They are copied if they are in several parts.
    pub fn into_bytes(mut self) -> Vec<u8> {
        match (self.parts.pop(), self.parts.is_empty()) {
            (Some(only), true) => only.into_bytes(),
            (last, _) => {
                self.parts.extend(last);
                self.concatenated()
            }
        }
    }
}

/// A renamed node.
///
/// Clients find animated nodes by name or by a path of names, so a duplicate name animates the wrong node. three.js
/// removes `[ ] . : /` and replaces spaces by `_`; names are unique even after these changes. Control characters and
/// `/`, which separates the names of a path in Unity, become `_`. Other characters do not change.
///
/// [`Export`](crate::Export) has an example.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NodeRename {
    /// Index into [`Scene::nodes`], and into the file's nodes.
    pub node: usize,
    /// The name in the scene.
    pub from: String,
    /// The name in the file.
    pub to: String,
    /// Whether the name was requested, and the file could also have the old name.
    pub is_asked_for: bool,
}

impl fmt::Display for NodeRename {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "node \"{}\" has the name \"{}\" in the file", self.from, self.to)
    }
}

/// The error of a file against the scene that it was written from. mocap measures the error in double precision on the
/// decoded values, at the times of the file, with every interpolation that readers of the format use. In glTF these are
/// slerp and nlerp (component by component).
///
/// [`Export`](crate::Export) has an example.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Deviation {
    /// The largest distance of a joint or end site from its position in the scene, in metres.
    pub max_error: f64,
    /// The RMS of all distances in metres.
    pub rms_error: f64,
    /// The name of the node with the largest distance.
    pub joint: String,
    /// The tick of the largest distance.
    pub tick: f64,
    /// The number of keys in the file, of all tracks.
    pub keys: usize,
}

impl Deviation {
    /// Adds the error of another animation, whose unit of length is `metres` metres.
    pub(super) fn add(sum: &mut Option<Self>, scene: &Scene, clip: &CompressedClip, metres: f64) {
        let achieved = sum.get_or_insert_default();
        achieved.keys += clip.key_count();
        achieved.rms_error = achieved.rms_error.max(clip.error.rms * metres);
        let max_error = clip.error.max * metres;
        if max_error > achieved.max_error || achieved.joint.is_empty() {
            let node = scene.nodes.get(clip.error.node);
            achieved.max_error = max_error;
            achieved.joint = node.map_or_else(String::new, |node| node.name.clone());
            achieved.tick = clip.error.tick;
        }
    }
}

/// A length in millimetres for a note, without the unit.
pub(super) fn millimetres(metres: f64) -> String {
    format!("{:.4}", metres * 1000.0)
}

/// A warning if the lengths of `scene` are not known to be metres, for a format in metres.
pub(super) fn unit_warning(scene: &Scene, format: &str) -> Option<Diagnostic> {
    let message = match scene.metadata.metres_per_unit {
        Some(1.0) => return None,
        Some(metres) => format!("{format} is in metres, but the scene is in units of {metres} m"),
        None => format!("{format} is in metres, but the unit of the scene is not stated"),
    };
    let help = "convert the scene first: Conversion::new().apply(&mut scene)";
    Some(Diagnostic::new(Code::UnknownUnit, message).help(help))
}
