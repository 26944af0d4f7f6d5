//! A BVH file as a scene, in three steps: `hierarchy` reads the joints, `motion` and `rows` the numbers, and `scene`
//! makes nodes and channels of the two; `positions` decides what position channels mean.

mod channel;
mod decimals;
mod hierarchy;
mod motion;
mod positions;
mod rows;
mod scene;

use std::borrow::Cow;
use std::ops::Range;

use crate::error::{Code, Diagnostic, Result};
use crate::format::text::{Cursor, Word, decode};
use crate::format::warnings::Warnings;
use crate::format::{Failure, ReadOptions, Source};
use crate::scene::Scene;

/// A BVH file begins with `HIERARCHY`; only comment lines may precede it.
pub(super) fn sniff(bytes: &[u8]) -> bool {
    const ENOUGH: usize = 64 << 10;
    decode(&bytes[..bytes.len().min(ENOUGH)]).is_ok_and(|text| hierarchy::read_header(&mut Cursor::new(&text)).is_ok())
}

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let text = decode(source.bytes)?;
    // The length of a byte order mark. Decoded text is a copy, so none of it is released.
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

/// Refuses a NUL byte, which would go unnoticed in a name.
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
