//! The table of formats that can be read and written.
//!
//! To add a format: a folder with its row, which [`FormatInfo::ALL`] lists, a feature, and fixtures with their origin.
//! A row with `write` is a format that every door writes: each takes names, extensions and options from here.
//!
//! A build without the feature of a format keeps its row, so that its files are recognised and the error names the
//! feature. Only the reader and the writer are left out.

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]
// With fewer formats, parts of what formats share have no use.
#![cfg_attr(
    not(all(feature = "all-formats", feature = "fbx", feature = "npz")),
    allow(dead_code)
)]

#[macro_use]
mod left_out;

mod array_files;
mod asf_amc;
mod bip;
pub mod bvh;
mod c3d;
#[cfg(any(feature = "mmd", feature = "usd"))]
mod depth_first;
pub mod dump;
pub mod fbx;
#[cfg(any(feature = "arrays", feature = "c3d", feature = "trc"))]
mod frames;
pub mod gltf;
#[cfg(any(feature = "mjcf", feature = "urdf"))]
mod inertial;
#[doc(hidden)]
pub mod internals;
mod ledger;
mod lookup;
mod mclip;
#[cfg(any(feature = "mjcf", feature = "urdf"))]
mod mesh_bounds;
#[cfg(any(feature = "mjcf", feature = "urdf"))]
#[doc(hidden)]
mod mesh_surface;
#[cfg(any(feature = "mjcf", feature = "urdf"))]
mod mimic;
mod mjcf;
mod mmd;
#[cfg(any(feature = "fbx", feature = "gltf", feature = "usd"))]
mod morph_targets;
#[cfg(any(feature = "fbx", feature = "gltf", feature = "mjcf", feature = "urdf"))]
mod named_file;
#[doc(hidden)]
pub mod numbers;
mod option;
#[cfg(any(feature = "arrays", feature = "c3d", feature = "trc"))]
mod points;
#[cfg(any(feature = "arrays", feature = "mmd"))]
mod proportions;
mod provenance;
#[doc(hidden)]
pub mod read_back;
pub mod report;
#[cfg(any(feature = "mjcf", feature = "urdf"))]
mod robot_as_scene;
mod sidecar;
#[doc(hidden)]
mod text;
#[cfg(any(feature = "fbx", feature = "gltf", feature = "usd"))]
mod texture;
mod trc;
#[cfg(any(feature = "bvh", feature = "fbx", feature = "gltf", feature = "trc", feature = "usd"))]
mod unique_names;
#[doc(hidden)]
pub mod unread;
mod urdf;
#[doc(hidden)]
pub mod usd;
mod warnings;
mod written;
#[cfg(any(feature = "mjcf", feature = "urdf"))]
mod xml;

use std::fmt;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::{Path, PathBuf};
#[cfg(feature = "arrays")]
use std::sync::Arc;

use mocap_compress::ErrorBound;
use mocap_figure::Humanoid;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::limits::{self, FrameBudget, Limits};
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::report::DataKind;
use mocap_scene::scene::robot::Robot;
use mocap_scene::scene::{Format, RootOffset, Scene};

#[cfg(feature = "arrays")]
#[doc(hidden)]
pub use self::array_files::{Body, BodyFrames, MHR_ROOT_HEIGHT, SMPL_ROOT, body_model, humanml3d, mhr_frames};
#[cfg(feature = "parquet")]
#[doc(hidden)]
pub use self::array_files::{ParquetRows, parquet_rows};
#[cfg(feature = "gltf")]
pub use self::gltf::vrma;
#[doc(hidden)]
pub use self::ledger::Carriage;
#[doc(hidden)]
pub use self::option::{WriteOption, words};
#[doc(hidden)]
pub use self::sidecar::Sidecar;
pub use self::written::{Export, ExportFile};

/// The error of a step of a reader. Boxed, so that the results of all steps are small.
#[doc(hidden)]
pub type Failure = Box<Diagnostic>;

/// The row of a format: its names, how it is recognised, how it is read and written, and what can be chosen of that.
///
/// ```
/// use mocap::{Format, FormatInfo};
///
/// let written = FormatInfo::ALL.iter().filter(|row| row.writes()).flat_map(|row| row.extensions);
/// assert!(written.copied().any(|extension| extension == "glb"));
/// assert_eq!(FormatInfo::of_output("walk.VRMA".as_ref()).unwrap().format, Format::Vrma);
/// ```
#[non_exhaustive]
pub struct FormatInfo {
    /// Which format it is.
    pub format: Format,
    /// Its name in a sentence, such as `glTF`.
    pub name: &'static str,
    /// What the letters stand for.
    pub description: &'static str,
    /// Extensions in lower case, without the dot.
    pub extensions: &'static [&'static str],
    /// How well it is read, with the grades of the README: excellent, good, fair or no.
    pub reading: &'static str,
    /// How well it is written, with the same grades.
    pub writing: &'static str,
    /// Whether the first bytes of a file look like this format.
    pub(crate) sniff: fn(&[u8]) -> bool,
    /// Whether it can be read from [`Blocks`].
    #[doc(hidden)]
    pub reads_blocks: bool,
    /// The feature without which a build leaves the format out; `None` where every build has it.
    pub feature: Option<&'static str>,
    /// Whether this build reads it. Where it does not, importing a file gives an error that says what to do instead.
    pub reads: bool,
    /// Reads a whole file, or says why it cannot be read.
    pub(crate) read: fn(&Source<'_>, &ReadOptions) -> Result<Scene>,
    /// Makes the files of a scene; absent where the format is not written.
    pub(crate) write: Option<fn(&Scene, &WriteOptions) -> Result<Export>>,
    /// The options that change its files; none where it is not written.
    pub options: &'static [WriteOption],
    /// What becomes of each kind of data in its files; kinds that are not here are lost.
    pub(crate) carried: ledger::Carried,
    /// The kinds of data that stay where a file of the format gets another motion.
    pub(crate) passed_through: &'static [DataKind],
    /// Whether a file has one animation at most, and so only the first of a scene.
    pub has_one_clip: bool,
    /// Whether a file has the meshes of the file that the motion was read from, with skins and textures. Where `false`
    /// the meshes are those that show the skeleton, or none.
    pub has_file_meshes: bool,
    /// Whether a written file states which joint is which bone of a humanoid.
    pub states_bones: bool,
    /// Whether a written file says who wrote it and from which file: its [`Provenance`](gltf::report::Provenance).
    pub states_origin: bool,
    /// Whether a written file can have rotations in its rest pose. BVH has OFFSETs alone.
    #[doc(hidden)]
    pub has_rest_rotations: bool,
    /// Whether a file is written from rest transforms whose axes shear without losing that: where it has matrices, or
    /// positions alone, or a rest pose of its own.
    #[doc(hidden)]
    pub keeps_shear: bool,
    /// What its files hold.
    #[doc(hidden)]
    pub contents: Contents,
    /// Whether a file beside it can hold what the format cannot: [`Sidecar`].
    #[doc(hidden)]
    pub has_sidecar: bool,
    /// Whether the file of a character in it is passed through, with the motion added.
    #[doc(hidden)]
    pub keeps_characters: bool,
    /// Whether clips have names.
    #[doc(hidden)]
    pub names_clips: bool,
    /// Whether keys have any times, which its reader keeps. Others have a pose for each frame.
    #[doc(hidden)]
    pub has_key_times: bool,
    /// Whether all clips have one frame rate, which is whole where it is next to a whole one.
    #[doc(hidden)]
    pub has_one_rate: bool,
    /// The frames a second of all of its files, where the format says it.
    pub(crate) rate: Option<f64>,
    /// Whether its files are packed clips: only this program writes them, their joints have the axes of the source, and
    /// the bound on their error holds for positions.
    #[doc(hidden)]
    pub is_packed: bool,
    /// What a file of this program says of itself, where its bytes alone say it.
    pub(crate) provenance: fn(&[u8]) -> Option<gltf::report::Provenance>,
    /// What is wrong with a file that its reader takes all the same: an error, or a warning.
    #[doc(hidden)]
    pub inspect: fn(&[u8], &Scene) -> Result<Option<Diagnostic>>,
}

/// What the files of a format hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Contents {
    /// A skeleton, which may move.
    Motion,
    /// Points, which have no parents.
    Points,
    /// The motion of a skeleton that is in another file.
    Keys,
    /// Arrays of numbers, whose points may have no names.
    Arrays,
    /// A robot, which does not move.
    Robot,
}

impl fmt::Debug for FormatInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("FormatInfo").field(&self.format).finish()
    }
}

impl FormatInfo {
    /// What the rows of most formats have; each row says what is otherwise.
    #[doc(hidden)]
    pub const BASE: Self = Self {
        format: Format::Bvh,
        name: "",
        description: "",
        extensions: &[],
        reading: "no",
        writing: "no",
        sniff: |_| false,
        reads_blocks: false,
        feature: None,
        reads: true,
        read: left_out::read,
        write: None,
        options: &[],
        carried: &[
            (DataKind::Clips, Carriage::Kept),
            (DataKind::Frames, Carriage::Kept),
            (DataKind::FrameRates, Carriage::Kept),
            (DataKind::Durations, Carriage::Kept),
            (DataKind::Units, Carriage::Converted),
            (DataKind::MovingJoints, Carriage::Kept),
            (DataKind::PositionCurves, Carriage::Kept),
            (DataKind::RestScales, Carriage::Kept),
        ],
        passed_through: &[],
        has_one_clip: false,
        has_file_meshes: false,
        states_bones: false,
        states_origin: false,
        has_rest_rotations: true,
        keeps_shear: false,
        contents: Contents::Motion,
        has_sidecar: false,
        keeps_characters: false,
        names_clips: true,
        has_key_times: false,
        has_one_rate: false,
        rate: None,
        is_packed: false,
        provenance: |_| None,
        inspect: |_, _| Ok(None),
    };

    /// The extensions of all written formats, in a sentence.
    ///
    /// ```
    /// let known = mocap::FormatInfo::written_extensions();
    /// assert_eq!(known, ".bvh, .vrma, .glb, .gltf, .trc, .fbx, .usda, .usdz, .mclip or .vmd");
    /// ```
    pub fn written_extensions() -> String {
        let written = FormatInfo::ALL.iter().filter(|row| row.writes());
        let extensions = written.flat_map(|row| row.extensions.iter());
        words(extensions.map(|extension| format!(".{extension}")), "or")
    }

    /// Whether this build writes scenes in it.
    pub fn writes(&self) -> bool {
        self.write.is_some() && !self.is_left_out()
    }

    /// Whether this build lacks the feature of the format.
    fn is_left_out(&self) -> bool {
        self.feature.is_some() && !self.reads
    }

    /// What a file of this program says of itself, where its bytes alone say it.
    #[doc(hidden)]
    pub fn provenance(bytes: &[u8]) -> Option<gltf::report::Provenance> {
        FormatInfo::ALL.iter().find_map(|row| (row.provenance)(bytes))
    }

    /// Reads a whole file. What it states of its length is within the limits, whatever its reader allows.
    ///
    /// # Errors
    /// Those of the reader; [`Code::MissingFeature`] where this build leaves the format out.
    #[doc(hidden)]
    pub fn read(&self, source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
        match self.is_left_out() {
            true => Err(self.left_out("read")),
            false => {
                let scene = (self.read)(source, options)?;
                let bytes = source.blocks.map_or(source.bytes.len(), Blocks::size);
                FrameBudget::stated_by(&options.limits, bytes as u64).check(&scene)?;
                Ok(scene)
            }
        }
    }

    /// Makes the files of a scene; `None` where the format is not written.
    ///
    /// # Errors
    /// Those of the writer; [`Code::MissingFeature`] where this build leaves the format out.
    #[doc(hidden)]
    pub fn write(&self, scene: &Scene, options: &WriteOptions) -> Option<Result<Export>> {
        let write = self.write?;
        Some(match self.is_left_out() {
            true => Err(self.left_out("write")),
            false => FrameBudget::of_scene(&Limits::default())
                .check(scene)
                .and_then(|()| write(scene, options)),
        })
    }

    /// The mesh with which a motion is read, to be written in this format: its own if the format stores meshes, else
    /// one that shows the skeleton.
    #[doc(hidden)]
    pub fn mesh(&self, skeleton_only: bool) -> SkeletonMesh {
        match self.has_file_meshes {
            true if skeleton_only => SkeletonMesh::None,
            true => SkeletonMesh::Own,
            false => SkeletonMesh::Skinned,
        }
    }

    /// Whether numbers keep the unit and the axes of the scene, because a file of the format states neither. Other
    /// formats are in metres with +Y up, or state their unit and axes.
    pub fn keeps_units(&self) -> bool {
        self.takes(WriteOption::OutUnit)
    }
}

/// A large file that is read from its beginning to its end, so that a reader that needs most of it only once does not
/// hold it in memory.
#[doc(hidden)]
pub trait Blocks: Sync {
    /// Appends the next bytes of the file, and returns how many; 0 at the end.
    fn read(&self, block: &mut Vec<u8>) -> Result<usize, Failure>;

    /// All bytes of the file, read again: for a reader that has met something that it cannot read block by block.
    fn whole(&self) -> Result<&[u8], Failure>;

    /// How many bytes the file has.
    fn size(&self) -> usize;
}

/// The input of a reader: the bytes of a file, and access to other files for formats that use several.
///
/// A reader opens no file by itself. It uses these functions, so that the same code reads bytes from memory, and so
/// that every file is checked against [`Limits::max_bytes`].
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct Source<'a> {
    /// The whole file, or its beginning where there are `blocks`.
    pub bytes: &'a [u8],
    /// What follows `bytes`. Only formats that can use it get it.
    pub blocks: Option<&'a dyn Blocks>,
    /// The path of the file; [`Source::open`] and [`Source::list`] look in its folder.
    pub name: &'a Path,
    /// Is told of bytes that have been read, so that they are hashed while they are in the processor's caches.
    pub release: &'a (dyn Fn(Range<usize>) + Sync),
    /// Reads a file that this one refers to. Fails where the bytes come from memory, unless the caller has named that
    /// file, for example with `Importer::skeleton`.
    pub open: &'a dyn Fn(&Path) -> Result<Vec<u8>>,
    /// The files with this extension that may belong to this one, sorted: the one that the caller has named, or else
    /// all files in its folder.
    pub list: &'a dyn Fn(&str) -> Vec<PathBuf>,
}

impl<'a> Source<'a> {
    /// Bytes in memory, with no other file beside them.
    #[doc(hidden)]
    pub fn of_bytes(bytes: &'a [u8], name: &'a Path) -> Self {
        Self {
            bytes,
            blocks: None,
            name,
            release: &|_| {},
            open: &|_| Err(Diagnostic::new(Code::MissingFile, "the bytes come from memory").into()),
            list: &|_| Vec::new(),
        }
    }
}

impl FormatInfo {
    /// The formats, in the order in which detection by contents tries them.
    pub const ALL: &[FormatInfo] = &[
        bvh::FORMAT,
        // Before glTF, for it is glTF too.
        gltf::VRM_ANIMATION,
        gltf::FORMAT,
        asf_amc::FORMAT,
        c3d::FORMAT,
        trc::FORMAT,
        fbx::FORMAT,
        usd::FORMAT,
        mclip::FORMAT,
        mmd::VMD,
        mmd::PMX,
        bip::FORMAT,
        urdf::FORMAT,
        mjcf::FORMAT,
        array_files::NPZ,
        array_files::NPY,
        array_files::TORCH,
        array_files::PICKLE,
        array_files::PARQUET,
        array_files::CSV,
        array_files::MOT,
    ];
}

/// Options of a format's reader.
#[derive(Clone, Debug, Default, PartialEq)]
#[doc(hidden)]
pub struct ReadOptions {
    /// How the root's OFFSET and its position channels combine.
    pub root_offset: RootOffset,
    /// Frames per second, instead of the file's own: the motion keeps its frames.
    pub retime: Option<f64>,
    /// Frames per second at which curves are sampled, instead of the file's own.
    pub sampling_rate: Option<f64>,
    /// Read every row of the motion, also those beyond the declared count.
    pub all_rows: bool,
    /// Leave out the meshes of the file.
    pub without_meshes: bool,
    /// Read the meshes of a glTF file.
    pub gltf_meshes: bool,
    /// Read what only a comparison needs: the skeletons that this crate drew in USD, and both bind poses of an FBX
    /// file.
    pub for_comparison: bool,
    /// Read the morph targets of meshes.
    pub morph_targets: bool,
    /// Whether the file itself is not kept with the scene: [`Scene::original`].
    pub without_original: bool,
    /// Whether the rest pose of glTF with motion is that of its nodes, also where a skin has another bind pose.
    pub gltf_rest_of_nodes: bool,
    /// Which of the persons of a file is read. Default: the one in most frames.
    #[cfg(feature = "arrays")]
    pub person: Option<String>,
    /// The body on which arrays of rotations are put.
    #[cfg(feature = "arrays")]
    pub body: Option<Arc<Body>>,
    /// Keep the unit and the axes of a file that states them.
    pub file_units: bool,
    /// Upper bounds.
    pub limits: Limits,
    /// Threads that may read one file; `None` means the number of cores.
    pub threads: Option<NonZeroUsize>,
}

/// Options of all writers; each takes those that its row names.
#[derive(Clone, Debug, Default)]
#[doc(hidden)]
pub struct WriteOptions {
    /// The name of the file, without a folder. Its extension tells `.gltf` from `.glb`, and the files beside it are
    /// named after it.
    pub name: String,
    /// How far joints may be from their positions. Default: that of the format.
    pub error_bound: Option<ErrorBound>,
    /// The distance of a shell, in metres, instead of the bound's.
    pub shell_distance: Option<f64>,
    /// How glTF stores keys. Default: 16-bit integers within a bound, 32-bit floats without one.
    pub compression: Option<gltf::Compression>,
    /// Write constant tracks of glTF as channels too.
    pub keep_constant: bool,
    /// Where a `.gltf` has its buffer.
    pub buffer: gltf::BufferPlace,
    /// How BVH is written.
    pub bvh: bvh::BvhOptions,
    /// How FBX is written, but for its largest error.
    pub fbx: fbx::FbxOptions,
    /// Which joints are which bones. Default: they are found.
    pub humanoid: Option<Humanoid>,
    /// The motion with other frames, which shows the T-pose. Default: that of the scene does.
    pub whole: Option<Box<Scene>>,
}

impl WriteOptions {
    /// The bound with its shell; `None` where none was asked for.
    pub(crate) fn bound(&self) -> Option<ErrorBound> {
        Some(self.with_shell(self.error_bound.clone()?))
    }

    /// The bound, or the usual one where none was asked for.
    pub(crate) fn bound_or_usual(&self) -> ErrorBound {
        self.with_shell(self.error_bound.clone().unwrap_or_default())
    }

    fn with_shell(&self, bound: ErrorBound) -> ErrorBound {
        let shell_distance = self.shell_distance.unwrap_or(bound.shell_distance);
        bound.shell_distance(shell_distance)
    }

    /// Whether the name has this extension, in any case.
    pub(crate) fn has_extension(&self, extension: &str) -> bool {
        let found = Path::new(&self.name).extension();
        found.is_some_and(|found| found.eq_ignore_ascii_case(extension))
    }
}

/// What helps where a file states no valid frame rate.
pub(crate) const STATE_THE_RATE: &str = "state the frame rate yourself: {retime} 30";

impl ReadOptions {
    /// Frames per second: the caller's, or else the file's, if it is a possible rate.
    pub(crate) fn frame_rate_or(&self, stated: f64) -> Result<f64, Failure> {
        let rate = self.retime.unwrap_or(stated);
        limits::frame_rate(Code::FrameTime, rate).map_err(|diagnostic| Box::new(diagnostic.help(STATE_THE_RATE)))
    }

    /// Frames per second at which curves are sampled: the file's, where that is a possible rate.
    #[cfg(feature = "fbx")]
    pub(crate) fn sampling_rate_or(&self, stated: f64) -> Result<f64, Failure> {
        let own = || limits::frame_rate(Code::FrameTime, stated).ok();
        match self.sampling_rate.or_else(own) {
            Some(rate) => Ok(rate),
            None => self.frame_rate_or(stated),
        }
    }
}

/// The robot of a file; it has the warnings of its reader. `with_meshes` reads the surfaces of its meshes.
///
/// # Errors
/// Those of the reader; [`Code::MissingFeature`] where this build leaves the format out.
#[doc(hidden)]
#[cfg_attr(
    not(any(feature = "mjcf", feature = "urdf")),
    expect(unused_variables, reason = "no robot is read")
)]
pub fn read_robot(source: &Source<'_>, limits: &Limits, with_meshes: bool) -> Result<Robot> {
    match (mjcf::FORMAT.sniff)(source.bytes) {
        #[cfg(feature = "mjcf")]
        true => read_robot_by(mjcf::read_robot, source, limits, with_meshes),
        #[cfg(not(feature = "mjcf"))]
        true => Err(mjcf::FORMAT.left_out("read")),
        #[cfg(feature = "urdf")]
        false => read_robot_by(urdf::read_robot, source, limits, with_meshes),
        #[cfg(not(feature = "urdf"))]
        false => Err(urdf::FORMAT.left_out("read")),
    }
}

#[cfg(any(feature = "mjcf", feature = "urdf"))]
fn read_robot_by(
    read: impl FnOnce(&Source<'_>, &Limits, &mut warnings::Warnings) -> Result<Robot, Failure>,
    source: &Source<'_>,
    limits: &Limits,
    with_meshes: bool,
) -> Result<Robot> {
    let mut warnings = warnings::Warnings::default();
    let read = read(source, limits, &mut warnings);
    let (robot, warnings) = warnings.with(read)?;
    let mut robot = Robot { warnings, ..robot };
    if with_meshes {
        mesh_surface::add(&mut robot, source.open);
    }
    Ok(robot)
}
