//! Finds the provenance of a USD file of this crate, without parsing the whole file.

use memchr::memmem;

use super::PROVENANCE;

/// The first bytes of every USD text.
#[doc(hidden)]
pub const USD_HEAD: &[u8] = b"#usda ";

/// The first bytes of every ZIP archive, including `.usdz`.
#[doc(hidden)]
pub const ZIP_HEAD: &[u8] = b"PK\x03\x04";

/// The size in bytes of an archive entry's header before its name, by the ZIP specification.
const ZIP_HEADER: usize = 30;

/// The number of bytes to search: the layer metadata are at the beginning of the file.
pub(super) const USD_HEADER: usize = 1 << 20;

/// The JSON that this crate wrote; `None` for files of other programs. Also `None` if another program has rewritten the
/// JSON, because programs use other quotes or spaces. `bytes` are a file or its beginning.
pub(super) fn usd_provenance(bytes: &[u8]) -> Option<String> {
    let layer = match bytes.starts_with(ZIP_HEAD) {
        true => {
            let length = |at: usize| Some(usize::from(u16::from_le_bytes(*bytes.get(at..)?.first_chunk::<2>()?)));
            bytes.get(ZIP_HEADER + length(26)? + length(28)?..)?
        }
        false => bytes,
    };
    if !layer.starts_with(USD_HEAD) {
        return None;
    }
    let header = &layer[..layer.len().min(USD_HEADER)];
    let name = format!("        string {PROVENANCE} = \"");
    let quoted = &header[memmem::find(header, name.as_bytes())? + name.len()..];
    let mut json = Vec::new();
    let mut bytes = quoted.iter();
    loop {
        match bytes.next()? {
            b'"' => return String::from_utf8(json).ok(),
            b'\\' => json.push(*bytes.next()?),
            byte => json.push(*byte),
        }
    }
}
