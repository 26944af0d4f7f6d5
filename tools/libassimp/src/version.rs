//! The reported version: the version of the Assimp whose interface this library has.

use std::ffi::{CStr, c_char};

const LEGAL: &CStr = c"mocap, under the MIT or the Apache 2.0 licence, in the shape of Assimp's interface";

pub(crate) const MAJOR: u32 = 5;
pub(crate) const MINOR: u32 = 2;

/// The patch version that Assimp 5.2.5 reports.
const PATCH: u32 = 4;

/// 5.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetVersionMajor() -> u32 {
    MAJOR
}

/// 2.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetVersionMinor() -> u32 {
    MINOR
}

/// 4.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetVersionPatch() -> u32 {
    PATCH
}

/// 0: no revision of Assimp's own source.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetVersionRevision() -> u32 {
    0
}

/// The branch of Assimp's source that was built: none.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetBranchName() -> *const c_char {
    c"".as_ptr()
}

/// `ASSIMP_CFLAGS_SHARED`: this is a shared library.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetCompileFlags() -> u32 {
    1
}

/// The licence text of this library.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetLegalString() -> *const c_char {
    LEGAL.as_ptr()
}
