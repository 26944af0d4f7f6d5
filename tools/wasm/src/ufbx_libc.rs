//! Replaces the functions of the C library that ufbx needs, because this target has no C library. `build` compiles ufbx
//! with `UFBX_NO_LIBC`, so that ufbx calls these functions.

use std::alloc::Layout;
use std::ffi::{c_char, c_int, c_void};

macro_rules! math {
    ($($name:ident($($argument:ident),+) = $value:expr;)+) => {
        $(#[unsafe(no_mangle)]
        extern "C" fn $name($($argument: f64),+) -> f64 {
            $value
        })+
    };
}

math! {
    ufbx_sqrt(x) = x.sqrt();
    ufbx_sin(x) = x.sin();
    ufbx_cos(x) = x.cos();
    ufbx_tan(x) = x.tan();
    ufbx_asin(x) = x.asin();
    ufbx_acos(x) = x.acos();
    ufbx_atan(x) = x.atan();
    ufbx_atan2(y, x) = y.atan2(x);
    ufbx_pow(x, y) = x.powf(y);
    ufbx_fmin(a, b) = a.min(b);
    ufbx_fmax(a, b) = a.max(b);
    ufbx_fabs(x) = x.abs();
    ufbx_copysign(x, y) = x.copysign(y);
    ufbx_nextafter(x, y) = if x < y { x.next_up() } else if x > y { x.next_down() } else { y };
    ufbx_rint(x) = x.round_ties_even();
    ufbx_floor(x) = x.floor();
    ufbx_ceil(x) = x.ceil();
}

#[unsafe(no_mangle)]
extern "C" fn ufbx_isnan(x: f64) -> c_int {
    c_int::from(x.is_nan())
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_strlen(text: *const c_char) -> usize {
    // SAFETY: the caller's text ends with a zero.
    unsafe { std::ffi::CStr::from_ptr(text) }.count_bytes()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_memcpy(to: *mut c_void, from: *const c_void, count: usize) -> *mut c_void {
    // SAFETY: the caller has `count` bytes at both pointers, which do not overlap.
    unsafe { std::ptr::copy_nonoverlapping(from.cast::<u8>(), to.cast::<u8>(), count) };
    to
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_memmove(to: *mut c_void, from: *const c_void, count: usize) -> *mut c_void {
    // SAFETY: the caller has `count` bytes at both pointers.
    unsafe { std::ptr::copy(from.cast::<u8>(), to.cast::<u8>(), count) };
    to
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_memset(to: *mut c_void, byte: c_int, count: usize) -> *mut c_void {
    // SAFETY: the caller has `count` bytes at `to`.
    unsafe { std::ptr::write_bytes(to.cast::<u8>(), byte as u8, count) };
    to
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_memchr(from: *const c_void, byte: c_int, count: usize) -> *const c_void {
    // SAFETY: the caller has `count` bytes at `from`, and nothing is read if `count` is 0.
    let bytes = unsafe { bytes(from, count) };
    match bytes.iter().position(|found| *found == byte as u8) {
        Some(place) => from.wrapping_byte_add(place),
        None => std::ptr::null(),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_memcmp(a: *const c_void, b: *const c_void, count: usize) -> c_int {
    // SAFETY: the caller has `count` bytes at both pointers.
    let (a, b) = unsafe { (bytes(a, count), bytes(b, count)) };
    a.cmp(b) as c_int
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_strcmp(a: *const c_char, b: *const c_char) -> c_int {
    // SAFETY: both strings of the caller end with a zero.
    let (a, b) = unsafe { (std::ffi::CStr::from_ptr(a), std::ffi::CStr::from_ptr(b)) };
    a.to_bytes().cmp(b.to_bytes()) as c_int
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_strncmp(a: *const c_char, b: *const c_char, count: usize) -> c_int {
    for index in 0..count {
        // SAFETY: both strings of the caller end with a zero, and no byte after the zero is read.
        let (a, b) = unsafe { (*a.add(index).cast::<u8>(), *b.add(index).cast::<u8>()) };
        if a != b || a == 0 {
            return a.cmp(&b) as c_int;
        }
    }
    0
}

/// A slice of `count` bytes. `from` may be null if `count` is 0.
unsafe fn bytes<'a>(from: *const c_void, count: usize) -> &'a [u8] {
    match count {
        0 => &[],
        // SAFETY: the caller guarantees `count` bytes at `from`.
        _ => unsafe { std::slice::from_raw_parts(from.cast(), count) },
    }
}

/// The layout of an allocation, with the alignment of C's `malloc`.
fn layout(size: usize) -> Option<Layout> {
    Layout::from_size_align(size.max(1), 16).ok()
}

#[unsafe(no_mangle)]
extern "C" fn ufbx_malloc(size: usize) -> *mut c_void {
    match layout(size) {
        // SAFETY: the size is above 0.
        Some(layout) => unsafe { std::alloc::alloc(layout) }.cast(),
        None => std::ptr::null_mut(),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_realloc(from: *mut c_void, old_size: usize, new_size: usize) -> *mut c_void {
    match (layout(old_size), layout(new_size)) {
        _ if from.is_null() => ufbx_malloc(new_size),
        // SAFETY: `from` was allocated above with the layout `old`, and both sizes are above 0.
        (Some(old), Some(new)) => unsafe { std::alloc::realloc(from.cast(), old, new.size()) }.cast(),
        _ => std::ptr::null_mut(),
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn ufbx_free(from: *mut c_void, old_size: usize) {
    if let (false, Some(layout)) = (from.is_null(), layout(old_size)) {
        // SAFETY: `from` was allocated above with this layout.
        unsafe { std::alloc::dealloc(from.cast(), layout) };
    }
}
