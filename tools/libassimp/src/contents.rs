//! Determines the content of a file by its first bytes, else by its extension: motion, a scene, or a format that this
//! library does not read.

use std::ffi::{CStr, OsStr};
use std::fs::File;
use std::io::Read;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use crate::c_files;
use crate::gltf;
use crate::request::{Input, Request, unable_to_open};

/// The kind of a file, which determines its reader.
pub(crate) enum Contents {
    /// A format of motion, which this library reads.
    Motion,
    /// glTF or FBX without meshes, which this library reads.
    Scene,
    /// glTF or FBX with meshes, whose materials this library does not read.
    WithMeshes,
    /// Another format; the name of the file.
    Other(String),
}

/// The first bytes, which identify a format.
const HEAD: usize = 64 << 10;

/// Extensions of the formats that this library reads, except glTF and FBX.
const MOTION: [&str; 6] = ["bvh", "asf", "amc", "c3d", "trc", "bip"];

/// # Safety
/// The pointers of the input and of the handlers point to values of their types.
pub(crate) unsafe fn of(request: &Request<'_>) -> Result<Contents, String> {
    let (name, extension) = match request.input {
        Input::File(path) | Input::FileOf(_, path) => (path.to_string_lossy().into_owned(), extension(path)),
        Input::Memory(_, hint) => ("the file in memory".to_owned(), hint.to_string_lossy().to_lowercase()),
    };
    // SAFETY: the caller's promise in `# Safety`.
    let head = unsafe { read(request, HEAD) }?;
    let begins = |word: &[u8]| head.trim_ascii_start().starts_with(word);
    let is_gltf = begins(b"glTF") || (begins(b"{") && matches!(extension.as_str(), "gltf" | "glb" | "vrm"));
    let is_fbx = begins(b"Kaydara FBX Binary") || begins(b"; FBX");
    if is_gltf || is_fbx {
        // SAFETY: the caller's promise in `# Safety`.
        let all = unsafe { read(request, usize::MAX) }?;
        let has_meshes = if is_gltf {
            gltf::has_meshes(&all)
        } else {
            fbx_has_meshes(&all)
        };
        return Ok(if has_meshes {
            Contents::WithMeshes
        } else {
            Contents::Scene
        });
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start();
    let is_bvh = text
        .get(..9)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"HIERARCHY"));
    if is_bvh || MOTION.contains(&extension.as_str()) {
        return Ok(Contents::Motion);
    }
    Ok(Contents::Other(name))
}

/// All bytes of a file that is not read from the disk by its path.
///
/// # Safety
/// As [`of`].
pub(crate) unsafe fn all(request: &Request<'_>) -> Option<Vec<u8>> {
    match request.input {
        Input::File(_) if request.handlers.io.0.is_null() => None,
        // SAFETY: the caller's promise in `# Safety`.
        _ => unsafe { read(request, usize::MAX) }.ok(),
    }
}

/// The first bytes of a file, at most `most`.
///
/// # Safety
/// As [`of`].
pub(crate) unsafe fn read(request: &Request<'_>, most: usize) -> Result<Vec<u8>, String> {
    match request.input {
        Input::Memory(bytes, _) => Ok(bytes[..bytes.len().min(most)].to_vec()),
        // SAFETY: the caller's promise in `# Safety`.
        Input::FileOf(files, path) => unsafe { c_files::read(files, path, most) }.ok_or_else(|| unable_to_open(path)),
        Input::File(path) if request.handlers.io.0.is_null() => {
            let file = File::open(Path::new(OsStr::from_bytes(path.to_bytes())));
            let mut bytes = Vec::new();
            let count = file.and_then(|file| file.take(most as u64).read_to_end(&mut bytes));
            count.map_err(|error| format!("{} {error}", unable_to_open(path)))?;
            Ok(bytes)
        }
        Input::File(path) => {
            // SAFETY: the caller's promise in `# Safety`.
            let bytes = unsafe { request.handlers.io.read(path.as_ptr(), most) };
            bytes.ok_or_else(|| unable_to_open(path))
        }
    }
}

fn extension(path: &CStr) -> String {
    let extension = Path::new(OsStr::from_bytes(path.to_bytes())).extension();
    extension.unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Whether an FBX file has an array of vertices: a node of this name. In binary files, the length of the name precedes
/// it.
fn fbx_has_meshes(bytes: &[u8]) -> bool {
    let is_binary = bytes.starts_with(b"Kaydara");
    let name: &[u8] = if is_binary { b"\x08Vertices" } else { b"Vertices:" };
    memchr::memmem::find(bytes, name).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_seen_in_fbx() {
        let fixture = |name: &str| std::fs::read(format!("../../fixtures/real/{name}")).unwrap();
        assert!(!fbx_has_meshes(&fixture("run.fbx")));
        assert!(fbx_has_meshes(&fixture("huesitos.fbx")));
    }
}
