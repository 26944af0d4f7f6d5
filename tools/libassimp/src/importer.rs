//! `Assimp::Importer`, the class with which C++ programs import files. It keeps one scene, and frees the scene with
//! itself.
//!
//! The class has one field, a pointer to its state, and no virtual function. The compiler makes the symbol names from
//! the methods: `C1` and `C2` are the constructor, `D1` and `D2` the destructor. A loader of the program receives the
//! importer of the system's Assimp, to which its calls go.

mod handlers;
mod properties;
mod registry;
mod state;

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;

use self::state::methods;
pub(crate) use self::state::{Importer, State, state};
use crate::abi::{aiMemoryInfo, aiScene};
use crate::border::{bytes, text};
use crate::request::Input;
use crate::system_importer::Steps;
use crate::{flags, heap, memory_info};

/// `Importer()`
///
/// # Safety
/// `importer` points to an importer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterC1Ev(importer: *mut Importer) {
    let state = Box::into_raw(Box::new(State::new()));
    // SAFETY: the caller passes a valid pointer to an importer.
    unsafe { importer.write(Importer { state }) };
}

/// `Importer()`
///
/// # Safety
/// As [`_ZN6Assimp8ImporterC1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterC2Ev(importer: *mut Importer) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { _ZN6Assimp8ImporterC1Ev(importer) };
}

methods! {
    /// `~Importer()`
    fn _ZN6Assimp8ImporterD1Ev(state) -> () | () => {
        // SAFETY: the constructor made the state, and the caller gives it up.
        drop(unsafe { Box::from_raw(state) });
    }

    /// `~Importer()`
    fn _ZN6Assimp8ImporterD2Ev(state) -> () | () => {
        // SAFETY: the constructor made the state, and the caller gives it up.
        drop(unsafe { Box::from_raw(state) });
    }

    /// `const aiScene *ReadFile(const char *path, unsigned flags)`. The scene before is freed.
    fn _ZN6Assimp8Importer8ReadFileEPKcj(state, path: *const c_char, flags: u32) -> *const aiScene | ptr::null() => {
        // SAFETY: the caller passes NULL or a string, and the handlers are of their classes.
        unsafe {
            match text(path, "the path") {
                Ok(path) => state.read(Input::File(path), flags),
                Err(_) => state.read(Input::File(c""), flags),
            }
        }
    }

    /// `const aiScene *ReadFileFromMemory(const void *bytes, size_t size, unsigned flags, const char *hint)`. The scene
    /// before is freed.
    fn _ZN6Assimp8Importer18ReadFileFromMemoryEPKvmjPKc(
        state, first: *const c_void, size: usize, flags: u32, hint: *const c_char
    ) -> *const aiScene | ptr::null() => {
        // SAFETY: the caller passes `size` bytes, and NULL or a string.
        unsafe {
            let hint = text(hint, "the hint").unwrap_or_default();
            state.read(Input::Memory(bytes(first.cast(), size), hint), flags)
        }
    }

    /// `const aiScene *GetScene() const`
    fn _ZNK6Assimp8Importer8GetSceneEv(state) -> *const aiScene | ptr::null() => state.scene

    /// `aiScene *GetOrphanedScene()`: the scene, which the program owns from now on.
    fn _ZN6Assimp8Importer16GetOrphanedSceneEv(state) -> *mut aiScene | ptr::null_mut() => {
        state.failure = CString::default();
        std::mem::replace(&mut state.scene, ptr::null_mut())
    }

    /// `void FreeScene()`
    fn _ZN6Assimp8Importer9FreeSceneEv(state) -> () | () => state.free_scene()

    /// `const char *GetErrorString() const`: the reason why the last import failed, or an empty text. It is valid until
    /// the next import.
    fn _ZNK6Assimp8Importer14GetErrorStringEv(state) -> *const c_char | c"".as_ptr() => state.failure.as_ptr()

    /// `const std::exception_ptr &GetException() const`: no exception, because errors only have a text.
    fn _ZNK6Assimp8Importer12GetExceptionEv(state) -> *const c_void | ptr::null() => {
        (&raw const state.exception).cast()
    }

    /// `const aiScene *ApplyPostProcessing(unsigned flags)`
    fn _ZN6Assimp8Importer19ApplyPostProcessingEj(state, flags: u32) -> *const aiScene | ptr::null() => {
        match flags {
            0 => state.scene,
            // SAFETY: no process.
            _ => unsafe { state.run(Steps::Flags(flags)) },
        }
    }

    /// `const aiScene *ApplyCustomizedPostProcessing(BaseProcess *process, bool validate)`
    fn _ZN6Assimp8Importer29ApplyCustomizedPostProcessingEPNS_11BaseProcessEb(
        state, process: *mut c_void, validate: bool
    ) -> *const aiScene | ptr::null() => {
        match process.is_null() {
            true => state.scene,
            // SAFETY: the caller passes a process.
            false => unsafe { state.run(Steps::Process(process, validate)) },
        }
    }

    /// `bool ValidateFlags(unsigned flags) const`: whether all of these flags can be applied.
    fn _ZNK6Assimp8Importer13ValidateFlagsEj(state, flags: u32) -> bool | false => {
        flags::validate(flags) && (flags::foreign(flags).is_none() || registry::validate(state, flags))
    }

    /// `void GetMemoryRequirements(aiMemoryInfo &info) const`
    fn _ZNK6Assimp8Importer21GetMemoryRequirementsER12aiMemoryInfo(state, info: *mut aiMemoryInfo) -> () | () => {
        // SAFETY: the caller passes the place of the numbers, and the scene is NULL or whole.
        unsafe { info.write(memory_info::of(state.scene)) }
    }
}

/// An importer on the heap of C++, for the functions of the C interface.
pub(crate) fn new() -> *mut Importer {
    heap::new(Importer {
        state: Box::into_raw(Box::new(State::new())),
    })
}

/// Destructs and frees an importer.
///
/// # Safety
/// `importer` comes from [`new`], or from the `new` of a program or of the system's Assimp, and is not used any more.
pub(crate) unsafe fn delete(importer: *mut Importer) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe {
        _ZN6Assimp8ImporterD1Ev(importer);
        heap::delete(importer);
    }
}

/// The reason why the last import of `state` failed, as a string.
pub(crate) fn failure(state: &State) -> &CStr {
    &state.failure
}
