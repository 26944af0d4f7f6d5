//! Property stores: settings of an import, by name.

use std::collections::BTreeMap;
use std::ffi::{CStr, c_char, c_void};

use crate::abi::{aiMatrix4x4, aiString};

/// `AI_CONFIG_IMPORT_NO_SKELETON_MESHES`: not 0 to leave the skeleton without a mesh.
const NO_SKELETON_MESHES: &CStr = c"IMPORT_NO_SKELETON_MESHES";

type Name = Box<CStr>;

/// The settings of an import besides its flags. The store keeps all of them for the system's Assimp; this library uses
/// the settings that change how motion is read.
#[derive(Clone, Default)]
pub(crate) struct Properties {
    pub(crate) integers: BTreeMap<Name, i32>,
    pub(crate) floats: BTreeMap<Name, f32>,
    pub(crate) strings: BTreeMap<Name, Box<CStr>>,
    pub(crate) matrices: BTreeMap<Name, aiMatrix4x4>,
    pub(crate) pointers: BTreeMap<Name, *mut c_void>,
}

impl Properties {
    pub(crate) fn no_skeleton_meshes(&self) -> bool {
        self.integers.get(NO_SKELETON_MESHES).is_some_and(|&value| value != 0)
    }

    /// Whether a property of this name is set to a number.
    pub(crate) fn has_number(&self, name: &CStr) -> bool {
        self.integers.contains_key(name) || self.floats.contains_key(name)
    }
}

/// A new store. [`aiReleasePropertyStore`] frees it.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiCreatePropertyStore() -> *mut Properties {
    Box::into_raw(Box::default())
}

/// Frees a store.
///
/// # Safety
/// `store` is NULL or comes from [`aiCreatePropertyStore`], and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiReleasePropertyStore(store: *mut Properties) {
    if !store.is_null() {
        // SAFETY: `aiCreatePropertyStore` made it, and the caller gives it up.
        drop(unsafe { Box::from_raw(store) });
    }
}

/// Sets an integer.
///
/// # Safety
/// `store` is NULL or a store, and `name` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiSetImportPropertyInteger(store: *mut Properties, name: *const c_char, value: i32) {
    // SAFETY: the caller's promise in `# Safety`.
    if let Some((store, name)) = unsafe { store_and_name(store, name) } {
        store.integers.insert(name, value);
    }
}

/// Sets a floating-point number.
///
/// # Safety
/// `store` is NULL or a store, and `name` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiSetImportPropertyFloat(store: *mut Properties, name: *const c_char, value: f32) {
    // SAFETY: the caller's promise in `# Safety`.
    if let Some((store, name)) = unsafe { store_and_name(store, name) } {
        store.floats.insert(name, value);
    }
}

/// Sets a string.
///
/// # Safety
/// `store` is NULL or a store, `name` is NULL or ends with a zero byte, and `value` is NULL or an `aiString`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiSetImportPropertyString(
    store: *mut Properties,
    name: *const c_char,
    value: *const aiString,
) {
    // SAFETY: the caller's promise in `# Safety`; an `aiString` ends with a zero byte.
    if let Some(((store, name), value)) = unsafe { store_and_name(store, name).zip(value.as_ref()) } {
        let value = CStr::from_bytes_until_nul(&value.data).unwrap_or_default();
        store.strings.insert(name, value.into());
    }
}

/// Sets a matrix.
///
/// # Safety
/// `store` is NULL or a store, `name` is NULL or ends with a zero byte, and `value` is NULL or a matrix.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiSetImportPropertyMatrix(
    store: *mut Properties,
    name: *const c_char,
    value: *const aiMatrix4x4,
) {
    // SAFETY: the caller's promise in `# Safety`.
    if let Some(((store, name), value)) = unsafe { store_and_name(store, name).zip(value.as_ref()) } {
        store.matrices.insert(name, *value);
    }
}

/// # Safety
/// `store` is NULL or a store that only this call uses, and `name` is NULL or ends with a zero byte.
unsafe fn store_and_name<'a>(store: *mut Properties, name: *const c_char) -> Option<(&'a mut Properties, Name)> {
    // SAFETY: the caller's promise in `# Safety`.
    let store = unsafe { store.as_mut() }?;
    if name.is_null() {
        return None;
    }
    // SAFETY: the name is not NULL. The caller promises that it ends with a zero byte.
    Some((store, unsafe { CStr::from_ptr(name) }.into()))
}
