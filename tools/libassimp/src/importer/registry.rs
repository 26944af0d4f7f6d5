//! The program's loaders and steps, and the built-in ones. The system's Assimp provides all of them.

use std::ffi::{CStr, c_char, c_void};
use std::ptr;

use super::state::{State, methods};
use crate::abi::{AI_FAILURE, AI_SUCCESS, aiImporterDesc, aiReturn, aiString};
use crate::extensions::{aiGetExtensionList, aiIsExtensionSupported};
use crate::system::calls;

/// Defines methods of the system's importer, and their values without the system's Assimp.
macro_rules! system_methods {
    ($(
        $(#[$attribute:meta])*
        fn $symbol:ident($($name:ident: $type:ty),*) -> $result:ty | $otherwise:expr
    )*) => {
        methods! {
            $(
                $(#[$attribute])*
                fn $symbol(state $(, $name: $type)*) -> $result | $otherwise => {
                    type Inner = unsafe extern "C" fn(*mut c_void $(, $type)*) -> $result;
                    const NAME: &str = concat!(stringify!($symbol), "\0");
                    let symbol = CStr::from_bytes_with_nul(NAME.as_bytes()).unwrap_or_default();
                    // SAFETY: the method of the headers.
                    match (state.system(), unsafe { crate::system::function::<Inner>(symbol) }) {
                        // SAFETY: an importer, and what the caller passes.
                        (Ok(system), Ok(method)) => unsafe { method(system.object() $(, $name)*) },
                        _ => $otherwise,
                    }
                }
            )*
        }
    };
}

system_methods! {
    /// `size_t GetImporterCount() const`
    fn _ZNK6Assimp8Importer16GetImporterCountEv() -> usize | 0

    /// `const aiImporterDesc *GetImporterInfo(size_t index) const`
    fn _ZNK6Assimp8Importer15GetImporterInfoEm(index: usize) -> *const aiImporterDesc | ptr::null()

    /// `BaseImporter *GetImporter(size_t index) const`
    fn _ZNK6Assimp8Importer11GetImporterEm(index: usize) -> *mut c_void | ptr::null_mut()

    /// `BaseImporter *GetImporter(const char *extension) const`
    fn _ZNK6Assimp8Importer11GetImporterEPKc(extension: *const c_char) -> *mut c_void | ptr::null_mut()

    /// `size_t GetImporterIndex(const char *extension) const`
    fn _ZNK6Assimp8Importer16GetImporterIndexEPKc(extension: *const c_char) -> usize | usize::MAX

    /// `void SetExtraVerbose(bool verbose)`
    fn _ZN6Assimp8Importer15SetExtraVerboseEb(verbose: bool) -> () | ()

    /// `aiReturn UnregisterLoader(BaseImporter *loader)`
    fn _ZN6Assimp8Importer16UnregisterLoaderEPNS_12BaseImporterE(loader: *mut c_void) -> aiReturn | AI_FAILURE

    /// `aiReturn UnregisterPPStep(BaseProcess *step)`
    fn _ZN6Assimp8Importer16UnregisterPPStepEPNS_11BaseProcessE(step: *mut c_void) -> aiReturn | AI_FAILURE
}

methods! {
    /// `aiReturn RegisterLoader(BaseImporter *loader)`: from now on the system's Assimp reads every file.
    fn _ZN6Assimp8Importer14RegisterLoaderEPNS_12BaseImporterE(
        state, loader: *mut c_void
    ) -> aiReturn | AI_FAILURE => register(state, calls::register_loader(), loader)

    /// `aiReturn RegisterPPStep(BaseProcess *step)`: from now on the system's Assimp reads every file.
    fn _ZN6Assimp8Importer14RegisterPPStepEPNS_11BaseProcessE(
        state, step: *mut c_void
    ) -> aiReturn | AI_FAILURE => register(state, calls::register_process(), step)

    /// `bool IsExtensionSupported(const char *extension) const`
    fn _ZNK6Assimp8Importer20IsExtensionSupportedEPKc(state, extension: *const c_char) -> bool | false => {
        let _ = state;
        // SAFETY: the caller passes NULL or a string.
        unsafe { aiIsExtensionSupported(extension) == 1 }
    }

    /// `void GetExtensionList(aiString &list) const`
    fn _ZNK6Assimp8Importer16GetExtensionListER8aiString(state, list: *mut aiString) -> () | () => {
        let _ = state;
        // SAFETY: the caller passes a valid pointer to an `aiString`.
        unsafe { aiGetExtensionList(list) }
    }
}

/// A method that takes a loader or a step.
type Register = unsafe extern "C" fn(*mut c_void, *mut c_void) -> aiReturn;

fn register(state: &mut State, method: Result<Register, String>, part: *mut c_void) -> aiReturn {
    let (Ok(method), Ok(system)) = (method, state.system()) else {
        return AI_FAILURE;
    };
    // SAFETY: an importer, and what the caller passes.
    let result = unsafe { method(system.object(), part) };
    state.has_registered |= result == AI_SUCCESS;
    result
}

/// A method that returns a handler.
type GetHandler = unsafe extern "C" fn(*mut c_void) -> *mut c_void;

/// A handler that the importer of the system's Assimp has; NULL if there is none.
pub(super) fn handler(state: &mut State, method: Result<GetHandler, String>) -> *mut c_void {
    match (state.system(), method) {
        // SAFETY: an importer.
        (Ok(system), Ok(method)) => unsafe { method(system.object()) },
        _ => ptr::null_mut(),
    }
}

/// Whether the system's Assimp has all of these steps.
pub(super) fn validate(state: &mut State, flags: u32) -> bool {
    match (state.system(), calls::validate_flags()) {
        // SAFETY: an importer.
        (Ok(system), Ok(method)) => unsafe { method(system.object(), flags) },
        _ => false,
    }
}
