//! Property stores: settings of an import, by name.

use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_void};

/// `AI_CONFIG_IMPORT_NO_SKELETON_MESHES`: not 0 to leave the skeleton without a mesh.
const NO_SKELETON_MESHES: &CStr = c"IMPORT_NO_SKELETON_MESHES";

/// What an import is told beside its flags. Of all properties that Assimp knows, those that change how motion is read.
#[derive(Default)]
pub(crate) struct Properties {
    integers: HashMap<Box<CStr>, i32>,
}

impl Properties {
    pub(crate) fn no_skeleton_meshes(&self) -> bool {
        self.integers.get(NO_SKELETON_MESHES).is_some_and(|&value| value != 0)
    }

    /// Whether it was set before.
    pub(crate) fn set_integer(&mut self, name: &CStr, value: i32) -> bool {
        self.integers.insert(name.into(), value).is_some()
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
    // SAFETY: the caller hands over NULL or a store that only this call uses.
    let Some(store) = (unsafe { store.as_mut() }) else {
        return;
    };
    if !name.is_null() {
        // SAFETY: the name is not NULL, so it ends with a zero byte.
        store.set_integer(unsafe { CStr::from_ptr(name) }, value);
    }
}

/// Accepted without effect: no float property affects how motion is read.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiSetImportPropertyFloat(_store: *mut Properties, _name: *const c_char, _value: f32) {}

/// Accepted without effect: no text property affects how motion is read.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiSetImportPropertyString(
    _store: *mut Properties,
    _name: *const c_char,
    _value: *const c_void,
) {
}

/// Accepted without effect: no matrix property affects how motion is read.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiSetImportPropertyMatrix(
    _store: *mut Properties,
    _name: *const c_char,
    _value: *const c_void,
) {
}
