//! The functions of C that import, change and free scenes.

use std::ffi::{c_char, c_void};
use std::ptr;

use crate::abi::{aiFileIO, aiScene};
use crate::border::{bytes, guard, text};
use crate::properties::Properties;
use crate::request::Input;
use crate::system_importer::Steps;
use crate::{importer, to_assimp};

/// Reads a file. Returns NULL on failure; `aiGetErrorString` has the reason. [`aiReleaseImport`] frees the scene.
///
/// # Safety
/// `path` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFile(path: *const c_char, flags: u32) -> *const aiScene {
    // SAFETY: the caller's promise in `# Safety`, and neither a file system nor properties.
    unsafe { aiImportFileExWithProperties(path, flags, ptr::null_mut(), ptr::null()) }
}

/// As [`aiImportFile`], from a file system of the caller.
///
/// # Safety
/// `path` is NULL or ends with a zero byte, and `files` is NULL or a file system.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileEx(
    path: *const c_char,
    flags: u32,
    files: *mut aiFileIO,
) -> *const aiScene {
    // SAFETY: the caller's promise in `# Safety`, and no properties.
    unsafe { aiImportFileExWithProperties(path, flags, files, ptr::null()) }
}

/// As [`aiImportFileEx`], with properties.
///
/// # Safety
/// As [`aiImportFileEx`], and `properties` is NULL or a store.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileExWithProperties(
    path: *const c_char,
    flags: u32,
    files: *mut aiFileIO,
    properties: *const Properties,
) -> *const aiScene {
    guard(ptr::null(), || {
        // SAFETY: the caller passes NULL or a string.
        let path = unsafe { text(path, "the path") }?;
        let input = match files.is_null() {
            true => Input::File(path),
            false => Input::FileOf(files, path),
        };
        // SAFETY: the caller passes NULL or a store.
        unsafe { import_for_c(input, flags, properties.as_ref()) }
    })
}

/// Reads a file that is in memory, `size` bytes of it. `hint` is its extension, or NULL.
///
/// # Safety
/// `first` points to `size` bytes, and `hint` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileFromMemory(
    first: *const u8,
    size: u32,
    flags: u32,
    hint: *const c_char,
) -> *const aiScene {
    // SAFETY: the caller's promise in `# Safety`, and no properties.
    unsafe { aiImportFileFromMemoryWithProperties(first, size, flags, hint, ptr::null()) }
}

/// As [`aiImportFileFromMemory`], with properties.
///
/// # Safety
/// As [`aiImportFileFromMemory`], and `properties` is NULL or a store.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiImportFileFromMemoryWithProperties(
    first: *const u8,
    size: u32,
    flags: u32,
    hint: *const c_char,
    properties: *const Properties,
) -> *const aiScene {
    guard(ptr::null(), || {
        // SAFETY: the caller passes NULL or a store, `size` bytes, and NULL or a string.
        unsafe {
            let hint = text(hint, "the hint").unwrap_or_default();
            import_for_c(
                Input::Memory(bytes(first, size as usize), hint),
                flags,
                properties.as_ref(),
            )
        }
    })
}

/// Imports with a new importer for this scene, which `aiReleaseImport` finds through the scene.
///
/// # Safety
/// As [`import`].
unsafe fn import_for_c(
    input: Input<'_>,
    flags: u32,
    properties: Option<&Properties>,
) -> Result<*const aiScene, String> {
    let importer = importer::new();
    // SAFETY: the importer was made above, and the caller promises the rest.
    unsafe {
        let Some(state) = importer::state(importer) else {
            return Err("an importer belongs to another library".to_owned());
        };
        state.properties = properties.cloned().unwrap_or_default();
        let scene = state.read(input, flags);
        if let Some(private) = scene.as_mut().and_then(|scene| scene.mPrivate.as_mut()) {
            private.importer = importer.cast();
            return Ok(scene);
        }
        let failure = importer::failure(state).to_string_lossy().into_owned();
        importer::delete(importer);
        Err(failure)
    }
}

/// Frees a scene and everything that it points to.
///
/// # Safety
/// `scene` is NULL or comes from an import, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiReleaseImport(scene: *const aiScene) {
    // SAFETY: the caller's promise in `# Safety`; a scene without an importer belongs to itself.
    unsafe {
        let Some(it) = scene.as_ref() else { return };
        match it.mPrivate.as_ref().map_or(ptr::null_mut(), |private| private.importer) {
            importer if importer.is_null() => to_assimp::free(scene.cast_mut()),
            importer => importer::delete(importer.cast()),
        }
    }
}

/// Runs steps on a scene of an import. Returns the scene; if a step fails, frees the scene and returns NULL.
///
/// # Safety
/// `scene` is NULL or comes from an import.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiApplyPostProcessing(scene: *const aiScene, flags: u32) -> *const aiScene {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { apply(scene, (flags != 0).then_some(Steps::Flags(flags))) }
}

/// `aiApplyCustomizedPostProcessing(const aiScene *scene, BaseProcess *process, bool validate)`, as
/// [`aiApplyPostProcessing`] with a step of the program.
///
/// # Safety
/// `scene` is NULL or comes from an import, and `process` is NULL or a step.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _Z31aiApplyCustomizedPostProcessingPK7aiScenePN6Assimp11BaseProcessEb(
    scene: *const aiScene,
    process: *mut c_void,
    validate: bool,
) -> *const aiScene {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { apply(scene, (!process.is_null()).then_some(Steps::Process(process, validate))) }
}

/// Frees a scene without an importer: a copy, or a scene that the program made.
///
/// # Safety
/// `scene` is NULL or such a scene, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiFreeScene(scene: *const aiScene) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { to_assimp::free(scene.cast_mut()) };
}

/// # Safety
/// `scene` is NULL or comes from an import.
unsafe fn apply(scene: *const aiScene, steps: Option<Steps>) -> *const aiScene {
    guard(ptr::null(), || {
        // SAFETY: the caller passes NULL or a scene of an import.
        unsafe {
            let private = scene.as_ref().and_then(|it| it.mPrivate.as_ref());
            let importer = private.map_or(ptr::null_mut(), |private| private.importer);
            if importer.is_null() {
                return Err("the scene does not come from an import".to_owned());
            }
            let state = importer::state(importer.cast()).ok_or("the scene comes from another library")?;
            let Some(steps) = steps else { return Ok(scene) };
            if state.run(steps).is_null() {
                let failure = importer::failure(state).to_string_lossy().into_owned();
                importer::delete(importer.cast());
                return Err(failure);
            }
            Ok(scene)
        }
    })
}
