//! Reads a file into a scene. No other module of the library opens input files.

#[doc(hidden)]
pub mod attribution;
#[cfg(feature = "arrays")]
mod body;
mod clips;
mod contents;
#[cfg(feature = "arrays")]
mod frames;
#[doc(hidden)]
pub(crate) mod large;
mod memory;
mod options;
mod reading;
mod sha256;
#[cfg(feature = "solve")]
mod solved;

use std::io::Read;
use std::path::{Path, PathBuf};

#[cfg(any(feature = "arrays", feature = "solve"))]
use mocap_formats::FormatInfo;
use mocap_formats::{Contents, ReadOptions, Source, read_robot};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::decode_text;
use mocap_scene::limits::Limits;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Format, Scene, Topic};

pub use self::clips::Clips;
use self::contents::{Input, list_siblings};
pub use self::memory::MemoryFile;
#[cfg(feature = "gltf")]
use mocap_formats::gltf::Character;
#[cfg(feature = "solve")]
use mocap_solve::{Lengths, MarkerWeights};

/// Imports a motion file with the default options.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// assert_eq!(scene.animations[0].channels[2].node_name, "Wrist");
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// The errors of [`Importer::import`].
pub fn import(path: impl AsRef<Path>) -> Result<Scene> {
    Importer::new().import(path)
}

/// Imports motion files with options.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::{Importer, RootOffset};
///
/// let scene = Importer::new()
///     .root_offset(RootOffset::Replace)
///     .retime(60.0)
///     .import("fixtures/real/lecture_Test.bvh")?;
/// assert_eq!(scene.animations[0].ticks_per_second, 60.0);
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Importer {
    read: ReadOptions,
    format: Option<Format>,
    skeleton: Option<PathBuf>,
    skeleton_mesh: SkeletonMesh,
    collapse_keys: bool,
    strict: bool,
    hash: bool,
    clips: Clips,
    #[cfg(feature = "solve")]
    joints: Option<String>,
    #[cfg(feature = "solve")]
    lengths: Option<Lengths>,
    #[cfg(feature = "solve")]
    markers: Option<String>,
    #[cfg(feature = "solve")]
    marker_weights: MarkerWeights,
    #[cfg(feature = "solve")]
    standing: Option<PathBuf>,
    #[cfg(feature = "arrays")]
    body: Option<PathBuf>,
    robot_meshes: bool,
}

impl Default for Importer {
    fn default() -> Self {
        Self::new()
    }
}

impl Importer {
    /// An importer with the default options.
    pub fn new() -> Self {
        Self {
            read: ReadOptions::default(),
            format: None,
            skeleton: None,
            skeleton_mesh: SkeletonMesh::default(),
            robot_meshes: false,
            collapse_keys: true,
            strict: false,
            hash: true,
            clips: Clips::All,
            #[cfg(feature = "solve")]
            joints: None,
            #[cfg(feature = "solve")]
            lengths: None,
            #[cfg(feature = "solve")]
            markers: None,
            #[cfg(feature = "solve")]
            marker_weights: MarkerWeights::default(),
            #[cfg(feature = "solve")]
            standing: None,
            #[cfg(feature = "arrays")]
            body: None,
        }
    }

    /// Reads a file into a scene. Reads a pipe or a device to its end, at most 1 GiB. The files of a folder are the
    /// frames of one take, as SAM 3D Body writes them.
    ///
    /// # Errors
    /// - [`Code::Io`]: the file, or a second file that it needs, cannot be opened.
    /// - [`Code::UnknownFormat`]: the format is unknown.
    /// - Other codes: the contents are not valid.
    pub fn import(&self, path: impl AsRef<Path>) -> Result<Scene> {
        let path = path.as_ref();
        #[cfg(feature = "arrays")]
        if Self::reads_folder(path) {
            return self.import_folder(path);
        }
        let input = contents::open(path, &self.read.limits, self.format.is_some())?;
        let source = Source {
            bytes: match &input {
                Input::Whole(bytes) => bytes,
                Input::Large(file) => file.beginning(),
            },
            blocks: None,
            name: path,
            release: &|_| {},
            open: &|other| self.open(other),
            list: &|extension| match &self.skeleton {
                Some(named) => vec![named.clone()],
                None => list_siblings(path, extension),
            },
        };
        let mut scene = match &input {
            Input::Whole(_) => self.read_source(&source),
            Input::Large(file) => self.read_large(file, &source),
        }?;
        attribution::complete(&mut scene, path)?;
        Ok(scene)
    }

    /// Imports a motion that the caller resamples to `rate`. Reads the motion at its own frame rate, or at `rate` if
    /// the file states none. If the file's own rate makes more frames than the limits allow, curves are sampled at
    /// `rate`. The closure `import` gets the importer to use.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    ///
    /// let scene = Importer::new().at_rate(Some(30.0), |importer| importer.import("fixtures/real/cmu_02_01.amc"))?;
    /// assert_eq!(scene.animations[0].ticks_per_second, 30.0); // an .amc states no rate
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of `import`.
    pub fn at_rate(&self, rate: Option<f64>, import: impl Fn(&Self) -> Result<Scene>) -> Result<Scene> {
        let assumes_rate = |scene: &Scene| {
            let mut assumptions = scene.metadata.assumptions.iter();
            assumptions.any(|assumption| assumption.topic == Topic::FrameRate)
        };
        let at = |rate| import(&self.clone().retime(rate));
        match (import(self), rate) {
            (Err(error), Some(rate)) if error.code() == Code::FrameTime => at(rate),
            (Ok(scene), Some(rate)) if assumes_rate(&scene) => at(rate),
            (Err(error), Some(rate)) if error.code() == Code::LimitExceeded => {
                import(&self.clone().sampling_rate(rate)).map_err(|_| error)
            }
            (result, _) => result,
        }
    }

    /// Reads a glTF or VRM character, to which an output adds animations. The output keeps everything else of the file.
    ///
    /// # Errors
    /// [`Code::UnknownFormat`] if the file has another format, and the errors of [`Importer::import`].
    #[cfg(feature = "gltf")]
    pub fn import_character(&self, path: impl AsRef<Path>) -> Result<Character> {
        self.with_file(path.as_ref(), |source| self.character(source))
    }

    /// Reads a file that refers to other files.
    fn with_file<T>(&self, path: &Path, read: impl FnOnce(&Source<'_>) -> Result<T>) -> Result<T> {
        let bytes = self.open(path)?;
        read(&Source {
            bytes: &bytes,
            blocks: None,
            name: path,
            release: &|_| {},
            open: &|other| self.open(other),
            list: &|_| Vec::new(),
        })
    }

    #[cfg(feature = "gltf")]
    fn character(&self, source: &Source<'_>) -> Result<Character> {
        let path = source.name;
        if self.find_format(source.bytes, path)?.format != Format::Gltf {
            let message = "a character whose file is kept must be a glTF or VRM file";
            return Err(Error::from(Diagnostic::new(Code::UnknownFormat, message)).with_path(path));
        }
        let mut character = Character::read(source, &self.read).map_err(|error| error.with_path(path))?;
        let sha256 = match self.hash {
            true => sha256::Sha256Sum::of(source.bytes),
            false => String::new(),
        };
        let scene = self.finish(std::mem::take(&mut character.scene), source, sha256);
        character.scene = scene.map_err(|error| error.with_path(path))?;
        Ok(character)
    }

    /// Reads a robot from URDF or MJCF: links, joints, limits and shapes. The scene of [`Importer::import`] has the
    /// skeleton, but no limits and shapes.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let robot = mocap::Importer::new().import_robot("fixtures/robots/h1.urdf")?;
    /// assert_eq!(robot.dof_names().len(), 19);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::UnknownFormat`] if the file has another format, and the errors of [`Importer::import`].
    pub fn import_robot(&self, path: impl AsRef<Path>) -> Result<Robot> {
        self.with_file(path.as_ref(), |source| self.robot(source))
    }

    /// Like [`import_robot`](Self::import_robot), from bytes. `name` is for errors. Does not look for meshes.
    ///
    /// # Errors
    /// The errors of [`Importer::import_robot`].
    pub fn read_robot(&self, bytes: &[u8], name: impl AsRef<Path>) -> Result<Robot> {
        self.robot(&Source::of_bytes(bytes, name.as_ref()))
    }

    /// Like [`read_robot`](Self::read_robot), with other files in which to look for meshes.
    ///
    /// # Errors
    /// The errors of [`Importer::import_robot`].
    pub fn read_robot_among(&self, file: MemoryFile<'_>, others: &[MemoryFile<'_>]) -> Result<Robot> {
        self.among(file, others, |source| self.robot(source))
    }

    fn robot(&self, source: &Source<'_>) -> Result<Robot> {
        let format = self.find_format(source.bytes, source.name);
        let read = format.and_then(|row| match (row.contents, row.format) {
            (Contents::Robot, _) => read_robot(source, &self.read.limits, self.robot_meshes),
            (_, other) => {
                let message = format!("the file is {other}, not a robot");
                Err(Diagnostic::new(Code::UnknownFormat, message)
                    .expected_found("urdf or mjcf", other.as_str())
                    .into())
            }
        });
        read.map_err(|error| error.with_path(source.name))
    }

    /// Reads a stream, such as standard input, into bytes for [`Importer::read`]. The stream must end within 1 GiB, or
    /// within [`Limits::max_bytes`] if that is less. Reading stops early if the beginning belongs to no known format.
    /// Reading does not stop early if [`Importer::format`] or the extension of `name` names a format.
    ///
    /// ```
    /// let text = &b"HIERARCHY ROOT a { CHANNELS 1 Xrotation } MOTION Frames: 1 Frame Time: 0.1\n10\n"[..];
    /// let importer = mocap::Importer::new();
    /// let bytes = importer.read_stream(text, "standard input")?;
    /// let scene = importer.read(&bytes, "standard input")?;
    /// assert_eq!(scene.nodes[0].name, "a");
    ///
    /// let error = importer.read_stream(std::io::repeat(0), "zeros").unwrap_err();
    /// assert_eq!(error.code().as_str(), "unknown-format");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Code::Io`], [`Code::LimitExceeded`] and [`Code::UnknownFormat`].
    pub fn read_stream(&self, stream: impl Read, name: impl AsRef<Path>) -> Result<Vec<u8>> {
        let name = name.as_ref();
        let is_known = self.format.is_some() || contents::format_of_extension(name).is_some();
        contents::read_stream(stream, name, &self.read.limits, is_known)
    }

    /// The bytes of a regular file, if the limits allow its size.
    #[doc(hidden)]
    pub fn open(&self, path: &Path) -> Result<Vec<u8>> {
        contents::open_named(path, &self.read.limits)
    }
}

/// The text of a small file that a job names in addition to its motions.
#[doc(hidden)]
pub fn read_text(path: &Path) -> Result<String> {
    let bytes = contents::open_named(path, &Limits::default())?;
    decode_text(bytes).ok_or_else(|| {
        let message = "the file is not UTF-8 text";
        Error::from(Diagnostic::new(Code::BinaryFile, message)).with_path(path)
    })
}

/// Whether the scene was read from a file of arrays.
#[cfg(any(feature = "arrays", feature = "solve"))]
fn is_array(scene: &Scene) -> bool {
    let format = scene.metadata.format;
    format.is_some_and(|format| FormatInfo::of(format).contents == Contents::Arrays)
}
