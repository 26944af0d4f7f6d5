//! Finds the provenance of an FBX file of this crate, without parsing the whole file.

use memchr::memmem;

/// The name of the scene property that has the provenance as JSON.
#[doc(hidden)]
pub const PROVENANCE: &str = "mocap";

/// The first bytes of every binary FBX.
#[doc(hidden)]
pub const FBX_HEAD: &[u8] = b"Kaydara FBX Binary";

/// The number of bytes to search for the property: the first section of a file.
pub(super) const HEADER: usize = 1 << 20;

/// The JSON that this crate wrote; `None` for files of other programs. `bytes` are a file or its beginning.
#[doc(hidden)]
pub fn fbx_provenance(bytes: &[u8]) -> Option<&str> {
    if !bytes.starts_with(FBX_HEAD) {
        return None;
    }
    let header = &bytes[..bytes.len().min(HEADER)];
    // The property's name, as a string with its length.
    let name = [b"S\x05\0\0\0", PROVENANCE.as_bytes(), b"S\x07\0\0\0KString"].concat();
    let mut rest = &header[memmem::find(header, &name)?..];
    // The five texts of the property: its name, type, label, flags and value.
    let mut texts = [""; 5];
    for text in &mut texts {
        let (head, after) = rest.split_first_chunk::<5>()?;
        let [b'S', length @ ..] = *head else { return None };
        let length = u32::from_le_bytes(length) as usize;
        *text = std::str::from_utf8(after.get(..length)?).ok()?;
        rest = &after[length..];
    }
    (texts[3] == "U").then_some(texts[4])
}
