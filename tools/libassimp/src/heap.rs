//! The heap of C++. As with Assimp's own library, a program may `delete` values of this library, and pass values that
//! it made with `new`.

use std::alloc::{Layout, handle_alloc_error};
use std::ffi::c_void;
use std::ptr;

// build.rs links the C++ library.
unsafe extern "C" {
    #[link_name = "_ZnwmRKSt9nothrow_t"]
    fn new_or_null(size: usize, nothrow: *const u8) -> *mut c_void;
    #[link_name = "_ZnamRKSt9nothrow_t"]
    fn new_array_or_null(size: usize, nothrow: *const u8) -> *mut c_void;
    #[link_name = "_ZdlPv"]
    fn operator_delete(block: *mut c_void);
    #[link_name = "_ZdaPv"]
    fn operator_delete_array(block: *mut c_void);
    #[link_name = "_ZSt7nothrow"]
    static NOTHROW: u8;
}

/// The bytes before an array of values with a destructor; they hold the length of the array.
const COUNT: usize = size_of::<usize>();

/// `new T`
pub(crate) fn new<T: Copy>(value: T) -> *mut T {
    let place = allocate(size_of::<T>()).cast::<T>();
    // SAFETY: the block has room for the value, and an alignment that suits every type of Assimp.
    unsafe { place.write(value) };
    place
}

/// `operator new(size)`
pub(crate) fn allocate(size: usize) -> *mut c_void {
    // SAFETY: any size is allowed.
    checked(size, unsafe { new_or_null(size, &raw const NOTHROW) })
}

/// `operator new[](size)`
pub(crate) fn allocate_array(size: usize) -> *mut c_void {
    // SAFETY: any size is allowed.
    checked(size, unsafe { new_array_or_null(size, &raw const NOTHROW) })
}

/// Allocates like `new T[]`, for types without a destructor. Returns NULL for an empty slice, like Assimp.
pub(crate) fn new_array<T: Copy>(values: &[T]) -> *mut T {
    if values.is_empty() {
        return ptr::null_mut();
    }
    let first = allocate_array(size_of_val(values)).cast::<T>();
    // SAFETY: the block is new and has room for the values.
    unsafe { ptr::copy_nonoverlapping(values.as_ptr(), first, values.len()) };
    first
}

/// `new T[]` of values with a destructor; NULL for an empty array.
pub(crate) fn new_counted_array<T: Copy>(values: &[T]) -> *mut T {
    if values.is_empty() {
        return ptr::null_mut();
    }
    let block = allocate_array(COUNT + size_of_val(values));
    // SAFETY: the block is new and has room for the count and, behind it, the values.
    unsafe {
        block.cast::<usize>().write(values.len());
        let first = block.byte_add(COUNT).cast::<T>();
        ptr::copy_nonoverlapping(values.as_ptr(), first, values.len());
        first
    }
}

/// `new T*[]`, with each value in its own block.
pub(crate) fn new_pointers<T: Copy>(values: Vec<T>) -> *mut *mut T {
    new_array(&values.into_iter().map(new).collect::<Vec<_>>())
}

/// `delete`, after the work of the destructor.
///
/// # Safety
/// `block` is NULL or comes from `new`, and is not used any more.
pub(crate) unsafe fn delete<T>(block: *mut T) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { operator_delete(block.cast()) };
}

/// `delete[]` of values without a destructor.
///
/// # Safety
/// `first` is NULL or comes from `new[]`, and is not used any more.
pub(crate) unsafe fn delete_array<T>(first: *mut T) {
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { operator_delete_array(first.cast()) };
}

/// `delete[]` of values with the destructor `destroy`.
///
/// # Safety
/// `first` is NULL or comes from `new[]` of such values, and is not used any more.
pub(crate) unsafe fn delete_counted_array<T>(first: *mut T, destroy: impl Fn(&mut T)) {
    if first.is_null() {
        return;
    }
    // SAFETY: the block begins with the count, and the values follow.
    unsafe {
        let block = first.cast::<usize>().byte_sub(COUNT);
        std::slice::from_raw_parts_mut(first, *block)
            .iter_mut()
            .for_each(destroy);
        operator_delete_array(block.cast());
    }
}

fn checked(size: usize, block: *mut c_void) -> *mut c_void {
    if block.is_null() {
        let layout = Layout::from_size_align(size, 1).unwrap_or(Layout::new::<u8>());
        handle_alloc_error(layout);
    }
    block
}
