//! From a scene to glTF 2.0, in files or in memory.

use std::ffi::{OsStr, c_char, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::ptr;

use mocap::export::write_file;
use mocap::gltf::{Document, Options};

use crate::abi::{AI_FAILURE, AI_SUCCESS, aiExportDataBlob, aiExportFormatDesc, aiReturn, aiScene, aiString};
use crate::arena::Arena;
use crate::border::{guard, text};
use crate::from_assimp;

/// The formats, by Assimp's ids for them.
#[derive(Clone, Copy)]
enum Format {
    Text,
    Binary,
}

/// A table that programs read through a pointer; its texts are never freed.
struct Table([aiExportFormatDesc; 2]);

// SAFETY: the table holds pointers to constant texts, and nothing writes it.
unsafe impl Sync for Table {}

static FORMATS: Table = Table([
    aiExportFormatDesc {
        id: c"gltf2".as_ptr(),
        description: c"GL Transmission Format v. 2".as_ptr(),
        fileExtension: c"gltf".as_ptr(),
    },
    aiExportFormatDesc {
        id: c"glb2".as_ptr(),
        description: c"GL Transmission Format v. 2 (binary)".as_ptr(),
        fileExtension: c"glb".as_ptr(),
    },
]);

/// How many formats are written.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetExportFormatCount() -> usize {
    FORMATS.0.len()
}

/// What a format is called; NULL beyond the last.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetExportFormatDescription(index: usize) -> *const aiExportFormatDesc {
    FORMATS.0.get(index).map_or(ptr::null(), ptr::from_ref)
}

/// Gives a description back.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiReleaseExportFormatDescription(_description: *const aiExportFormatDesc) {}

/// Writes a scene to a file: `glb2`, or `gltf2` with a `.bin` beside it. The flags are not looked at: the writer does
/// what glTF needs.
///
/// # Safety
/// `scene` is NULL or a whole scene; `format` and `path` are NULL or end with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiExportScene(
    scene: *const aiScene,
    format: *const c_char,
    path: *const c_char,
    _flags: u32,
) -> aiReturn {
    guard(AI_FAILURE, || {
        // SAFETY: the caller hands over NULL or a text.
        let format = unsafe { format_of(format) }?;
        // SAFETY: the caller hands over NULL or a text.
        let path = unsafe { text(path, "the path") }?;
        let path = Path::new(OsStr::from_bytes(path.to_bytes()));
        // SAFETY: the caller hands over NULL or a scene.
        let document = unsafe { document(scene) }?;
        write(&document, format, path).map_err(|error| error.to_string())?;
        Ok(AI_SUCCESS)
    })
}

/// Writes a scene into memory, as one blob without a name; `gltf2` carries its buffer in itself.
/// [`aiReleaseExportBlob`] frees it.
///
/// # Safety
/// `scene` is NULL or a whole scene; `format` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiExportSceneToBlob(
    scene: *const aiScene,
    format: *const c_char,
    _flags: u32,
) -> *const aiExportDataBlob {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over NULL or a text.
        let format = unsafe { format_of(format) }?;
        // SAFETY: the caller hands over NULL or a scene.
        let document = unsafe { document(scene) }?;
        let bytes = match format {
            Format::Text => document.to_embedded(),
            Format::Binary => document.to_glb(),
        };
        Ok(Blob::into_raw(bytes.map_err(|error| error.to_string())?))
    })
}

/// Frees a blob.
///
/// # Safety
/// `blob` is NULL or comes from [`aiExportSceneToBlob`], and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiReleaseExportBlob(blob: *const aiExportDataBlob) {
    if !blob.is_null() {
        // SAFETY: `Blob::into_raw` made it, and the caller gives it up.
        drop(unsafe { Box::from_raw(blob.cast_mut().cast::<Blob>()) });
    }
}

/// A blob and the memory it lies in. A pointer to one is a pointer to the other, since the blob stands first.
#[repr(C)]
struct Blob {
    blob: aiExportDataBlob,
    arena: Arena,
}

impl Blob {
    fn into_raw(bytes: Vec<u8>) -> *const aiExportDataBlob {
        let mut arena = Arena::default();
        let blob = aiExportDataBlob {
            size: bytes.len(),
            data: arena.keep(bytes).cast::<c_void>(),
            name: aiString::new(""),
            next: ptr::null_mut(),
        };
        Box::into_raw(Box::new(Self { blob, arena })).cast()
    }
}

/// # Safety
/// `id` is NULL or ends with a zero byte.
unsafe fn format_of(id: *const c_char) -> Result<Format, String> {
    // SAFETY: the caller hands over NULL or a text.
    match unsafe { text(id, "the format") }?.to_bytes() {
        b"gltf2" => Ok(Format::Text),
        b"glb2" => Ok(Format::Binary),
        other => Err(format!(
            "\"{}\" is not written here, only gltf2 and glb2",
            String::from_utf8_lossy(other)
        )),
    }
}

/// # Safety
/// `scene` is NULL or a whole scene.
unsafe fn document(scene: *const aiScene) -> Result<Document, String> {
    // SAFETY: the same promise.
    let scene = unsafe { from_assimp::scene(scene) }?;
    Document::new(&scene, &Options::default()).map_err(|error| error.to_string())
}

fn write(document: &Document, format: Format, path: &Path) -> mocap::Result<()> {
    match format {
        Format::Binary => write_file(path, &document.to_glb()?),
        Format::Text => {
            let bin_path = path.with_extension("bin");
            let name = bin_path.file_name().unwrap_or_default().to_string_lossy();
            let (text, bin) = document.to_text_and_bin(&name)?;
            if !bin.is_empty() {
                write_file(&bin_path, bin)?;
            }
            write_file(path, &text)
        }
    }
}
