//! File systems whose functions a C program provides: `aiFileIO`.

use std::ffi::CStr;

use crate::abi::{ScenePrivate, aiFileIO, aiScene, aiString};
use crate::properties::Properties;
use crate::system::calls;

/// All bytes of a file, or its first `most`; `None` if it cannot be opened.
///
/// # Safety
/// `files` is a file system, whose functions do what the headers say.
pub(crate) unsafe fn read(files: *mut aiFileIO, path: &CStr, most: usize) -> Option<Vec<u8>> {
    // SAFETY: the caller's promise in `# Safety`.
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

/// Imports with the function of the system's Assimp that takes such a file system. The caller owns the scene.
///
/// # Safety
/// As [`read`].
pub(crate) unsafe fn import(
    files: *mut aiFileIO,
    path: &CStr,
    flags: u32,
    properties: &Properties,
) -> Result<*mut aiScene, String> {
    // SAFETY: a store, names and values, and the promise of the caller.
    unsafe {
        let store = calls::create_property_store()?();
        let integer = calls::set_stored_integer()?;
        let float = calls::set_stored_float()?;
        let string = calls::set_stored_string()?;
        let matrix = calls::set_stored_matrix()?;
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
        let scene = calls::import_file()?(path.as_ptr(), flags, files, store);
        calls::release_property_store()?(store);
        if scene.is_null() {
            let text = calls::error_text()?();
            return Err(CStr::from_ptr(text).to_string_lossy().into_owned());
        }
        // The scene belongs to an importer, which gives up the scene before the importer is deleted.
        let private: *mut ScenePrivate = (*scene).mPrivate;
        let importer = std::mem::replace(&mut (*private).importer, std::ptr::null_mut());
        calls::orphaned_scene()?(importer);
        calls::destruct_importer()?(importer);
        crate::heap::delete(importer);
        Ok(scene)
    }
}
