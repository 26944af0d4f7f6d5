//! `Assimp::Importer`, the class that C++ programs import with. It keeps one scene, and frees it with itself.
//!
//! The class has one field, a pointer to what stands behind it, and no virtual function. The names are those that the
//! compiler makes of its methods: `C1` and `C2` are the constructor, `D1` and `D2` the destructor.

use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr;

use crate::abi::{aiScene, aiString};
use crate::border::caught;
use crate::flags;
use crate::import::{aiGetExtensionList, aiIsExtensionSupported, import_file, import_memory};
use crate::properties::Properties;
use crate::to_assimp::Imported;

/// The layout of the class in the program's memory.
#[repr(C)]
pub(crate) struct Importer {
    state: *mut State,
}

/// What stands behind an importer.
struct State {
    properties: Properties,
    scene: *const aiScene,
    failure: CString,
}

impl State {
    fn keep(&mut self, result: Result<*const aiScene, CString>) -> *const aiScene {
        (self.scene, self.failure) = match result {
            Ok(scene) => (scene, CString::default()),
            Err(failure) => (ptr::null(), failure),
        };
        self.scene
    }

    fn free_scene(&mut self) {
        // SAFETY: the scene is NULL or comes from an import of this importer, which gives it up.
        unsafe { Imported::release(self.scene) };
        self.scene = ptr::null();
    }
}

impl Drop for State {
    fn drop(&mut self) {
        self.free_scene();
    }
}

/// The state of an importer.
///
/// # Safety
/// `importer` was constructed and not destructed, and no other thread uses it.
unsafe fn state<'a>(importer: *const Importer) -> &'a mut State {
    // SAFETY: the constructor has put the pointer there, and only the destructor takes it away.
    unsafe { &mut *(*importer).state }
}

/// `Importer()`
///
/// # Safety
/// `importer` is the place of an importer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterC1Ev(importer: *mut Importer) {
    let state = Box::into_raw(Box::new(State {
        properties: Properties::default(),
        scene: ptr::null(),
        failure: CString::default(),
    }));
    // SAFETY: the caller hands over the place of an importer.
    unsafe { importer.write(Importer { state }) };
}

/// `Importer()`
///
/// # Safety
/// As [`_ZN6Assimp8ImporterC1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterC2Ev(importer: *mut Importer) {
    // SAFETY: the same promise.
    unsafe { _ZN6Assimp8ImporterC1Ev(importer) };
}

/// `~Importer()`
///
/// # Safety
/// `importer` is an importer, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterD1Ev(importer: *mut Importer) {
    // SAFETY: the constructor made the state, and the caller gives it up.
    drop(unsafe { Box::from_raw((*importer).state) });
}

/// `~Importer()`
///
/// # Safety
/// As [`_ZN6Assimp8ImporterD1Ev`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8ImporterD2Ev(importer: *mut Importer) {
    // SAFETY: the same promise.
    unsafe { _ZN6Assimp8ImporterD1Ev(importer) };
}

/// `const aiScene *ReadFile(const char *path, unsigned flags)`. The scene before is freed.
///
/// # Safety
/// `importer` is an importer, and `path` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8Importer8ReadFileEPKcj(
    importer: *mut Importer,
    path: *const c_char,
    flags: u32,
) -> *const aiScene {
    // SAFETY: the caller hands over an importer.
    let state = unsafe { state(importer) };
    state.free_scene();
    let properties = Some(&state.properties);
    // SAFETY: the caller hands over NULL or a text.
    let result = caught(|| unsafe { import_file(path, flags, properties) });
    state.keep(result)
}

/// `const aiScene *ReadFileFromMemory(const void *bytes, size_t size, unsigned flags, const char *hint)`. The scene
/// before is freed.
///
/// # Safety
/// `importer` is an importer, `bytes` points to `size` bytes, and `hint` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8Importer18ReadFileFromMemoryEPKvmjPKc(
    importer: *mut Importer,
    bytes: *const c_void,
    size: usize,
    flags: u32,
    hint: *const c_char,
) -> *const aiScene {
    // SAFETY: the caller hands over an importer.
    let state = unsafe { state(importer) };
    state.free_scene();
    let properties = Some(&state.properties);
    // SAFETY: the caller hands over `size` bytes, and NULL or a text.
    let result = caught(|| unsafe { import_memory(bytes.cast(), size, flags, hint, properties) });
    state.keep(result)
}

/// `const aiScene *GetScene() const`
///
/// # Safety
/// `importer` is an importer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZNK6Assimp8Importer8GetSceneEv(importer: *const Importer) -> *const aiScene {
    // SAFETY: the caller hands over an importer.
    unsafe { state(importer) }.scene
}

/// `void FreeScene()`
///
/// # Safety
/// `importer` is an importer, and its scene is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8Importer9FreeSceneEv(importer: *mut Importer) {
    // SAFETY: the caller hands over an importer.
    unsafe { state(importer) }.free_scene();
}

/// `const char *GetErrorString() const`: why the last import failed, or an empty text. It is valid until the next.
///
/// # Safety
/// `importer` is an importer.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZNK6Assimp8Importer14GetErrorStringEv(importer: *const Importer) -> *const c_char {
    // SAFETY: the caller hands over an importer.
    unsafe { state(importer) }.failure.as_ptr()
}

/// `bool SetPropertyInteger(const char *name, int value)`: whether it was set before.
///
/// # Safety
/// `importer` is an importer, and `name` ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp8Importer18SetPropertyIntegerEPKci(
    importer: *mut Importer,
    name: *const c_char,
    value: i32,
) -> bool {
    // SAFETY: the caller hands over an importer and a text.
    let (state, name) = unsafe { (state(importer), CStr::from_ptr(name)) };
    state.properties.set_integer(name, value)
}

/// `bool SetPropertyFloat(const char *name, float value)`: taken, as no number with a point says how motion is read.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn _ZN6Assimp8Importer16SetPropertyFloatEPKcf(
    _importer: *mut Importer,
    _name: *const c_char,
    _value: f32,
) -> bool {
    false
}

/// `bool ValidateFlags(unsigned flags) const`: whether all of these flags can be honoured.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn _ZNK6Assimp8Importer13ValidateFlagsEj(_importer: *const Importer, flags: u32) -> bool {
    flags::check(flags).is_ok()
}

/// `bool IsExtensionSupported(const char *extension) const`
///
/// # Safety
/// `extension` is NULL or ends with a zero byte.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZNK6Assimp8Importer20IsExtensionSupportedEPKc(
    _importer: *const Importer,
    extension: *const c_char,
) -> bool {
    // SAFETY: the same promise.
    unsafe { aiIsExtensionSupported(extension) == 1 }
}

/// `void GetExtensionList(aiString &list) const`
///
/// # Safety
/// `list` is the place of an `aiString`.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZNK6Assimp8Importer16GetExtensionListER8aiString(
    _importer: *const Importer,
    list: *mut aiString,
) {
    // SAFETY: the same promise.
    unsafe { aiGetExtensionList(list) };
}
