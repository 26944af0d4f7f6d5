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
use crate::limits::Limits;
use crate::pose::Binding;
use crate::process::{self, KeyTolerance, SkeletonMesh};
use crate::scene::{Format, Origin, RootOffset, Scene};

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

/// Imports motion files as its options say.
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
        }
    }

    /// What to do with a root's OFFSET when the root has position channels too. Default: [`RootOffset::Auto`].
    #[must_use]
    pub fn root_offset(mut self, policy: RootOffset) -> Self {
        self.read.root_offset = policy;
        self
    }

    /// Frames per second to take in place of the file's own. Default: the file's own.
    #[must_use]
    pub fn frame_rate(mut self, frames_per_second: f64) -> Self {
        self.read.frame_rate = Some(frames_per_second);
        self
    }

    /// Whether to read rows beyond the declared number of frames. Default: no.
    #[must_use]
    pub fn all_rows(mut self, all: bool) -> Self {
        self.read.all_rows = all;
        self
    }

    /// Upper bounds for what a file may claim. Default: [`Limits::default`].
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.read.limits = limits;
        self
    }

    /// The format. Default: found from the contents, else from the extension.
    #[must_use]
    pub fn format(mut self, format: Format) -> Self {
        self.format = Some(format);
        self
    }

    /// The file that holds the skeleton, for motions that keep it in a file of its own (`.amc` and its `.asf`).
    /// Default: found beside the motion.
    #[must_use]
    pub fn skeleton(mut self, path: impl Into<PathBuf>) -> Self {
        self.skeleton = Some(path.into());
        self
    }

    /// The mesh that shows the skeleton. Default: [`SkeletonMesh::Segmented`]. A file that has meshes of its own, as
    /// FBX may, keeps those instead, but for [`SkeletonMesh::None`].
    #[must_use]
    pub fn skeleton_mesh(mut self, kind: SkeletonMesh) -> Self {
        self.skeleton_mesh = kind;
        self.read.without_meshes = kind == SkeletonMesh::None;
        self
    }

    /// Whether a track that never changes is left one key. Default: yes.
    #[must_use]
    pub fn collapse_keys(mut self, collapse: bool) -> Self {
        self.collapse_keys = collapse;
        self
    }

    /// Whether every warning is an error. Default: no.
    #[must_use]
    pub fn strict(mut self, strict: bool) -> Self {
        self.strict = strict;
        self
    }

    /// Whether to compute [`Origin::sha256`], which takes about half as long as reading the numbers, in a thread of its own
    /// where several may read. Default: yes.
    #[must_use]
    pub fn hash(mut self, hash: bool) -> Self {
        self.hash = hash;
        self
    }

    /// How many threads may read one file. The scene is the same with any number; small files are read by one.
    /// Default: one a core.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.read.threads = NonZeroUsize::new(threads);
        self
    }

    /// Reads a file into a scene.
    ///
    /// # Errors
    /// Where the file, or another that belongs to it, cannot be opened; where it is of no known format, or breaks the
    /// rules of its own.
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

    /// Reads bytes into a scene. `name` stands for the file in errors; its extension tells the format if nothing else
    /// does. No file is opened but the one that [`Importer::skeleton`] names.
    ///
    /// # Errors
    /// Where the bytes are of no known format, break the rules of their own, or refer to another file.
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
        let diagnostic = Diagnostic::new(Code::LimitExceeded, "the file is larger than the limits allow")
            .expected_found(format!("at most {limit} bytes"), format!("{size} bytes"));
        Err(Error::from(diagnostic).with_path(path))
    }

    fn read_source(&self, source: &Source<'_>) -> Result<Scene> {
        self.check_size(source.bytes.len() as u64, source.name)?;
        let frame_rate = self.read.frame_rate.unwrap_or(1.0);
        if !(frame_rate.is_finite() && frame_rate > 0.0) {
            let diagnostic = Diagnostic::new(Code::UnknownOption, "the frame rate asked for is no frame rate")
                .expected_found("frames per second, above 0", format!("{frame_rate}"));
            return Err(Error::from(diagnostic).with_path(source.name));
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
            let message = "neither the contents nor the name say a known format";
            Diagnostic::new(Code::UnknownFormat, message)
                .expected_found(known.join(", "), format!("the extension \"{extension}\""))
                .into()
        })
    }
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
    let message = format!("bytes from memory cannot refer to \"{}\"", other.display());
    Diagnostic::new(Code::MissingFile, message)
        .help("import the file itself, or name the other one")
        .into()
}
