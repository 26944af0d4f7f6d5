//! Checks the JSON of a glTF file without a reader: whether the file has meshes, and whether its buffers exist.

use std::collections::BTreeSet;
use std::ffi::{CString, OsStr};
use std::fs::File;
use std::os::unix::ffi::{OsStrExt, OsStringExt};
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::request::{Input, Request};
use crate::{c_files, contents};

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Document {
    meshes: Vec<IgnoredAny>,
    buffers: Vec<Buffer>,
    buffer_views: Vec<BufferView>,
}

#[derive(Deserialize)]
struct Buffer {
    uri: Option<String>,
    /// Extensions of meshopt, whose buffers may be placeholders for decoded data.
    extensions: Option<IgnoredAny>,
}

#[derive(Deserialize)]
struct BufferView {
    buffer: usize,
}

/// For a file with unreadable JSON, the reader gives the error.
fn document(bytes: &[u8]) -> Document {
    let json = match bytes.starts_with(b"glTF") {
        // A header of 12 bytes, then the length and the kind of the first chunk.
        true => {
            let length = bytes.get(12..16).and_then(|bytes| bytes.try_into().ok());
            let length = length.map_or(0, u32::from_le_bytes) as usize;
            bytes.get(20..).map(|rest| &rest[..rest.len().min(length)])
        }
        false => Some(bytes),
    };
    let document = json.and_then(|json| serde_json::from_slice(json).ok());
    document.unwrap_or_default()
}

/// Whether a glTF file lists a mesh.
pub(crate) fn has_meshes(bytes: &[u8]) -> bool {
    !document(bytes).meshes.is_empty()
}

/// Refuses a glTF file whose buffer file cannot be opened, with Assimp's message. The reader itself accepts missing
/// bind poses of skins. But without the buffer, the scene would lack its motion or its meshes.
///
/// # Safety
/// The pointers of the input and of the handlers point to values of their types.
pub(crate) unsafe fn require_buffers(request: &Request<'_>) -> Result<(), String> {
    // SAFETY: the caller's promise in `# Safety`.
    let document = document(&unsafe { contents::read(request, usize::MAX) }?);
    let used: BTreeSet<usize> = document.buffer_views.iter().map(|view| view.buffer).collect();
    let used = used.into_iter().filter_map(|index| document.buffers.get(index));
    for uri in used.filter_map(file_of) {
        // SAFETY: the caller's promise in `# Safety`.
        if !unsafe { can_be_opened(request, uri) } {
            return Err(format!("GLTF: could not open referenced file \"{uri}\""));
        }
    }
    Ok(())
}

/// The path of a buffer's file on the disk. The readers handle names with escaped characters.
fn file_of(buffer: &Buffer) -> Option<&str> {
    let uri = buffer.uri.as_deref().filter(|_| buffer.extensions.is_none())?;
    (!uri.starts_with("data:") && !uri.contains('%')).then_some(uri)
}

/// # Safety
/// As [`require_buffers`].
unsafe fn can_be_opened(request: &Request<'_>, uri: &str) -> bool {
    let path = match request.input {
        Input::File(path) | Input::FileOf(_, path) => {
            let folder = Path::new(OsStr::from_bytes(path.to_bytes())).parent();
            folder.unwrap_or(Path::new("")).join(uri)
        }
        Input::Memory(..) => uri.into(),
    };
    let Ok(name) = CString::new(path.clone().into_os_string().into_vec()) else {
        return false;
    };
    match request.input {
        // SAFETY: the caller's promise in `# Safety`.
        Input::FileOf(files, _) => unsafe { c_files::read(files, &name, 1) }.is_some(),
        _ if request.handlers.io.0.is_null() => File::open(path).is_ok(),
        // SAFETY: the caller's promise in `# Safety`.
        _ => unsafe { request.handlers.io.read(name.as_ptr(), 1) }.is_some(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_seen_in_the_json() {
        assert!(has_meshes(
            br#"{"asset": {"version": "2.0"}, "meshes": [{"primitives": []}]}"#
        ));
        assert!(!has_meshes(br#"{"asset": {"version": "2.0"}, "nodes": [{}]}"#));
    }
}
