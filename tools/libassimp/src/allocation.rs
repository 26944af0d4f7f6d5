//! `Assimp::Intern::AllocateFromAssimpHeap`: the `new` and `delete` of Assimp's classes, which call the operators of
//! C++.

use std::ffi::c_void;

use crate::heap;

/// `operator new(size_t)`
#[unsafe(no_mangle)]
pub(crate) extern "C" fn _ZN6Assimp6Intern22AllocateFromAssimpHeapnwEm(size: usize) -> *mut c_void {
    heap::allocate(size)
}

/// `operator new(size_t, const std::nothrow_t &)`
#[unsafe(no_mangle)]
pub(crate) extern "C" fn _ZN6Assimp6Intern22AllocateFromAssimpHeapnwEmRKSt9nothrow_t(
    size: usize,
    _nothrow: *const c_void,
) -> *mut c_void {
    heap::allocate(size)
}

/// `operator new[](size_t)`
#[unsafe(no_mangle)]
pub(crate) extern "C" fn _ZN6Assimp6Intern22AllocateFromAssimpHeapnaEm(size: usize) -> *mut c_void {
    heap::allocate_array(size)
}

/// `operator new[](size_t, const std::nothrow_t &)`
#[unsafe(no_mangle)]
pub(crate) extern "C" fn _ZN6Assimp6Intern22AllocateFromAssimpHeapnaEmRKSt9nothrow_t(
    size: usize,
    _nothrow: *const c_void,
) -> *mut c_void {
    heap::allocate_array(size)
}

/// `operator delete(void *)`
///
/// # Safety
/// `block` is NULL or comes from `new`, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp6Intern22AllocateFromAssimpHeapdlEPv(block: *mut c_void) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { heap::delete(block) };
}

/// `operator delete[](void *)`
///
/// # Safety
/// `block` is NULL or comes from `new[]`, and is not used any more.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn _ZN6Assimp6Intern22AllocateFromAssimpHeapdaEPv(block: *mut c_void) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { heap::delete_array(block) };
}
