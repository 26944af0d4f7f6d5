//! The classes behind `std::shared_ptr` that Assimp exports because it uses them.
//!
//! The classes belong to the C++ library. So another library of the program may use these tables for its own pointers:
//! they work without the system's Assimp. Objects have the layout of the GNU C++ library: a table, two counts, the
//! pointer.

use std::ffi::{CStr, c_char, c_void};

use super::objects::{
    _ZTISt15_Sp_counted_ptrIPN6Assimp8IOStreamELN9__gnu_cxx12_Lock_policyE2EE,
    _ZTISt15_Sp_counted_ptrIPN6Assimp8IOSystemELN9__gnu_cxx12_Lock_policyE2EE,
    _ZTISt15_Sp_counted_ptrIPN6Assimp15DefaultIOSystemELN9__gnu_cxx12_Lock_policyE2EE,
    _ZTISt15_Sp_counted_ptrIPSt6vectorIfSaIfEELN9__gnu_cxx12_Lock_policyE2EE,
    _ZTISt15_Sp_counted_ptrIPSt6vectorIlSaIlEELN9__gnu_cxx12_Lock_policyE2EE,
    _ZTISt19_Sp_counted_deleterIPhSt14default_deleteIA_hESaIvELN9__gnu_cxx12_Lock_policyE2EE, Word,
};
use crate::heap::{delete, delete_array};
use crate::virtual_call::delete_object;

#[repr(C)]
struct Counted {
    table: *const c_void,
    counts: [i32; 2],
    pointer: *mut c_void,
}

/// The name of the class, by which the C++ library compares types, follows its table.
#[repr(C)]
struct TypeInfo {
    table: *const c_void,
    name: *const c_char,
}

type Table = [Word; 7];

const fn table(
    info: &'static [Word; 3],
    dispose: unsafe extern "C" fn(*mut Counted),
    deleter: unsafe extern "C" fn(*mut Counted, *const TypeInfo) -> *mut c_void,
) -> Table {
    [
        Word::NULL,
        Word::data(info),
        Word::code(destruct as *const c_void),
        Word::code(delete_counted as *const c_void),
        Word::code(dispose as *const c_void),
        Word::code(delete_counted as *const c_void),
        Word::code(deleter as *const c_void),
    ]
}

#[unsafe(no_mangle)]
static _ZTVSt15_Sp_counted_ptrIPN6Assimp15DefaultIOSystemELN9__gnu_cxx12_Lock_policyE2EE: Table = table(
    &_ZTISt15_Sp_counted_ptrIPN6Assimp15DefaultIOSystemELN9__gnu_cxx12_Lock_policyE2EE,
    dispose_object,
    no_deleter,
);

#[unsafe(no_mangle)]
static _ZTVSt15_Sp_counted_ptrIPN6Assimp8IOStreamELN9__gnu_cxx12_Lock_policyE2EE: Table = table(
    &_ZTISt15_Sp_counted_ptrIPN6Assimp8IOStreamELN9__gnu_cxx12_Lock_policyE2EE,
    dispose_object,
    no_deleter,
);

#[unsafe(no_mangle)]
static _ZTVSt15_Sp_counted_ptrIPN6Assimp8IOSystemELN9__gnu_cxx12_Lock_policyE2EE: Table = table(
    &_ZTISt15_Sp_counted_ptrIPN6Assimp8IOSystemELN9__gnu_cxx12_Lock_policyE2EE,
    dispose_object,
    no_deleter,
);

#[unsafe(no_mangle)]
static _ZTVSt15_Sp_counted_ptrIPSt6vectorIfSaIfEELN9__gnu_cxx12_Lock_policyE2EE: Table = table(
    &_ZTISt15_Sp_counted_ptrIPSt6vectorIfSaIfEELN9__gnu_cxx12_Lock_policyE2EE,
    dispose_vector,
    no_deleter,
);

#[unsafe(no_mangle)]
static _ZTVSt15_Sp_counted_ptrIPSt6vectorIlSaIlEELN9__gnu_cxx12_Lock_policyE2EE: Table = table(
    &_ZTISt15_Sp_counted_ptrIPSt6vectorIlSaIlEELN9__gnu_cxx12_Lock_policyE2EE,
    dispose_vector,
    no_deleter,
);

#[unsafe(no_mangle)]
static _ZTVSt19_Sp_counted_deleterIPhSt14default_deleteIA_hESaIvELN9__gnu_cxx12_Lock_policyE2EE: Table = table(
    &_ZTISt19_Sp_counted_deleterIPhSt14default_deleteIA_hESaIvELN9__gnu_cxx12_Lock_policyE2EE,
    dispose_bytes,
    deleter_of_bytes,
);

unsafe extern "C" fn destruct(_this: *mut Counted) {}

/// # Safety
/// `this` comes from `new`, and is not used any more; the same for the functions below.
unsafe extern "C" fn delete_counted(this: *mut Counted) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { delete(this) };
}

/// # Safety
/// `this` holds NULL or an object with a virtual destructor.
unsafe extern "C" fn dispose_object(this: *mut Counted) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { delete_object((*this).pointer) };
}

/// # Safety
/// `this` holds NULL or a `std::vector` of numbers, which begins with the pointer to them.
unsafe extern "C" fn dispose_vector(this: *mut Counted) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe {
        let vector = (*this).pointer.cast::<*mut c_void>();
        if !vector.is_null() {
            delete(*vector);
            delete(vector);
        }
    }
}

/// # Safety
/// `this` holds NULL or an array of bytes.
unsafe extern "C" fn dispose_bytes(this: *mut Counted) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { delete_array((*this).pointer) };
}

unsafe extern "C" fn no_deleter(_this: *mut Counted, _asked: *const TypeInfo) -> *mut c_void {
    std::ptr::null_mut()
}

/// # Safety
/// `asked` is a type info.
unsafe extern "C" fn deleter_of_bytes(this: *mut Counted, asked: *const TypeInfo) -> *mut c_void {
    // SAFETY: the name of a type ends with a zero byte.
    let name = unsafe { CStr::from_ptr((*asked).name) };
    if name == c"St14default_deleteIA_hE" {
        // The deleter has no size, and shares the address of the pointer.
        // SAFETY: the field belongs to the object.
        unsafe { (&raw mut (*this).pointer).cast() }
    } else {
        std::ptr::null_mut()
    }
}
