//! From a file to a scene, and its end.

use std::ffi::{CStr, OsStr, c_char, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::ptr;

use mocap::{FORMATS, Importer, RootOffset, SkeletonMesh};

use crate::abi::{aiScene, aiString};
use crate::border::{guard, slice, text};
use crate::flags;
use crate::properties::Properties;
use crate::to_assimp::Imported;

/// Reads a file. Returns NULL where that fails; `aiGetErrorString` says why. [`aiReleaseImport`] frees the scene.
///
/// # Safety
/// `path` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFile(path: *const c_char, flags: u32) -> *const aiScene {
    // SAFETY: the same promise, and neither a file system nor properties.
    unsafe { aiImportFileExWithProperties(path, flags, ptr::null_mut(), ptr::null()) }
}

/// As [`aiImportFile`]; with a file system of the caller's own it fails.
///
/// # Safety
/// `path` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileEx(
    path: *const c_char,
    flags: u32,
    file_system: *mut c_void,
) -> *const aiScene {
    // SAFETY: the same promise, and no properties.
    unsafe { aiImportFileExWithProperties(path, flags, file_system, ptr::null()) }
}

/// As [`aiImportFileEx`], with properties.
///
/// # Safety
/// `path` is NULL or ends with a zero byte, and `properties` is NULL or a store.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileExWithProperties(
    path: *const c_char,
    flags: u32,
    file_system: *mut c_void,
    properties: *const Properties,
) -> *const aiScene {
    guard(ptr::null(), || {
        if !file_system.is_null() {
            return Err("file systems of the caller's own are not supported; import from memory".to_owned());
        }
        // SAFETY: the caller hands over NULL or a store, and NULL or a text.
        unsafe { import_file(path, flags, properties.as_ref()) }
    })
}

/// Reads a file that is in memory, `size` bytes of it. `hint` is its extension, or NULL.
///
/// # Safety
/// `bytes` points to `size` bytes, and `hint` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileFromMemory(
    bytes: *const u8,
    size: u32,
    flags: u32,
    hint: *const c_char,
) -> *const aiScene {
    // SAFETY: the same promise, and no properties.
    unsafe { aiImportFileFromMemoryWithProperties(bytes, size, flags, hint, ptr::null()) }
}

/// As [`aiImportFileFromMemory`], with properties.
///
/// # Safety
/// `bytes` points to `size` bytes, `hint` is NULL or ends with a zero byte, and `properties` is NULL or a store.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileFromMemoryWithProperties(
    bytes: *const u8,
    size: u32,
    flags: u32,
    hint: *const c_char,
    properties: *const Properties,
) -> *const aiScene {
    guard(ptr::null(), || {
        // SAFETY: the caller hands over NULL or a store, `size` bytes, and NULL or a text.
        unsafe { import_memory(bytes, size as usize, flags, hint, properties.as_ref()) }
    })
}

/// # Safety
/// `path` is NULL or ends with a zero byte.
pub(crate) unsafe fn import_file(
    path: *const c_char,
    flags: u32,
    properties: Option<&Properties>,
) -> Result<*const aiScene, String> {
    // SAFETY: the same promise.
    let path = unsafe { text(path, "the path") }?;
    let path = Path::new(OsStr::from_bytes(path.to_bytes()));
    import(flags, properties, |importer| importer.import(path))
}

/// # Safety
/// `bytes` is NULL or points to `size` bytes, and `hint` is NULL or ends with a zero byte.
pub(crate) unsafe fn import_memory(
    bytes: *const u8,
    size: usize,
    flags: u32,
    hint: *const c_char,
    properties: Option<&Properties>,
) -> Result<*const aiScene, String> {
    // SAFETY: the same promise.
    let bytes = unsafe { slice(bytes, size, "the memory") }?;
    // SAFETY: the same promise.
    let hint = unsafe { text(hint, "the hint") }.map_or(b"".as_slice(), CStr::to_bytes);
    let name = Path::new("memory").with_extension(OsStr::from_bytes(hint));
    import(flags, properties, |importer| importer.read(bytes, &name))
}

fn import(
    flags: u32,
    properties: Option<&Properties>,
    read: impl FnOnce(Importer) -> mocap::Result<mocap::Scene>,
) -> Result<*const aiScene, String> {
    flags::check(flags)?;
    let mesh = match properties {
        Some(properties) if properties.no_skeleton_meshes() => SkeletonMesh::None,
        _ => SkeletonMesh::Skinned,
    };
    // Programs written for Assimp expect that the root's OFFSET is replaced.
    let importer = Importer::new()
        .skeleton_mesh(mesh)
        .collapse_keys(false)
        .root_offset(RootOffset::Replace);
    let mut scene = read(importer).map_err(|error| error.to_string())?;
    flags::run(&mut scene, flags)?;
    Ok(Imported::into_raw(&scene, flags::of_scene(flags)))
}

/// Frees a scene and everything that it points to.
///
/// # Safety
/// `scene` is NULL or comes from an import, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiReleaseImport(scene: *const aiScene) {
    // SAFETY: the same promise.
    unsafe { Imported::release(scene) };
}

/// 1 if files with this extension are read, with or without its dot; else 0.
///
/// # Safety
/// `extension` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiIsExtensionSupported(extension: *const c_char) -> i32 {
    guard(0, || {
        // SAFETY: the caller hands over NULL or a text.
        Ok(i32::from(is_supported(unsafe { text(extension, "the extension") }?)))
    })
}

/// The extensions that are read, as in `*.bvh;*.asf`.
///
/// # Safety
/// `list` points to an `aiString`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetExtensionList(list: *mut aiString) {
    let patterns: Vec<String> = extensions().map(|extension| format!("*.{extension}")).collect();
    if !list.is_null() {
        // SAFETY: the caller hands over the place of an `aiString`.
        unsafe { list.write(aiString::new(&patterns.join(";"))) };
    }
}

fn is_supported(extension: &CStr) -> bool {
    let extension = extension.to_string_lossy();
    let extension = extension.trim_start_matches(['*', '.']);
    extensions().any(|known| known.eq_ignore_ascii_case(extension))
}

fn extensions() -> impl Iterator<Item = &'static str> {
    FORMATS.iter().flat_map(|format| format.extensions.iter().copied())
}
