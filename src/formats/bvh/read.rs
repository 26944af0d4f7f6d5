//! Reads a BVH file into a scene, in three steps. `hierarchy` reads the joints, `motion` and `rows` read the numbers,
//! and `scene` makes nodes and channels from both. `positions` determines the meaning of position channels.

#[doc(hidden)]
pub(crate) mod channel;
mod decimals;
mod hierarchy;
mod motion;
mod positions;
pub(crate) mod rows;
mod scene;

use std::borrow::Cow;
use std::ops::Range;

use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Scene;

use self::hierarchy::Hierarchy;
use self::motion::Header;
use crate::text::{Cursor, Word, decode};
use crate::warnings::Warnings;
use crate::{Blocks, Failure, ReadOptions, Source};

pub(super) fn read(source: &Source<'_>, options: &ReadOptions) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let read = match source.blocks {
        Some(blocks) => read_blocks(source.bytes, blocks, options, &mut warnings),
        None => read_memory(source.bytes, options, &mut warnings, source.release),
    };
    warnings.attach_to(read)
}

fn read_memory(
    bytes: &[u8],
    options: &ReadOptions,
    warnings: &mut Warnings,
    release: &rows::Release<'_>,
) -> Result<Scene, Failure> {
    let text = decode(bytes)?;
    // The length of the byte order mark, by which the ranges to release are shifted. If the text is a decoded copy, the
    // reader releases no memory of the file.
    let before = match text {
        Cow::Borrowed(text) => Some(bytes.len() - text.len()),
        Cow::Owned(_) => None,
    };
    let release = |range: Range<usize>| {
        if let Some(before) = before {
            release(range.start + before..range.end + before);
        }
    };
    let mut cursor = Cursor::new(&text);
    let (hierarchy, header) = read_head(&mut cursor, options, warnings)?;
    read_rows(cursor, None, &hierarchy, header.as_ref(), options, warnings, &release)
}

/// Reads a plain file without holding its rows in memory. `beginning` has the text before the rows, without commas. A
/// comma would be a decimal separator only if the whole text had no point.
fn read_blocks(
    beginning: &[u8],
    blocks: &dyn Blocks,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<Scene, Failure> {
    /// More bytes than a diagnostic shows after its location.
    const AHEAD: usize = 4096;
    if let Ok(Cow::Borrowed(text)) = decode(beginning) {
        let mut cursor = Cursor::new(text);
        if let Ok((hierarchy, Some(header))) = read_head(&mut cursor, options, warnings)
            && hierarchy.channel_count > 0
            && !warnings.has(Code::DecimalComma)
            && text.len() - cursor.offset() >= AHEAD
        {
            let before = beginning.len() - text.len();
            let rest = Some(rows::Rest { blocks, before });
            return read_rows(cursor, rest, &hierarchy, Some(&header), options, warnings, &|_| {});
        }
    }
    *warnings = Warnings::default();
    read_memory(blocks.whole()?, options, warnings, &|_| {})
}

/// Reads the part before the rows. A file that ends with its hierarchy has no header of the rows.
fn read_head(
    cursor: &mut Cursor<'_>,
    options: &ReadOptions,
    warnings: &mut Warnings,
) -> Result<(Hierarchy, Option<Header>), Failure> {
    hierarchy::read_header(cursor)?;
    let hierarchy = hierarchy::read(cursor, &options.limits, warnings)?;
    refuse_nul(cursor)?;
    let joint_name = |joint: usize| &*hierarchy.joints[joint].name;
    decimals::accept_commas_of_hierarchy(cursor, &hierarchy.decimals, joint_name, warnings)?;
    let header = motion::read_header(cursor, &hierarchy, options, warnings)?;
    Ok((hierarchy, header))
}

fn read_rows<'a>(
    mut cursor: Cursor<'a>,
    rest: Option<rows::Rest<'a>>,
    hierarchy: &Hierarchy,
    header: Option<&Header>,
    options: &ReadOptions,
    warnings: &mut Warnings,
    release: &rows::Release<'_>,
) -> Result<Scene, Failure> {
    let mut tracks = scene::Tracks::new(hierarchy, options);
    if let Some(header) = header {
        rows::read(
            &mut cursor,
            rest,
            hierarchy,
            header,
            options,
            warnings,
            release,
            &mut tracks,
        )?;
    }
    Ok(scene::build(hierarchy, header, tracks, warnings))
}

/// Refuses a NUL byte, which could hide in a name.
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
