//! Finds the provenance of a USD file of this crate, without reading the rest of it.

use memchr::memmem;

use super::PROVENANCE;

/// How every text of USD begins.
#[doc(hidden)]
pub const USD_HEAD: &[u8] = b"#usda ";

/// How every ZIP archive begins, `.usdz` too, and the bytes of the header of a file in it before its name.
#[doc(hidden)]
pub const ZIP_HEAD: &[u8] = b"PK\x03\x04";

/// Bytes of the header of a file in an archive before its name: the specification of ZIP.
const ZIP_HEADER: usize = 30;

/// The length of the search: the metadata of the layer are at its beginning.
pub(super) const USD_HEADER: usize = 1 << 20;

/// The JSON that this crate wrote; `None` in files of other programs, also where they have kept it: they write it
/// between other quotes, or with other spaces. `bytes` are a file or its beginning.
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
