//! A BVH file as a scene, in three steps: `hierarchy` gives joints as the file has them, `motion` the blocks of numbers,
//! and `scene` turns the two into a node graph and channels.

mod channel;
mod decimals;
mod hierarchy;
mod motion;
mod rows;
mod scene;

use std::borrow::Cow;
use std::num::NonZeroUsize;
use std::ops::Range;

use glam::Quat;

use crate::error::{Code, Diagnostic, Result};
use crate::format::text::{Cursor, Word, decode};
use crate::format::warnings::Warnings;
use crate::format::{Failure, ReadOptions, Source};
use crate::math::rotation::{Axis, lanes};
use crate::scene::Scene;

/// A BVH begins with `HIERARCHY`, after comment lines at most.
pub(super) fn sniff(bytes: &[u8]) -> bool {
    const ENOUGH: usize = 64 << 10;
    decode(&bytes[..bytes.len().min(ENOUGH)]).is_ok_and(|text| hierarchy::read_header(&mut Cursor::new(&text)).is_ok())
}

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let text = decode(source.bytes)?;
    // Bytes in front of the text, such as a byte order mark; text that was decoded is nobody's to release.
    let before = match text {
        Cow::Borrowed(text) => Some(source.bytes.len() - text.len()),
        Cow::Owned(_) => None,
    };
    let release = |range: Range<usize>| {
        if let Some(before) = before {
            (source.release)(range.start + before..range.end + before);
        }
    };
    let mut warnings = Warnings::default();
    let read = read_text(&text, options, &mut warnings, &release);
    warnings.attach_to(read)
}

/// Reads every number of a file's motion and keeps none; gives the number of frames. What `tools/bench` calls a scan.
///
/// # Errors
/// As [`Importer::read`](crate::Importer::read).
#[doc(hidden)]
pub fn scan(text: &[u8]) -> Result<usize> {
    let options = ReadOptions {
        threads: NonZeroUsize::new(1),
        ..ReadOptions::default()
    };
    let mut warnings = Warnings::default();
    let mut frames = Count(0);
    let mut cursor = Cursor::new(text);
    hierarchy::read_header(&mut cursor)?;
    let hierarchy = hierarchy::read(&mut cursor, &options.limits, &mut warnings)?;
    if let Some(header) = motion::read_header(&mut cursor, &hierarchy, &options, &mut warnings)? {
        rows::read(
            &mut cursor,
            &hierarchy,
            &header,
            &options,
            &mut warnings,
            &|_| {},
            &mut frames,
        )?;
    }
    Ok(frames.0)
}

/// Fills `keys` with the rotations that columns of degrees about z, x and y stand for. For `tools/bench` too.
#[doc(hidden)]
pub fn turn([z, x, y]: [&[f64]; 3], keys: &mut [Quat]) {
    lanes::fill(&[(Axis::Z, z), (Axis::X, x), (Axis::Y, y)], keys);
}

/// Frames, and nothing of what is in them.
struct Count(usize);

impl rows::Sink for Count {
    fn append(&mut self, block: &rows::Block) {
        self.0 += block.frames();
    }

    type Frames<'a> = Uncounted;

    fn extend(&mut self, frames: usize, _: usize) -> Uncounted {
        self.0 += frames;
        Uncounted
    }

    fn truncate(&mut self, frames: usize) {
        self.0 = frames;
    }

    fn frames(&self) -> usize {
        self.0
    }
}

/// Room that takes no memory.
struct Uncounted;

impl rows::Frames for Uncounted {
    fn split_off(&mut self, _: usize) -> Self {
        Self
    }

    fn fill(&mut self, _: &rows::Block) {}
}

fn read_text(
    text: &[u8],
    options: &ReadOptions,
    warnings: &mut Warnings,
    release: &rows::Release<'_>,
) -> Result<Scene, Failure> {
    let mut cursor = Cursor::new(text);
    hierarchy::read_header(&mut cursor)?;
    let hierarchy = hierarchy::read(&mut cursor, &options.limits, warnings)?;
    refuse_nul(&cursor)?;
    let joint_name = |joint: usize| &*hierarchy.joints[joint].name;
    decimals::accept_commas_of_hierarchy(&cursor, &hierarchy.decimals, joint_name, warnings)?;
    let header = motion::read_header(&mut cursor, &hierarchy, options, warnings)?;
    let mut tracks = scene::Tracks::new(&hierarchy, options);
    if let Some(header) = &header {
        rows::read(&mut cursor, &hierarchy, header, options, warnings, release, &mut tracks)?;
    }
    Ok(scene::build(&hierarchy, header.as_ref(), tracks, warnings))
}

/// No text has a NUL; in a name it would go unnoticed.
fn refuse_nul(cursor: &Cursor<'_>) -> Result<(), Failure> {
    let Some(offset) = memchr::memchr(0, &cursor.text()[..cursor.offset()]) else {
        return Ok(());
    };
    let bytes = &cursor.text()[offset..=offset];
    Err(Box::new(
        Diagnostic::new(Code::BinaryFile, "there is a NUL byte in the hierarchy")
            .at(cursor.locate(Word { bytes, offset }))
            .expected_found("text", "a NUL byte"),
    ))
}
