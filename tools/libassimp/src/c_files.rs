//! File systems that a C program makes of functions: `aiFileIO`.

use std::ffi::{CStr, c_char, c_void};

use crate::abi::{ScenePrivate, aiFileIO, aiMatrix4x4, aiScene, aiString};
use crate::properties::Properties;
use crate::system::function;

/// All bytes of a file, or its first `most`; `None` if it cannot be opened.
///
/// # Safety
/// `files` is a file system, whose functions do what the headers say.
pub(crate) unsafe fn read(files: *mut aiFileIO, path: &CStr, most: usize) -> Option<Vec<u8>> {
    // SAFETY: the same promise.
    unsafe {
        let (open, close) = ((*files).OpenProc?, (*files).CloseProc?);
        let file = open(files, path.as_ptr(), c"rb".as_ptr());
        let (read, size) = (file.as_ref()?.ReadProc, (*file).FileSizeProc);
        let mut bytes = Vec::new();
        if let (Some(read), Some(size)) = (read, size) {
            bytes.resize(size(file).min(most), 0);
            let count = read(file, bytes.as_mut_ptr().cast(), 1, bytes.len());
            bytes.truncate(count);
        }
        close(files, file);
        Some(bytes)
    }
}

/// Imports by the function of the system's Assimp that takes such a file system. The scene is the caller's.
///
/// # Safety
/// As [`read`].
pub(crate) unsafe fn import(
    files: *mut aiFileIO,
    path: &CStr,
    flags: u32,
    properties: &Properties,
) -> Result<*mut aiScene, String> {
    type Import = unsafe extern "C" fn(*const c_char, u32, *mut aiFileIO, *mut c_void) -> *mut aiScene;
    type Set<T> = unsafe extern "C" fn(*mut c_void, *const c_char, T);
    // SAFETY: functions of the headers, a store, names and values.
    unsafe {
        let store = function::<unsafe extern "C" fn() -> *mut c_void>(c"aiCreatePropertyStore")?();
        let integer = function::<Set<i32>>(c"aiSetImportPropertyInteger")?;
        let float = function::<Set<f32>>(c"aiSetImportPropertyFloat")?;
        let string = function::<Set<*const aiString>>(c"aiSetImportPropertyString")?;
        let matrix = function::<Set<*const aiMatrix4x4>>(c"aiSetImportPropertyMatrix")?;
        for (name, &value) in &properties.integers {
            integer(store, name.as_ptr(), value);
        }
        for (name, &value) in &properties.floats {
            float(store, name.as_ptr(), value);
        }
        for (name, value) in &properties.strings {
            string(store, name.as_ptr(), &aiString::from_bytes(value.to_bytes()));
        }
        for (name, value) in &properties.matrices {
            matrix(store, name.as_ptr(), value);
        }
        let scene = function::<Import>(c"aiImportFileExWithProperties")?(path.as_ptr(), flags, files, store);
        function::<unsafe extern "C" fn(*mut c_void)>(c"aiReleasePropertyStore")?(store);
        if scene.is_null() {
            let text = function::<unsafe extern "C" fn() -> *const c_char>(c"aiGetErrorString")?();
            return Err(CStr::from_ptr(text).to_string_lossy().into_owned());
        }
        // The scene belongs to an importer, which gives it away before it is deleted.
        let private: *mut ScenePrivate = (*scene).mPrivate;
        let importer = std::mem::replace(&mut (*private).importer, std::ptr::null_mut());
        type Method<R> = unsafe extern "C" fn(*mut c_void) -> R;
        function::<Method<*mut aiScene>>(c"_ZN6Assimp8Importer16GetOrphanedSceneEv")?(importer);
        function::<Method<()>>(c"_ZN6Assimp8ImporterD1Ev")?(importer);
        crate::heap::delete(importer);
        Ok(scene)
    }
}
