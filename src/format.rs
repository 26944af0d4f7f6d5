//! The formats that are read here, as rows of one table.
//!
//! To add a format: a file in `format/`, a row in [`FORMATS`], fixtures with their origin, a row in the README.

mod asf_amc;
mod bip;
pub mod bvh;
mod c3d;
#[cfg(feature = "fbx")]
mod fbx;
pub mod gltf;
pub(crate) mod text;
pub(crate) mod warnings;

use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::error::{Code, Diagnostic, Result};
use crate::limits::Limits;
use crate::scene::{Format, RootOffset, Scene};

/// An error in the making. Boxed, because every step of a reader may return one and almost none does.
pub(crate) type Failure = Box<Diagnostic>;

/// What one format is called, how it is recognised, and how it is read.
pub struct FormatInfo {
    /// Which format it is.
    pub format: Format,
    /// What the letters stand for.
    pub description: &'static str,
    /// Extensions in lower case, without the dot.
    pub extensions: &'static [&'static str],
    /// Whether the first bytes of a file look like this format.
    pub(crate) sniff: fn(&[u8]) -> bool,
    /// Reads a whole file.
    pub(crate) read: fn(&Source<'_>, &ReadOptions) -> Result<Scene>,
}

/// A file as its reader sees it: the bytes, and a way to other files, for formats that spread over several.
///
/// A reader opens nothing by itself. It asks here, so that bytes from memory are read by the same code as files, and
/// so that every file is held against [`Limits::max_bytes`].
#[derive(Clone, Copy)]
pub(crate) struct Source<'a> {
    /// The whole file.
    pub bytes: &'a [u8],
    /// What the file is called; its folder is where [`Source::open`] and [`Source::list`] look.
    pub name: &'a Path,
    /// Told of bytes that have been read and are not likely to be looked at again, so that those of a large file need
    /// not stay in memory. Looking again is slow and no more.
    pub release: &'a (dyn Fn(Range<usize>) + Sync),
    /// Reads a file that this one refers to. Fails where the bytes come from memory, unless the caller has named that
    /// very file, with [`Importer::skeleton`](crate::Importer::skeleton) for example.
    pub open: &'a dyn Fn(&Path) -> Result<Vec<u8>>,
    /// The files with this extension that may belong to this one, sorted: the one that the caller has named, else all
    /// those in its folder.
    pub list: &'a dyn Fn(&str) -> Vec<PathBuf>,
}

/// The formats, in the order in which contents are tried.
pub const FORMATS: &[FormatInfo] = &[
    bvh::FORMAT,
    gltf::FORMAT,
    asf_amc::FORMAT,
    c3d::FORMAT,
    #[cfg(feature = "fbx")]
    fbx::FORMAT,
    bip::FORMAT,
];

/// What a caller can ask of a format's reader.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ReadOptions {
    /// What to do with the root's OFFSET when the root has position channels too.
    pub root_offset: RootOffset,
    /// Frames per second to take in place of the file's own.
    pub frame_rate: Option<f64>,
    /// Read every row of the motion, also those beyond the declared count.
    pub all_rows: bool,
    /// Leave out the meshes of the file.
    pub without_meshes: bool,
    /// Upper bounds.
    pub limits: Limits,
    /// Threads that may read one file; none stands for one a core.
    pub threads: Option<NonZeroUsize>,
}

impl ReadOptions {
    /// Frames per second: those asked for, else those that the file states, if motion can have so many.
    pub(crate) fn frame_rate_or(&self, stated: f64) -> Result<f64, Failure> {
        let rate = self.frame_rate.unwrap_or(stated);
        if rate.is_finite() && rate > 0.0 {
            return Ok(rate);
        }
        Err(Box::new(
            Diagnostic::new(Code::FrameTime, format!("{rate} is no frame rate"))
                .expected_found("frames per second, above 0", format!("{rate}"))
                .help("state the frame rate yourself: --fps 30, or Importer::frame_rate"),
        ))
    }
}
