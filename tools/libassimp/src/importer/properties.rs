//! The importer's properties, by name. A property that was never set has the caller's default.

use std::ffi::{CStr, c_char, c_void};

use super::state::methods;
use crate::abi::aiMatrix4x4;
use crate::cpp_string::StdString;

/// # Safety
/// `name` ends with a zero byte.
unsafe fn named(name: *const c_char) -> Box<CStr> {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { CStr::from_ptr(name) }.into()
}

methods! {
    /// `bool SetPropertyInteger(const char *name, int value)`: whether it was set before.
    fn _ZN6Assimp8Importer18SetPropertyIntegerEPKci(state, name: *const c_char, value: i32) -> bool | false => {
        // SAFETY: the caller passes a string.
        state.properties.integers.insert(unsafe { named(name) }, value).is_some()
    }

    /// `bool SetPropertyFloat(const char *name, float value)`: whether it was set before.
    fn _ZN6Assimp8Importer16SetPropertyFloatEPKcf(state, name: *const c_char, value: f32) -> bool | false => {
        // SAFETY: the caller passes a string.
        state.properties.floats.insert(unsafe { named(name) }, value).is_some()
    }

    /// `bool SetPropertyString(const char *name, const std::string &value)`: whether it was set before.
    fn _ZN6Assimp8Importer17SetPropertyStringEPKcRKNSt7__cxx1112basic_stringIcSt11char_traitsIcESaIcEEE(
        state, name: *const c_char, value: *const StdString
    ) -> bool | false => {
        // SAFETY: the caller passes a string and a string.
        let (name, value) = unsafe { (named(name), (*value).to_c_string()) };
        state.properties.strings.insert(name, value).is_some()
    }

    /// `bool SetPropertyMatrix(const char *name, const aiMatrix4x4 &value)`: whether it was set before.
    fn _ZN6Assimp8Importer17SetPropertyMatrixEPKcRK12aiMatrix4x4tIfE(
        state, name: *const c_char, value: *const aiMatrix4x4
    ) -> bool | false => {
        // SAFETY: the caller passes a string and a matrix.
        let (name, value) = unsafe { (named(name), *value) };
        state.properties.matrices.insert(name, value).is_some()
    }

    /// `bool SetPropertyPointer(const char *name, void *value)`: whether it was set before.
    fn _ZN6Assimp8Importer18SetPropertyPointerEPKcPv(
        state, name: *const c_char, value: *mut c_void
    ) -> bool | false => {
        // SAFETY: the caller passes a string.
        state.properties.pointers.insert(unsafe { named(name) }, value).is_some()
    }

    /// `int GetPropertyInteger(const char *name, int otherwise) const`
    fn _ZNK6Assimp8Importer18GetPropertyIntegerEPKci(
        state, name: *const c_char, otherwise: i32
    ) -> i32 | otherwise => {
        // SAFETY: the caller passes a string.
        state.properties.integers.get(&unsafe { named(name) }).copied().unwrap_or(otherwise)
    }

    /// `float GetPropertyFloat(const char *name, float otherwise) const`
    fn _ZNK6Assimp8Importer16GetPropertyFloatEPKcf(
        state, name: *const c_char, otherwise: f32
    ) -> f32 | otherwise => {
        // SAFETY: the caller passes a string.
        state.properties.floats.get(&unsafe { named(name) }).copied().unwrap_or(otherwise)
    }

    /// `void *GetPropertyPointer(const char *name, void *otherwise) const`
    fn _ZNK6Assimp8Importer18GetPropertyPointerEPKcPv(
        state, name: *const c_char, otherwise: *mut c_void
    ) -> *mut c_void | otherwise => {
        // SAFETY: the caller passes a string.
        state.properties.pointers.get(&unsafe { named(name) }).copied().unwrap_or(otherwise)
    }
}
