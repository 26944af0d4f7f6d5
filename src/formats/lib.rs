//! The table of the file formats: one row, a [`FormatInfo`], for each format.
//!
//! A new format needs a folder with its row, an entry in [`FormatInfo::ALL`], a feature, and fixtures with their
//! origin. Every interface writes the formats whose row has `write`, and takes names, extensions and options from the
//! row.
//!
//! A build without the feature of a format keeps the format's row. So mocap recognises files of the format, and its
//! error names the missing feature. Such a build omits only the reader and the writer of the format.

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]
// With fewer formats, some shared code is unused.
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

/// The error of a reader's step. The error is boxed, so that a `Result` is small.
#[doc(hidden)]
pub type Failure = Box<Diagnostic>;

/// The description of a format: names, detection, reader, writer and options.
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
    /// The format.
    pub format: Format,
    /// The name in a sentence, such as `glTF`.
    pub name: &'static str,
    /// The meaning of the abbreviation.
    pub description: &'static str,
    /// Extensions in lower case, without the dot.
    pub extensions: &'static [&'static str],
    /// The quality of the reader, by the grades of `docs/formats.md`: excellent, good, fair or no.
    pub reading: &'static str,
    /// The quality of the writer, by the same grades.
    pub writing: &'static str,
    /// Whether the first bytes of a file look like this format.
    pub(crate) sniff: fn(&[u8]) -> bool,
    /// Whether the reader works with [`Blocks`].
    #[doc(hidden)]
    pub reads_blocks: bool,
    /// The feature without which a build omits the format; `None` if every build has it.
    pub feature: Option<&'static str>,
    /// Whether this build reads the format. If not, importing a file gives an error with a remedy.
    pub reads: bool,
    /// Reads a whole file, or returns the reason why it cannot be read.
    pub(crate) read: fn(&Source<'_>, &ReadOptions) -> Result<Scene>,
    /// Makes the files of a scene; absent if the format cannot be written.
    pub(crate) write: Option<fn(&Scene, &WriteOptions) -> Result<Export>>,
    /// The options that change files of this format; empty if the format cannot be written.
    pub options: &'static [WriteOption],
    /// The treatment of each kind of data in files of the format. Kinds that are not listed are lost.
    pub(crate) carried: ledger::Carried,
    /// The kinds of data that are kept if a file of the format gets another motion.
    pub(crate) passed_through: &'static [DataKind],
    /// Whether a file has at most one animation. The writer then writes the first animation of the scene.
    pub has_one_clip: bool,
    /// Whether a written file has the meshes of the motion's source file, with skins and textures. Files of other
    /// formats have no meshes, or only a mesh that shows the skeleton.
    pub has_file_meshes: bool,
    /// Whether a written file states the humanoid bone of each joint.
    pub states_bones: bool,
    /// Whether a written file states its writer and its source: its [`Provenance`](gltf::report::Provenance).
    pub states_origin: bool,
    /// Whether a written file can have rotations in its rest pose. BVH has only OFFSETs.
    #[doc(hidden)]
    pub has_rest_rotations: bool,
    /// Whether a file keeps shear in rest transforms, because it stores matrices, only positions, or a separate rest
    /// pose.
    #[doc(hidden)]
    pub keeps_shear: bool,
    /// The contents of a file.
    #[doc(hidden)]
    pub contents: Contents,
    /// Whether a sidecar file can hold data that the format cannot: [`Sidecar`].
    #[doc(hidden)]
    pub has_sidecar: bool,
    /// Whether a character file in this format is passed through, with the motion added.
    #[doc(hidden)]
    pub keeps_characters: bool,
    /// Whether clips have names.
    #[doc(hidden)]
    pub names_clips: bool,
    /// Whether keys may be at any time, and the reader keeps these times. Other formats have a pose for each frame.
    #[doc(hidden)]
    pub has_key_times: bool,
    /// Whether all clips have one frame rate. A rate near a whole number is written as that number.
    #[doc(hidden)]
    pub has_one_rate: bool,
    /// The frame rate of all files in frames per second; `None` if the format does not fix it.
    pub(crate) rate: Option<f64>,
    /// Whether files are packed clips. Only this program writes packed clips. Their joints have the axes of the source,
    /// and their error bound applies to positions.
    #[doc(hidden)]
    pub is_packed: bool,
    /// Reads the provenance of a file of this program, if its bytes alone state it.
    pub(crate) provenance: fn(&[u8]) -> Option<gltf::report::Provenance>,
    /// Checks a file for faults that its reader accepts. Returns an error or a warning.
    #[doc(hidden)]
    pub inspect: fn(&[u8], &Scene) -> Result<Option<Diagnostic>>,
}

/// The contents of a format's files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Contents {
    /// A skeleton, with or without motion.
    Motion,
    /// Points without parents.
    Points,
    /// The motion of a skeleton that is in another file.
    Keys,
    /// Arrays of numbers, whose points may have no names.
    Arrays,
    /// A robot without motion.
    Robot,
}

impl fmt::Debug for FormatInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("FormatInfo").field(&self.format).finish()
    }
}

impl FormatInfo {
    /// The defaults of a row. Each format overrides some of them.
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

    /// The extensions of all written formats, for a sentence.
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

    /// Whether this build writes scenes in this format.
    pub fn writes(&self) -> bool {
        self.write.is_some() && !self.is_left_out()
    }

    /// Whether this build lacks the feature of the format.
    fn is_left_out(&self) -> bool {
        self.feature.is_some() && !self.reads
    }

    /// Reads the provenance of a file of this program, if its bytes alone state it.
    #[doc(hidden)]
    pub fn provenance(bytes: &[u8]) -> Option<gltf::report::Provenance> {
        FormatInfo::ALL.iter().find_map(|row| (row.provenance)(bytes))
    }

    /// Reads a whole file. Also checks the length of the scene against the limits, whatever the reader checks.
    ///
    /// # Errors
    /// The errors of the reader, and [`Code::MissingFeature`] if this build omits the format.
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

    /// Makes the files of a scene; `None` if the format cannot be written.
    ///
    /// # Errors
    /// The errors of the writer, and [`Code::MissingFeature`] if this build omits the format.
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

    /// The meshes to read with a motion that is then written in this format. A format with meshes gets the meshes of
    /// the motion's file. Other formats get a mesh that shows the skeleton.
    #[doc(hidden)]
    pub fn mesh(&self, skeleton_only: bool) -> SkeletonMesh {
        match self.has_file_meshes {
            true if skeleton_only => SkeletonMesh::None,
            true => SkeletonMesh::Own,
            false => SkeletonMesh::Skinned,
        }
    }

    /// Whether numbers keep the unit and the axes of the scene, because the format states neither. Other formats are in
    /// metres with +Y up, or state their unit and axes.
    pub fn keeps_units(&self) -> bool {
        self.takes(WriteOption::OutUnit)
    }
}

/// A large file that a reader reads block by block from start to end. So the reader need not hold the whole file in
/// memory.
#[doc(hidden)]
pub trait Blocks: Sync {
    /// Appends the next bytes of the file, and returns their number; 0 at the end.
    fn read(&self, block: &mut Vec<u8>) -> Result<usize, Failure>;

    /// Reads the file again and returns all its bytes. A reader calls this function if it cannot read a part block by
    /// block.
    fn whole(&self) -> Result<&[u8], Failure>;

    /// The number of bytes in the file.
    fn size(&self) -> usize;
}

/// The input of a reader: the bytes of a file, and access to its companion files.
///
/// A reader opens no file itself. It uses the functions below. So the same code reads bytes from memory, and every file
/// is checked against [`Limits::max_bytes`].
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct Source<'a> {
    /// The whole file. If there are `blocks`, only the beginning of the file.
    pub bytes: &'a [u8],
    /// The rest of the file, after `bytes`; `None` if the reader of the format does not use blocks.
    pub blocks: Option<&'a dyn Blocks>,
    /// The path of the file. [`Source::open`] and [`Source::list`] search its folder.
    pub name: &'a Path,
    /// The reader calls this function with the range of bytes that it has read. The bytes are then hashed while they
    /// are in the processor's caches.
    pub release: &'a (dyn Fn(Range<usize>) + Sync),
    /// Reads a file to which this file refers. Fails if the bytes come from memory, unless the caller has named the
    /// file, for example with `Importer::skeleton`.
    pub open: &'a dyn Fn(&Path) -> Result<Vec<u8>>,
    /// The files with this extension that may belong to this file, sorted: the file that the caller named, or else all
    /// files in its folder.
    pub list: &'a dyn Fn(&str) -> Vec<PathBuf>,
}

impl<'a> Source<'a> {
    /// Bytes in memory, without companion files.
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
    /// The formats, in the order of detection by contents.
    pub const ALL: &[FormatInfo] = &[
        bvh::FORMAT,
        // Before glTF, because a VRM animation is also glTF.
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
    /// The playback rate in frames per second, instead of the rate of the file. The motion keeps its frames.
    pub retime: Option<f64>,
    /// The rate at which curves are sampled in frames per second, instead of the rate of the file.
    pub sampling_rate: Option<f64>,
    /// Whether to read every row of the motion, including rows beyond the declared count.
    pub all_rows: bool,
    /// Whether to skip the meshes of the file.
    pub without_meshes: bool,
    /// Whether to read the meshes of a glTF file.
    pub gltf_meshes: bool,
    /// Whether to read data that only a comparison needs: the skeletons that this crate drew in USD, and both bind
    /// poses of an FBX file.
    pub for_comparison: bool,
    /// Whether to read the morph targets of meshes.
    pub morph_targets: bool,
    /// Whether the scene omits [`Scene::original`], the file from which it was read.
    pub without_original: bool,
    /// Whether the rest pose of an animated glTF is the pose of its nodes, even if a skin has another bind pose.
    pub gltf_rest_of_nodes: bool,
    /// The person to read. Default: the person with the most frames.
    #[cfg(feature = "arrays")]
    pub person: Option<String>,
    /// The body for arrays of rotations.
    #[cfg(feature = "arrays")]
    pub body: Option<Arc<Body>>,
    /// Whether to keep the unit and the axes that a file states.
    pub file_units: bool,
    /// Upper bounds for the counts and sizes in a file.
    pub limits: Limits,
    /// The largest number of threads that read one file; `None` means the number of cores.
    pub threads: Option<NonZeroUsize>,
}

/// Options of all writers. Each writer uses the options that its row lists.
#[derive(Clone, Debug, Default)]
#[doc(hidden)]
pub struct WriteOptions {
    /// The name of the file, without a folder. The extension distinguishes `.gltf` from `.glb`. Companion files are
    /// named after the file.
    pub name: String,
    /// The error bound. Default: the default of the format.
    pub error_bound: Option<ErrorBound>,
    /// The shell distance in metres, instead of the shell distance of the bound.
    pub shell_distance: Option<f64>,
    /// The storage of glTF keys. Default: 16-bit integers with a bound, 32-bit floats without one.
    pub compression: Option<gltf::Compression>,
    /// Whether glTF has channels for constant tracks too.
    pub keep_constant: bool,
    /// The place of a `.gltf`'s buffer.
    pub buffer: gltf::BufferPlace,
    /// The BVH options.
    pub bvh: bvh::BvhOptions,
    /// The FBX options, except the largest error.
    pub fbx: fbx::FbxOptions,
    /// The joint of each bone. Default: mocap finds the joints.
    pub humanoid: Option<Humanoid>,
    /// The complete motion, from which the writer determines the T-pose. Default: the motion of the scene.
    pub whole: Option<Box<Scene>>,
}

impl WriteOptions {
    /// The error bound with its shell distance; `None` if the caller requested no bound.
    pub(crate) fn bound(&self) -> Option<ErrorBound> {
        Some(self.with_shell(self.error_bound.clone()?))
    }

    /// The error bound, or the default bound of 1 mm if the caller requested no bound.
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

/// The help text for a file that states no valid frame rate.
pub(crate) const STATE_THE_RATE: &str = "state the frame rate yourself: {retime} 30";

impl ReadOptions {
    /// The frame rate in frames per second. The caller's rate has priority over `stated`, the rate of the file. NaN
    /// means that the file states no rate.
    ///
    /// # Errors
    /// [`Code::FrameTime`] if no rate is stated, or if the rate is impossible.
    pub(crate) fn frame_rate_or(&self, stated: f64) -> Result<f64, Failure> {
        let rate = self.retime.unwrap_or(stated);
        if rate.is_nan() {
            let error = Diagnostic::new(Code::FrameTime, "the file states no frame rate");
            return Err(Box::new(
                error.help("state the rate: {fps} 30, or {retime} 30 in a command without {fps}"),
            ));
        }
        limits::frame_rate(Code::FrameTime, rate).map_err(|diagnostic| Box::new(diagnostic.help(STATE_THE_RATE)))
    }

    /// The sampling rate of curves in frames per second: the rate that the caller states, or else the rate of the file
    /// if it is possible.
    #[cfg(feature = "fbx")]
    pub(crate) fn sampling_rate_or(&self, stated: f64) -> Result<f64, Failure> {
        let own = || limits::frame_rate(Code::FrameTime, stated).ok();
        match self.sampling_rate.or_else(own) {
            Some(rate) => Ok(rate),
            None => self.frame_rate_or(stated),
        }
    }
}

/// The robot in a file, with the warnings of its reader. `with_meshes` also reads the surfaces of its meshes.
///
/// # Errors
/// The errors of the reader, and [`Code::MissingFeature`] if this build omits the format.
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
