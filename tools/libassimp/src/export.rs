//! Writes scenes to files and blobs. This library writes glTF 2.0 of skeletons and motions. It passes every other
//! format, and scenes with other content, to the system's Assimp.

use std::ffi::{OsStr, c_char, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::ptr;

use mocap::files::{OutputSet, ReplacePolicy, write_file};
use mocap::gltf::{Document, GltfOptions};

use crate::abi::{AI_FAILURE, AI_SUCCESS, aiExportDataBlob, aiExportFormatDesc, aiFileIO, aiReturn, aiScene, aiString};
use crate::border::{error_text_of_system, guard, text};
use crate::system::calls;
use crate::{destroy, from_assimp, heap};

/// The formats that this library writes, by Assimp's ids.
#[derive(Clone, Copy)]
enum Format {
    Text,
    Binary,
}

/// A table that programs read through a pointer; its strings are never freed.
struct Table([aiExportFormatDesc; 2]);

// SAFETY: the table holds pointers to constant strings, and nothing writes it.
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

/// The number of formats that this library and the system's Assimp write. The system's Assimp has all formats of this
/// library.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetExportFormatCount() -> usize {
    match calls::export_format_count() {
        // SAFETY: the function takes no argument.
        Ok(count) => unsafe { count() },
        Err(_) => FORMATS.0.len(),
    }
}

/// The description of a format; NULL beyond the last.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetExportFormatDescription(index: usize) -> *const aiExportFormatDesc {
    if index >= aiGetExportFormatCount() {
        return ptr::null();
    }
    match calls::export_format_description() {
        // SAFETY: the number of formats is larger.
        Ok(describe) => unsafe { describe(index) },
        Err(_) => &raw const FORMATS.0[index],
    }
}

/// Returns a description to the library.
///
/// # Safety
/// `description` is NULL or comes from [`aiGetExportFormatDescription`], and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiReleaseExportFormatDescription(description: *const aiExportFormatDesc) {
    if description.is_null() || FORMATS.0.as_ptr_range().contains(&description) {
        return;
    }
    if let Ok(release) = calls::release_export_format_description() {
        // SAFETY: one of its descriptions, which is not used any more.
        unsafe { release(description) };
    }
}

/// Writes a scene to a file: `glb2`, `gltf2` with a `.bin` beside it, or a format of the system's Assimp.
///
/// # Safety
/// `scene` is NULL or a whole scene; `format` and `path` are NULL or end with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiExportScene(
    scene: *const aiScene,
    format: *const c_char,
    path: *const c_char,
    flags: u32,
) -> aiReturn {
    // SAFETY: the caller's promise in `# Safety`, and no file system.
    unsafe { aiExportSceneEx(scene, format, path, ptr::null_mut(), flags) }
}

/// As [`aiExportScene`], into a file system of the caller; the system's Assimp then writes the file.
///
/// # Safety
/// As [`aiExportScene`], and `files` is NULL or a file system.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiExportSceneEx(
    scene: *const aiScene,
    format: *const c_char,
    path: *const c_char,
    files: *mut aiFileIO,
    flags: u32,
) -> aiReturn {
    guard(AI_FAILURE, || {
        // SAFETY: the caller passes NULL or strings, and NULL or a scene.
        let (format, path, own) = unsafe { (text(format, "the format")?, text(path, "the path")?, own(scene, format)) };
        match own {
            Ok((document, kind)) if files.is_null() && flags == 0 => {
                let path = Path::new(OsStr::from_bytes(path.to_bytes()));
                write(&document, kind, path).map_err(|error| error.to_string())?;
            }
            own => {
                let export = calls::export_scene().map_err(|reason| not_written(own.err(), &reason))?;
                // SAFETY: a scene and strings.
                let result = unsafe { export(scene, format.as_ptr(), path.as_ptr(), files, flags) };
                if result != AI_SUCCESS {
                    return Err(failure_of_system(&format.to_string_lossy()));
                }
            }
        }
        Ok(AI_SUCCESS)
    })
}

/// Writes a scene into memory, as one blob without a name, or as the system's Assimp does; `gltf2` contains its buffer.
/// [`aiReleaseExportBlob`] frees it.
///
/// # Safety
/// `scene` is NULL or a whole scene; `format` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiExportSceneToBlob(
    scene: *const aiScene,
    format: *const c_char,
    flags: u32,
) -> *const aiExportDataBlob {
    guard(ptr::null(), || {
        // SAFETY: the caller passes NULL or a string, and NULL or a scene.
        let (format, own) = unsafe { (text(format, "the format")?, own(scene, format)) };
        match own {
            Ok((document, kind)) if flags == 0 => {
                let bytes = match kind {
                    Format::Text => document.to_embedded(),
                    Format::Binary => document.to_glb(),
                };
                let bytes = bytes.map_err(|error| error.to_string())?;
                Ok(heap::new(aiExportDataBlob {
                    size: bytes.len(),
                    data: heap::new_array(&bytes).cast::<c_void>(),
                    name: aiString::new(""),
                    next: ptr::null_mut(),
                }))
            }
            own => {
                let export = calls::export_scene_to_blob().map_err(|reason| not_written(own.err(), &reason))?;
                // SAFETY: a scene and a string.
                let blob = unsafe { export(scene, format.as_ptr(), flags) };
                match blob.is_null() {
                    true => Err(failure_of_system(&format.to_string_lossy())),
                    false => Ok(blob.cast_mut()),
                }
            }
        }
    })
}

/// Frees a blob and all following blobs.
///
/// # Safety
/// `blob` is NULL or comes from [`aiExportSceneToBlob`], and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiReleaseExportBlob(blob: *const aiExportDataBlob) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { destroy::blobs(blob.cast_mut()) };
}

/// The bytes that this library writes for a scene, or the reason why it does not write the scene.
///
/// # Safety
/// `scene` is NULL or a whole scene; `id` ends with a zero byte.
unsafe fn own(scene: *const aiScene, id: *const c_char) -> Result<(Document, Format), String> {
    // SAFETY: the caller's promise in `# Safety`.
    let (id, scene) = unsafe { (text(id, "the format")?, scene.as_ref().ok_or("the scene is NULL")?) };
    let format = match id.to_bytes() {
        b"gltf2" => Format::Text,
        b"glb2" => Format::Binary,
        other => {
            let other = String::from_utf8_lossy(other);
            return Err(format!("mocap's libassimp writes only gltf2 and glb2, not \"{other}\""));
        }
    };
    // SAFETY: the scene is whole.
    let scene = unsafe {
        from_assimp::check_nothing_is_lost(scene)?;
        from_assimp::scene(scene)?
    };
    let document = Document::new(&scene, &GltfOptions::default()).map_err(|error| error.to_string())?;
    Ok((document, format))
}

/// The reason why neither library wrote a scene.
fn not_written(own: Option<String>, system: &str) -> String {
    match own {
        Some(own) => format!("{own}; {system}"),
        None => format!("mocap's libassimp writes scenes without steps and without other file systems; {system}"),
    }
}

fn failure_of_system(format: &str) -> String {
    match error_text_of_system() {
        text if text.is_empty() => format!("the system's Assimp did not write \"{format}\": it has no such format"),
        text => text,
    }
}

fn write(document: &Document, format: Format, path: &Path) -> mocap::Result<()> {
    match format {
        Format::Binary => write_file(path, &document.to_glb()?),
        Format::Text => {
            let bin_path = path.with_extension("bin");
            let name = bin_path.file_name().unwrap_or_default().to_string_lossy();
            let (text, bin) = document.to_text_and_bin(&name)?;
            let mut set = OutputSet::new();
            if !bin.is_empty() {
                set.add_beside(path, &name, [bin])?;
            }
            set.add(path, [text.as_slice()]);
            // Assimp replaces existing files.
            set.save(&ReplacePolicy::default().force(true))
        }
    }
}
