//! `.usdz`: a ZIP archive of stored files. Each file begins at a multiple of 64 bytes, so that it can be mapped into
//! memory. The first file is the stage. The source is Pixar's Usdz File Format Specification.

use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::files::ZIP_HEAD;

use crate::Failure;

/// The alignment of a file's bytes.
pub const ALIGNMENT: usize = 64;

const CENTRAL: &[u8] = b"PK\x01\x02";
const END: &[u8] = b"PK\x05\x06";

/// Bytes of a file's header before its name (ZIP specification, 4.3.7).
const LOCAL_LENGTH: usize = 30;

/// Bytes of a file's directory entry before its name (4.3.12).
const CENTRAL_LENGTH: usize = 46;

/// Bytes of the end of the directory without its comment (4.3.16).
const END_LENGTH: usize = 22;

/// Bytes of the longest comment at the end of an archive.
const LONGEST_COMMENT: usize = 65_535;

/// The id of the padding extra field, as in Pixar's writer.
const PADDING: u16 = 0x1986;

/// The date of every file: 1 January 1980, so that equal files give equal bytes.
const DATE: u16 = 0x0021;

/// The archive of these files; `None` if it would exceed 4 GiB, the largest size that the format can state.
pub fn write(files: &[(String, &[u8])]) -> Option<Vec<u8>> {
    let (mut out, mut central) = (Vec::new(), Vec::new());
    for (name, bytes) in files {
        let offset = u32::try_from(out.len()).ok()?;
        let size = u32::try_from(bytes.len()).ok()?;
        // The fields that both headers share: version 1.0, no flags, stored, the date, the check sum, the sizes.
        let mut shared = Vec::new();
        for number in [10, 0, 0, 0, DATE] {
            shared.extend(number.to_le_bytes());
        }
        for number in [zlib_rs::crc32::crc32(0, bytes), size, size] {
            shared.extend(number.to_le_bytes());
        }
        shared.extend(u16::try_from(name.len()).ok()?.to_le_bytes());
        let begin = out.len() + LOCAL_LENGTH + name.len() + 4;
        let padding = begin.next_multiple_of(ALIGNMENT) - begin;
        out.extend(ZIP_HEAD);
        out.extend(&shared);
        out.extend((padding as u16 + 4).to_le_bytes());
        out.extend(name.as_bytes());
        out.extend(PADDING.to_le_bytes());
        out.extend((padding as u16).to_le_bytes());
        out.resize(out.len() + padding, 0);
        out.extend(*bytes);
        central.extend(CENTRAL);
        central.extend(10_u16.to_le_bytes());
        central.extend(shared);
        // The entry has no extra field, no comment, the first disk, no attributes.
        central.extend([0; 12]);
        central.extend(offset.to_le_bytes());
        central.extend(name.as_bytes());
    }
    let begin = u32::try_from(out.len()).ok()?;
    let count = u16::try_from(files.len()).ok()?;
    let size = u32::try_from(central.len()).ok()?;
    out.extend(central);
    out.extend(END);
    out.extend([0; 4]);
    out.extend(count.to_le_bytes());
    out.extend(count.to_le_bytes());
    out.extend(size.to_le_bytes());
    out.extend(begin.to_le_bytes());
    out.extend([0; 2]);
    Some(out)
}

/// The stage of an archive: the bytes of its first file.
pub fn stage(archive: &[u8]) -> Result<&[u8], Failure> {
    entries(archive)?
        .next()
        .ok_or_else(|| broken("the list of its files is missing"))??
        .bytes()
}

/// The files of an archive by name.
pub(super) fn files(archive: &[u8]) -> Result<HashMap<&[u8], Entry<'_>>, Failure> {
    entries(archive)?
        .map(|entry| entry.map(|entry| (entry.name, entry)))
        .collect()
}

fn broken(what: &str) -> Failure {
    let message = format!("the archive is broken: {what}");
    Box::new(Diagnostic::new(Code::InvalidUsd, message).help("export or download it again"))
}

/// A file of an archive.
pub(super) struct Entry<'a> {
    name: &'a [u8],
    /// The stored bytes, and the check sum in the directory.
    stored: Option<&'a [u8]>,
    sum: u32,
    is_stored: bool,
}

impl<'a> Entry<'a> {
    pub(super) fn bytes(&self) -> Result<&'a [u8], Failure> {
        if !self.is_stored {
            return Err(broken("a file is compressed, but files in a .usdz must be stored"));
        }
        let bytes = self.stored.ok_or_else(|| broken("a file is cut off"))?;
        match zlib_rs::crc32::crc32(0, bytes) == self.sum {
            true => Ok(bytes),
            false => Err(broken("the check sum of a file is wrong")),
        }
    }
}

/// The directory at the end of an archive.
fn entries(archive: &[u8]) -> Result<impl Iterator<Item = Result<Entry<'_>, Failure>>, Failure> {
    let last = archive.len().checked_sub(END_LENGTH);
    let last = last.ok_or_else(|| broken("the end of the archive is missing"))?;
    let first = last.saturating_sub(LONGEST_COMMENT);
    let end = (first..=last).rev().find(|at| archive[*at..].starts_with(END));
    let end = end.ok_or_else(|| broken("the end of the archive is missing"))?;
    let begin = u32_at(archive, end + 16).map(|at| at as usize);
    let mut at = begin.ok_or_else(|| broken("the list of its files is missing"))?;
    let mut left = u16_at(archive, end + 10).unwrap_or_default();
    Ok(std::iter::from_fn(move || {
        left = left.checked_sub(1)?;
        let entry = entry(archive, at);
        match entry {
            Some((_, next)) => at = next,
            None => left = 0,
        }
        Some(
            entry
                .map(|(entry, _)| entry)
                .ok_or_else(|| broken("the list of its files is missing")),
        )
    }))
}

/// An entry of the directory, and the position of the next one.
fn entry(archive: &[u8], at: usize) -> Option<(Entry<'_>, usize)> {
    let rest = archive.get(at..).filter(|rest| rest.starts_with(CENTRAL))?;
    let number = |place: usize| u32_at(rest, place).map(|number| number as usize);
    let length = |place: usize| u16_at(rest, place).map(usize::from);
    let name = rest.get(CENTRAL_LENGTH..)?.get(..length(28)?)?;
    let (size, local) = (number(24)?, number(42)?);
    let stored = || {
        let rest = archive.get(local..).filter(|rest| rest.starts_with(ZIP_HEAD))?;
        let (name, extra) = (usize::from(u16_at(rest, 26)?), usize::from(u16_at(rest, 28)?));
        rest.get(LOCAL_LENGTH + name + extra..)?.get(..size)
    };
    let found = Entry {
        name,
        stored: stored(),
        sum: u32_at(rest, 16)?,
        is_stored: u16_at(rest, 10)? == 0,
    };
    let next = at + CENTRAL_LENGTH + length(28)? + length(30)? + length(32)?;
    Some((found, next))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let bytes = bytes.get(at..)?.first_chunk::<2>()?;
    Some(u16::from_le_bytes(*bytes))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let bytes = bytes.get(at..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*bytes))
}
