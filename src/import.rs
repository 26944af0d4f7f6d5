//! From a file to a scene: the one place of the library that opens input files.

mod contents;
mod sha256;

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::thread;

use self::contents::Contents;
use self::sha256::Sha256Sum;
use crate::error::{Code, Diagnostic, Error, Result};
use crate::format::{FORMATS, FormatInfo, ReadOptions, Source};
use crate::limits::{Limits, positive};
use crate::pose::Binding;
use crate::process::{self, KeyTolerance, SkeletonMesh};
use crate::scene::{AppliedStep, Format, Origin, RootOffset, Scene};

/// Bytes from which on a file is mapped and worth a second thread.
const LARGE: usize = 4 << 20;

/// Imports a motion file with the default options.
///
/// ```
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// assert_eq!(scene.animations[0].channels[2].node_name, "Wrist");
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// # Errors
/// Whatever [`Importer::import`] returns.
pub fn import(path: impl AsRef<Path>) -> Result<Scene> {
    Importer::new().import(path)
}

/// Imports motion files with options.
///
/// ```
/// use mocap::{Importer, RootOffset};
///
/// let scene = Importer::new()
///     .root_offset(RootOffset::Replace)
///     .frame_rate(60.0)
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
}

/// Which animations of a file to keep.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Clips {
    /// All of them.
    #[default]
    All,
    /// The one at this place, from 0.
    Index(usize),
    /// The first one of this name.
    Name(String),
}

impl std::str::FromStr for Clips {
    type Err = std::convert::Infallible;

    /// `all`, a place from 0, or else a name.
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match (text, text.parse()) {
            ("all", _) => Self::All,
            (_, Ok(index)) => Self::Index(index),
            (name, Err(_)) => Self::Name(name.to_owned()),
        })
    }
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
            collapse_keys: true,
            strict: false,
            hash: true,
            clips: Clips::All,
        }
    }

    /// How a BVH root's OFFSET and its position channels combine. Default: [`RootOffset::Auto`], which decides from the
    /// first frame; [`Metadata::root_offset`](crate::scene::Metadata::root_offset) states the decision and its reason.
    ///
    /// Programs differ here: with the wrong choice the whole figure is moved by the OFFSET.
    ///
    /// ```
    /// use mocap::{Importer, RootOffset};
    ///
    /// let text = b"HIERARCHY ROOT a { OFFSET 0 9 0 CHANNELS 3 Xposition Yposition Zposition }
    ///     MOTION Frames: 1 Frame Time: 0.1\n0 1 0\n";
    /// let height = |policy| -> Result<f32, mocap::Error> {
    ///     let scene = Importer::new().root_offset(policy).read(text, "a.bvh")?;
    ///     Ok(scene.animations[0].channels[0].position_keys.values[0].y)
    /// };
    /// assert_eq!(height(RootOffset::Replace)?, 1.0);
    /// assert_eq!(height(RootOffset::Add)?, 10.0);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn root_offset(mut self, policy: RootOffset) -> Self {
        self.read.root_offset = policy;
        self
    }

    /// Frames per second, in place of the file's own. Default: the file's own.
    ///
    /// The motion keeps its frames and plays faster or slower; [`process::resample`](crate::process::resample) keeps
    /// the speed and makes new frames. Import fails with [`Code::UnknownOption`] where the rate is not finite and
    /// above 0.
    ///
    /// ```
    /// let scene = mocap::Importer::new().frame_rate(60.0).import("fixtures/real/lecture_Test.bvh")?;
    /// assert_eq!(scene.animations[0].ticks_per_second, 60.0);
    /// assert_eq!(scene.animations[0].frame_count(), 10);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn frame_rate(mut self, frames_per_second: f64) -> Self {
        self.read.frame_rate = Some(frames_per_second);
        self
    }

    /// Whether to read the rows of a BVH file beyond the number after `Frames:`. Default: `false`, those rows are left
    /// out. In both cases a [`Code::FrameCount`] warning states the two numbers.
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let text = b"HIERARCHY ROOT a { CHANNELS 1 Xrotation } MOTION Frames: 1 Frame Time: 0.1\n10\n20\n";
    /// let frames = |all| -> Result<usize, mocap::Error> {
    ///     Ok(Importer::new().all_rows(all).read(text, "a.bvh")?.animations[0].frame_count())
    /// };
    /// assert_eq!((frames(false)?, frames(true)?), (1, 2));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn all_rows(mut self, all: bool) -> Self {
        self.read.all_rows = all;
        self
    }

    /// Upper bounds for the counts and sizes in a file. Default: [`Limits::default`]. A file beyond them fails with
    /// [`Code::LimitExceeded`] before memory is taken for it. [`Limits`] has an example.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.read.limits = limits;
        self
    }

    /// The animations to keep of a file that has several. Default: all.
    ///
    /// ```
    /// use mocap::Clips;
    ///
    /// let importer = mocap::Importer::new().clips(Clips::Name("Run".to_owned()));
    /// let error = importer.import("fixtures/real/lecture_Test.bvh").unwrap_err();
    /// assert_eq!(error.code().as_str(), "unknown-option");
    /// ```
    #[must_use]
    pub fn clips(mut self, clips: Clips) -> Self {
        self.clips = clips;
        self
    }

    /// The format. Default: found from the contents, or else from the extension.
    ///
    /// A file whose beginning is broken is then read as that format, and the error names the place.
    ///
    /// ```
    /// use mocap::Importer;
    /// use mocap::scene::Format;
    ///
    /// let error = Importer::new().read(b"ROOT a {}", "take.txt").unwrap_err();
    /// assert_eq!(error.code().as_str(), "unknown-format");
    /// let error = Importer::new().format(Format::Bvh).read(b"ROOT a {}", "take.txt").unwrap_err();
    /// assert_eq!(error.code().as_str(), "missing-keyword");
    /// ```
    #[must_use]
    pub fn format(mut self, format: Format) -> Self {
        self.format = Some(format);
        self
    }

    /// The skeleton file of a motion whose skeleton is in a second file (`.amc` and its `.asf`). Default: found beside
    /// the motion, and not at all where the motion is read from memory. Without one, import fails with
    /// [`Code::MissingFile`].
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let motion = std::fs::read("fixtures/real/cmu_02_01.amc").unwrap();
    /// let importer = Importer::new();
    /// assert_eq!(importer.read(&motion, "walk.amc").unwrap_err().code().as_str(), "missing-file");
    /// let scene = importer.skeleton("fixtures/real/cmu_02.asf").read(&motion, "walk.amc")?;
    /// assert_eq!(scene.nodes[0].name, "root");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn skeleton(mut self, path: impl Into<PathBuf>) -> Self {
        self.skeleton = Some(path.into());
        self
    }

    /// The mesh that shows the skeleton. Default: [`SkeletonMesh::Segmented`]. A file with its own meshes, such as FBX,
    /// keeps those instead. With [`SkeletonMesh::None`] the scene has no meshes at all, and importing takes less time.
    ///
    /// ```
    /// use mocap::{Importer, SkeletonMesh};
    ///
    /// let meshes = |kind| -> Result<usize, mocap::Error> {
    ///     Ok(Importer::new().skeleton_mesh(kind).import("fixtures/real/lecture_Test.bvh")?.meshes.len())
    /// };
    /// assert!(meshes(SkeletonMesh::Segmented)? > 1);
    /// assert_eq!((meshes(SkeletonMesh::Skinned)?, meshes(SkeletonMesh::None)?), (1, 0));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn skeleton_mesh(mut self, kind: SkeletonMesh) -> Self {
        self.skeleton_mesh = kind;
        self.read.without_meshes = kind == SkeletonMesh::None;
        self
    }

    /// Whether a track that never changes is reduced to one key. Default: `true`. With `false` every rotation track
    /// has a key for each frame, as in the file.
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let keys = |collapse| -> Result<usize, mocap::Error> {
    ///     let text = b"HIERARCHY ROOT a { CHANNELS 1 Xrotation } MOTION Frames: 3 Frame Time: 0.1\n5\n5\n5\n";
    ///     let scene = Importer::new().collapse_keys(collapse).read(text, "a.bvh")?;
    ///     Ok(scene.animations[0].channels[0].rotation_keys.len())
    /// };
    /// assert_eq!((keys(true)?, keys(false)?), (1, 3));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn collapse_keys(mut self, collapse: bool) -> Self {
        self.collapse_keys = collapse;
        self
    }

    /// Whether a warning fails the import. Default: `false`, warnings are in [`Scene::warnings`]. With `true` the first
    /// warning becomes the error, and [`Error::warnings`] has the others.
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let text = b"HIERARCHY ROOT a { OFFSET 0 0 0 }";
    /// assert_eq!(Importer::new().read(text, "a.bvh")?.warnings[0].code.as_str(), "no-motion");
    /// let error = Importer::new().strict(true).read(text, "a.bvh").unwrap_err();
    /// assert_eq!(error.code().as_str(), "no-motion");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn strict(mut self, strict: bool) -> Self {
        self.strict = strict;
        self
    }

    /// Whether to compute [`Origin::sha256`]. Default: `true`, so that an output names the exact file it comes from. It
    /// takes about half as long as reading the numbers; with several threads it runs beside the reader.
    ///
    /// ```
    /// let scene = mocap::Importer::new().hash(false).import("fixtures/real/lecture_Test.bvh")?;
    /// assert_eq!(scene.metadata.origin.unwrap().sha256, "");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn hash(mut self, hash: bool) -> Self {
        self.hash = hash;
        self
    }

    /// The largest number of threads that read one file. Default: 0, which means the number of cores. The scene is the
    /// same with any number. Files below a few MB are read by one thread.
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let path = "fixtures/real/lecture_Test.bvh";
    /// assert_eq!(Importer::new().threads(1).import(path)?, Importer::new().threads(2).import(path)?);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.read.threads = NonZeroUsize::new(threads);
        self
    }

    /// Reads a file into a scene.
    ///
    /// # Errors
    /// [`Code::Io`] where the file, or a second file that it needs, cannot be opened; [`Code::UnknownFormat`] where the
    /// format is unknown; other codes where the contents are not valid.
    pub fn import(&self, path: impl AsRef<Path>) -> Result<Scene> {
        let path = path.as_ref();
        let contents = self.look_into(path)?;
        self.read_source(&Source {
            bytes: &contents,
            name: path,
            release: &|range| contents.release(range),
            open: &|other| self.open(other),
            list: &|extension| match &self.skeleton {
                Some(named) => vec![named.clone()],
                None => list_siblings(path, extension),
            },
        })
    }

    /// Reads bytes into a scene. `name` is the file name in errors; its extension tells the format if the contents do
    /// not. No file is opened except the one of [`Importer::skeleton`].
    ///
    /// # Errors
    /// [`Code::UnknownFormat`] where the format is unknown; [`Code::MissingFile`] where the bytes refer to another file;
    /// other codes where the contents are not valid.
    pub fn read(&self, bytes: &[u8], name: impl AsRef<Path>) -> Result<Scene> {
        self.read_source(&Source {
            bytes,
            name: name.as_ref(),
            release: &|_| {},
            open: &|other| match &self.skeleton {
                Some(named) if named == other => self.open(named),
                _ => Err(refused_from_memory(other)),
            },
            list: &|_| self.skeleton.clone().into_iter().collect(),
        })
    }

    /// The bytes of a file, if there are not more than the limits allow.
    pub(crate) fn open(&self, path: &Path) -> Result<Vec<u8>> {
        self.checked_size(path)?;
        std::fs::read(path).map_err(|error| Error::io(path, error))
    }

    /// The bytes of a file, where they need not all be in memory.
    fn look_into(&self, path: &Path) -> Result<Contents> {
        let size = self.checked_size(path)?;
        Contents::of(path, size).map_err(|error| Error::io(path, error))
    }

    fn checked_size(&self, path: &Path) -> Result<u64> {
        let size = std::fs::metadata(path).map_err(|error| Error::io(path, error))?.len();
        self.check_size(size, path)?;
        Ok(size)
    }

    fn check_size(&self, size: u64, path: &Path) -> Result<()> {
        let limit = self.read.limits.max_bytes;
        if size <= limit {
            return Ok(());
        }
        let diagnostic = Diagnostic::new(Code::LimitExceeded, "the file is larger than Limits::max_bytes")
            .expected_found(format!("at most {limit} bytes"), format!("{size} bytes"));
        Err(Error::from(diagnostic).with_path(path))
    }

    fn read_source(&self, source: &Source<'_>) -> Result<Scene> {
        self.check_size(source.bytes.len() as u64, source.name)?;
        if let Some(rate) = self.read.frame_rate {
            positive(Code::UnknownOption, "frame rate", rate)
                .map_err(|diagnostic| Error::from(diagnostic).with_path(source.name))?;
        }
        let (bytes, release) = (source.bytes, source.release);
        let mut sum = self.hash.then(|| Sha256Sum::new(bytes));
        let read = |source: &Source<'_>| {
            self.find_format(bytes, source.name)
                .and_then(|format| (format.read)(source, &self.read))
        };
        let scene = if bytes.len() < LARGE || self.read.threads == NonZeroUsize::new(1) {
            // What was read is in the processor's caches, and in memory: it is hashed before it is released.
            let shared = Mutex::new(sum.as_mut());
            let release = |range: Range<usize>| {
                if let Some(sum) = &mut *shared.lock().expect("hashing does not panic") {
                    sum.add_up_to(range.end);
                }
                release(range);
            };
            read(&Source {
                release: &release,
                ..*source
            })
        } else {
            thread::scope(|scope| {
                scope.spawn(|| sum.as_mut().map(|sum| sum.add_all(release)));
                read(source)
            })
        };
        let sha256 = sum.map_or_else(String::new, |mut sum| {
            sum.add_all(release);
            sum.finish()
        });
        scene
            .and_then(|scene| self.finish(scene, source, sha256))
            .map_err(|error| error.with_path(source.name))
    }

    /// The steps that follow every reader.
    fn finish(&self, mut scene: Scene, source: &Source<'_>, sha256: String) -> Result<Scene> {
        if self.strict && !scene.warnings.is_empty() {
            let first = scene.warnings.remove(0);
            return Err(Error::from(first).with_warnings(scene.warnings));
        }
        select(&mut scene, &self.clips)?;
        scene.metadata.origin = Some(origin(&scene, source.name, sha256));
        if scene.meshes.is_empty() {
            process::skeleton_mesh(&mut scene, self.skeleton_mesh);
        }
        name_nodes_of_channels(&mut scene);
        if self.collapse_keys {
            process::collapse_keys(&mut scene, KeyTolerance::default());
        }
        debug_assert_eq!(
            process::validate(&scene),
            [],
            "a reader made a scene that breaks the rules"
        );
        Ok(scene)
    }

    /// The explicit choice, else the contents, else the extension.
    fn find_format(&self, bytes: &[u8], name: &Path) -> Result<&'static FormatInfo> {
        if let Some(chosen) = self.format {
            let format = FORMATS.iter().find(|row| row.format == chosen);
            return format.ok_or_else(|| {
                let message = format!("this build does not read {chosen}");
                let help = format!("build it with the feature `{chosen}`");
                Diagnostic::new(Code::MissingFeature, message).help(help).into()
            });
        }
        if let Some(format) = FORMATS.iter().find(|format| (format.sniff)(bytes)) {
            return Ok(format);
        }
        let extension = name
            .extension()
            .and_then(|extension| extension.to_str())
            .unwrap_or_default();
        let has_extension = |format: &&FormatInfo| {
            format
                .extensions
                .iter()
                .any(|known| known.eq_ignore_ascii_case(extension))
        };
        FORMATS.iter().find(has_extension).ok_or_else(|| {
            let known: Vec<_> = FORMATS.iter().map(|row| row.format.as_str()).collect();
            let message = "neither the contents nor the extension belong to a known format";
            Diagnostic::new(Code::UnknownFormat, message)
                .expected_found(known.join(", "), format!("the extension \"{extension}\""))
                .into()
        })
    }
}

/// Drops all animations but the chosen one.
fn select(scene: &mut Scene, clips: &Clips) -> Result<()> {
    let index = match clips {
        Clips::All => return Ok(()),
        Clips::Index(index) => Some(*index).filter(|&index| index < scene.animations.len()),
        Clips::Name(name) => scene.animations.iter().position(|clip| clip.name == *name),
    };
    let Some(index) = index else {
        let names = scene.animations.iter().enumerate();
        let known: Vec<_> = names
            .map(|(index, clip)| format!("{index} \"{}\"", clip.name))
            .collect();
        let found = match clips {
            Clips::Name(name) => format!("\"{name}\""),
            Clips::Index(index) => format!("{index}"),
            Clips::All => String::new(),
        };
        let known = if known.is_empty() {
            "no clip".to_owned()
        } else {
            known.join(", ")
        };
        return Err(Diagnostic::new(Code::UnknownOption, "the file does not have this clip")
            .expected_found(known, found)
            .into());
    };
    scene.animations = vec![scene.animations.swap_remove(index)];
    scene.metadata.steps.push(AppliedStep::SelectClip { index });
    Ok(())
}

/// Tells every channel its node, where the reader has not: by its name, as [`Binding::new`] does.
fn name_nodes_of_channels(scene: &mut Scene) {
    for index in 0..scene.animations.len() {
        let animation = &scene.animations[index];
        if animation.channels.iter().all(|channel| channel.node.is_some()) {
            continue;
        }
        let driven: Vec<_> = Binding::new(scene, animation).driven().collect();
        for (node, channel) in driven {
            scene.animations[index].channels[channel].node = Some(node);
        }
    }
}

/// What tells the file again, and what motion was read from it.
fn origin(scene: &Scene, name: &Path, sha256: String) -> Origin {
    let name = name.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let animation = scene.animations.first();
    Origin {
        name,
        sha256,
        frames: animation.map_or(0, |animation| animation.frame_count() as u64),
        frame_time: animation.map_or(0.0, |animation| animation.ticks_per_second.recip()),
    }
}

/// The files beside `path` that have this extension, in any case, sorted by name. A folder that cannot be listed has
/// none: whoever asks says what is missing.
fn list_siblings(path: &Path, extension: &str) -> Vec<PathBuf> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let has_extension = |file: &PathBuf| {
        file.extension()
            .is_some_and(|found| found.eq_ignore_ascii_case(extension))
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<_> = entries
        .map(|entry| path.with_file_name(entry.file_name()))
        .filter(has_extension)
        .collect();
    files.sort();
    files
}

fn refused_from_memory(other: &Path) -> Error {
    let message = format!("bytes in memory cannot refer to the file \"{}\"", other.display());
    Diagnostic::new(Code::MissingFile, message)
        .help("import the file by its path, or name the second file")
        .into()
}
