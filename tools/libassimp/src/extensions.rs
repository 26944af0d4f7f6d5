//! The extensions of the files that this library or the system's Assimp reads.

use std::ffi::c_char;

use mocap::FormatInfo;

use crate::abi::aiString;
use crate::border::{guard, text};
use crate::system::calls;

/// 1 if this library or the system's Assimp reads files with this extension, else 0. The dot may be missing.
///
/// # Safety
/// `extension` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiIsExtensionSupported(extension: *const c_char) -> i32 {
    guard(0, || {
        // SAFETY: the caller passes NULL or a string.
        let extension = unsafe { text(extension, "the extension") }?;
        let name = extension.to_string_lossy();
        let name = name.trim_start_matches(['*', '.']);
        if extensions().any(|known| known.eq_ignore_ascii_case(name)) {
            return Ok(1);
        }
        let asked = calls::is_extension_supported();
        // SAFETY: a string.
        Ok(asked.map_or(0, |ask| unsafe { ask(extension.as_ptr()) }))
    })
}

/// The extensions that this library or the system's Assimp reads, in the form `*.bvh;*.asf`.
///
/// # Safety
/// `list` is NULL or the place of an `aiString`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn aiGetExtensionList(list: *mut aiString) {
    if list.is_null() {
        return;
    }
    let mut theirs = aiString::new("");
    if let Ok(get) = calls::extension_list() {
        // SAFETY: the place of an `aiString`.
        unsafe { get(&raw mut theirs) };
    }
    let theirs = theirs.to_text();
    let mut patterns: Vec<String> = theirs
        .split(';')
        .filter(|it| !it.is_empty())
        .map(str::to_owned)
        .collect();
    for extension in extensions() {
        let pattern = format!("*.{extension}");
        if !patterns.contains(&pattern) {
            patterns.push(pattern);
        }
    }
    // SAFETY: the caller passes a valid pointer to an `aiString`.
    unsafe { list.write(aiString::new(&patterns.join(";"))) };
}

fn extensions() -> impl Iterator<Item = &'static str> {
    FormatInfo::ALL
        .iter()
        .flat_map(|format| format.extensions.iter().copied())
}
