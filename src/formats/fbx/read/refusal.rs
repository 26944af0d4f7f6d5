//! Makes a diagnostic from an error of ufbx, and finds where a file is cut off.

use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::files::FBX_HEAD;
use ufbx::ErrorType;

use crate::fbx::sniff;
use crate::text::{Cursor, Word, is_line_end, quote};

/// The diagnostic for `bytes`, which ufbx rejected with `error`.
pub(super) fn refusal(error: &ufbx::Error, bytes: &[u8]) -> Diagnostic {
    let reason = match error.info() {
        "" => error.description.to_string(),
        info => format!("{} ({info})", &*error.description),
    };
    let message = format!("the FBX file cannot be read: {reason}");
    if bytes.is_empty() {
        return Diagnostic::new(Code::EmptyFile, "the file is empty");
    }
    if let ErrorType::MemoryLimit | ErrorType::AllocationLimit | ErrorType::NodeDepthLimit = error.type_ {
        return Diagnostic::new(Code::LimitExceeded, message);
    }
    if !sniff(bytes) {
        let head = &bytes[..bytes.len().min(FBX_HEAD.len())];
        return Diagnostic::new(Code::InvalidFbx, "the file is not FBX")
            .expected_found("\"Kaydara FBX Binary\" or \"; FBX\" at its beginning", quote(head))
            .help("check that the extension matches the contents of the file, and that the file is not compressed");
    }
    let cut_off = match bytes.starts_with(FBX_HEAD) {
        true => cut_off_binary(bytes),
        false => cut_off_text(bytes),
    };
    let ends_early = matches!(error.type_, ErrorType::TruncatedFile | ErrorType::EmptyFile);
    match cut_off {
        Some(diagnostic) => diagnostic,
        None if ends_early => Diagnostic::new(Code::UnexpectedEnd, "the file is cut off")
            .expected_found("the rest of an FBX file", format!("{} bytes", bytes.len()))
            .help("export or download the file again"),
        None => Diagnostic::new(Code::InvalidFbx, message)
            .help("export the motion again, as binary FBX of version 7.4 or newer, or as BVH"),
    }
}

/// Finds the section that reaches beyond the end of a binary file. Each section begins with the offset of its end.
fn cut_off_binary(bytes: &[u8]) -> Option<Diagnostic> {
    /// The offset of the first section, in bytes: after the magic, two bytes that detect damage, one byte for the byte
    /// order, and the version.
    const SECTIONS: usize = 27;
    /// In this version and later versions, the numbers of a section take 8 bytes instead of 4.
    const WIDE: u32 = 7500;
    let version = bytes.get(SECTIONS - 4..SECTIONS)?.first_chunk().copied()?;
    let number_size = if u32::from_le_bytes(version) >= WIDE { 8 } else { 4 };
    let number = |at: usize| {
        let mut number = [0; 8];
        number[..number_size].copy_from_slice(bytes.get(at..at + number_size)?);
        usize::try_from(u64::from_le_bytes(number)).ok()
    };
    let mut start = SECTIONS;
    loop {
        let end = number(start)?;
        // A section has its end, the number of its values and the length of their bytes, then the length of its name,
        // and its name.
        let name_at = start + 3 * number_size + 1;
        let length = usize::from(*bytes.get(name_at - 1)?);
        let name = quote(bytes.get(name_at..name_at + length)?);
        if end > bytes.len() {
            let message = format!("the file is cut off inside the section {name}");
            return Some(
                Diagnostic::new(Code::UnexpectedEnd, message)
                    .expected_found(
                        format!("the section from byte {start} to byte {end}"),
                        format!("{} bytes", bytes.len()),
                    )
                    .help("export or download the file again"),
            );
        }
        // The record after the last section states the end 0, so the file is not cut off. Any other end before the name
        // is a fault of another kind.
        if end < name_at {
            return None;
        }
        start = end;
    }
}

/// Finds the unclosed section of a text file.
fn cut_off_text(bytes: &[u8]) -> Option<Diagnostic> {
    let mut cursor = Cursor::new(bytes);
    let mut open: Vec<Word<'_>> = Vec::new();
    let mut keyword = None;
    while let Some(byte) = cursor.peek() {
        match byte {
            b';' => {
                cursor.take_while(|byte| !is_line_end(byte));
            }
            b'"' => {
                cursor.set_offset(cursor.offset() + 1);
                cursor.take_while(|byte| byte != b'"');
                cursor.set_offset((cursor.offset() + 1).min(bytes.len()));
            }
            b'{' | b'}' => {
                match byte {
                    b'{' => open.extend(keyword),
                    _ => _ = open.pop(),
                }
                cursor.set_offset(cursor.offset() + 1);
            }
            _ => {
                let word = cursor.take_while(|byte| !matches!(byte, b';' | b'"' | b'{' | b'}' | b':' | b'\n'));
                if cursor.peek() == Some(b':') {
                    keyword = Some(Word {
                        bytes: word.bytes.trim_ascii(),
                        offset: word.offset,
                    });
                }
                if let Some(b':' | b'\n') = cursor.peek() {
                    cursor.set_offset(cursor.offset() + 1);
                }
            }
        }
    }
    let section = open.last()?;
    let name = quote(section.bytes);
    let line = cursor.locate(*section).line;
    let message = format!("the file ends inside the section {name}");
    Some(
        Diagnostic::new(Code::UnexpectedEnd, message)
            .at(cursor.locate_end())
            .expected_found("}", "the end of the file")
            .help(format!(
                "the section that begins in line {line} is not closed; the file is cut off or closing braces are missing"
            )),
    )
}
