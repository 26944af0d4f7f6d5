//! The table of formats that can be read.
//!
//! To add a format: a folder in `format/`, a row in [`FORMATS`], fixtures with their origin, a row in the README.

mod asf_amc;
mod bip;
pub mod bvh;
mod c3d;
pub mod fbx;
pub mod gltf;
mod mclip;
mod mesh_bounds;
mod mimic;
mod mjcf;
mod provenance;
pub(crate) mod text;
mod texture;
mod urdf;
pub(crate) mod warnings;
mod xml;

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::error::{Code, Diagnostic, Result};
use crate::limits::{self, Limits};
use crate::scene::robot::Robot;
use crate::scene::{Format, RootOffset, Scene};

/// The error of a step of a reader. Boxed, so that the results of all steps are small.
pub(crate) type Failure = Box<Diagnostic>;

/// The name of a format, how it is recognised, and how it is read.
pub struct FormatInfo {
    /// Which format it is.
    pub format: Format,
    /// What the letters stand for.
    pub description: &'static str,
    /// Extensions in lower case, without the dot.
    pub extensions: &'static [&'static str],
    /// Whether the first bytes of a file look like this format.
    pub(crate) sniff: fn(&[u8]) -> bool,
    /// Whether it can be read from [`Blocks`].
    pub(crate) reads_blocks: bool,
    /// Reads a whole file.
    pub(crate) read: fn(&Source<'_>, &ReadOptions) -> Result<Scene>,
}

/// A large file that is read from its beginning to its end, so that a reader that needs most of it only once does not
/// hold it in memory.
pub(crate) trait Blocks: Sync {
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
pub(crate) struct Source<'a> {
    /// The whole file, or its beginning where there are `blocks`.
    pub bytes: &'a [u8],
    /// What follows `bytes`. Only formats that can use it get it.
    pub blocks: Option<&'a dyn Blocks>,
    /// The path of the file; [`Source::open`] and [`Source::list`] look in its folder.
    pub name: &'a Path,
    /// Is told of bytes that have been read, so that they are hashed while they are in the processor's caches.
    pub release: &'a (dyn Fn(Range<usize>) + Sync),
    /// Reads a file that this one refers to. Fails where the bytes come from memory, unless the caller has named that
    /// file, for example with [`Importer::skeleton`](crate::Importer::skeleton).
    pub open: &'a dyn Fn(&Path) -> Result<Vec<u8>>,
    /// The files with this extension that may belong to this one, sorted: the one that the caller has named, or else
    /// all files in its folder.
    pub list: &'a dyn Fn(&str) -> Vec<PathBuf>,
}

/// The formats, in the order in which detection by contents tries them.
pub const FORMATS: &[FormatInfo] = &[
    bvh::FORMAT,
    // Before glTF, for it is glTF too.
    gltf::VRM_ANIMATION,
    gltf::FORMAT,
    asf_amc::FORMAT,
    c3d::FORMAT,
    fbx::FORMAT,
    mclip::FORMAT,
    bip::FORMAT,
    urdf::FORMAT,
    mjcf::FORMAT,
];

/// Options of a format's reader.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ReadOptions {
    /// How the root's OFFSET and its position channels combine.
    pub root_offset: RootOffset,
    /// Frames per second, in place of the file's own.
    pub frame_rate: Option<f64>,
    /// Read every row of the motion, also those beyond the declared count.
    pub all_rows: bool,
    /// Leave out the meshes of the file.
    pub without_meshes: bool,
    /// Read the meshes of a glTF file.
    pub gltf_meshes: bool,
    /// Keep the unit and the axes of a file that states them.
    pub file_units: bool,
    /// Upper bounds.
    pub limits: Limits,
    /// Threads that may read one file; `None` means the number of cores.
    pub threads: Option<NonZeroUsize>,
}

impl ReadOptions {
    /// Frames per second: the caller's, or else the file's, if it is a possible rate.
    pub(crate) fn frame_rate_or(&self, stated: f64) -> Result<f64, Failure> {
        let rate = self.frame_rate.unwrap_or(stated);
        limits::frame_rate(Code::FrameTime, rate).map_err(|diagnostic| {
            Box::new(diagnostic.help("state the frame rate yourself: --fps 30, or Importer::frame_rate"))
        })
    }
}

/// Reads a robot as a scene, with the warning that it has no motion.
fn read_robot_scene(
    source: &Source<'_>,
    options: &ReadOptions,
    read: impl FnOnce(&Source<'_>, &Limits, &mut warnings::Warnings) -> Result<Robot, Failure>,
) -> Result<Scene> {
    let mut warnings = warnings::Warnings::default();
    let scene = read(source, &options.limits, &mut warnings).map(|robot| robot.scene());
    warnings.push(Code::NoMotion, || {
        let message = "a robot has no motion: the scene has a skeleton and no animation";
        Diagnostic::new(Code::NoMotion, message).help("mocap robot MOTION --robot FILE -o OUT puts a motion on it")
    });
    warnings.attach_to(scene)
}

/// The robot of a file; it has the warnings of its reader.
pub(crate) fn read_robot(source: &Source<'_>, limits: &Limits) -> Result<Robot> {
    let mut warnings = warnings::Warnings::default();
    let read = if (mjcf::FORMAT.sniff)(source.bytes) {
        mjcf::read_robot(source, limits, &mut warnings)
    } else {
        urdf::read_robot(source, limits, &mut warnings)
    };
    let (robot, warnings) = warnings.with(read)?;
    Ok(Robot { warnings, ..robot })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A build without a feature has a row with the error that names the feature.
    #[test]
    fn every_format_has_a_row() {
        for format in Format::ALL {
            let rows = FORMATS.iter().filter(|row| row.format == format).count();
            assert_eq!(rows, 1, "{format}");
        }
    }
}
