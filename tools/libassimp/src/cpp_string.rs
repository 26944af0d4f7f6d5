//! The memory layout of `std::string` in the GNU C++ library.

use std::ffi::{CStr, c_char};
use std::ptr;

use crate::heap;

/// A string. It contains texts of up to 15 bytes itself, so it must not move after its construction.
#[repr(C)]
pub(crate) struct StdString {
    first: *mut u8,
    length: usize,
    /// The text, or the capacity at `first`.
    local: [u8; LOCAL],
}

/// The bytes that the string itself can hold, including the zero byte.
const LOCAL: usize = 16;

impl StdString {
    pub(crate) fn bytes(&self) -> &[u8] {
        // SAFETY: a string has `length` bytes at `first`, which is never NULL.
        unsafe { std::slice::from_raw_parts(self.first, self.length) }
    }

    /// Calls `use_it` with a string that lives as long as the call.
    pub(crate) fn with<R>(text: &[u8], use_it: impl FnOnce(*const Self) -> R) -> R {
        let mut place = std::mem::MaybeUninit::<Self>::uninit();
        let string = place.as_mut_ptr();
        // SAFETY: the place has room for a string; it is not moved, and destructed below.
        unsafe { Self::construct(string, text) };
        let result = use_it(string);
        // SAFETY: the string was made above; a long text is in a separate block.
        unsafe {
            if text.len() >= LOCAL {
                heap::delete((*string).first);
            }
        }
        result
    }

    pub(crate) fn to_c_string(&self) -> Box<CStr> {
        let bytes = self.bytes();
        let before_zero = bytes.split(|&byte| byte == 0).next().unwrap_or_default();
        let mut text = before_zero.to_vec();
        text.push(0);
        CStr::from_bytes_until_nul(&text).unwrap_or_default().into()
    }

    /// Constructs a string at `place`.
    ///
    /// # Safety
    /// `place` has room for a string.
    pub(crate) unsafe fn construct(place: *mut Self, text: &[u8]) {
        // SAFETY: the caller passes room for a string; the text goes into the string or into a separate block.
        unsafe {
            let local = (&raw mut (*place).local).cast::<u8>();
            let first = if text.len() < LOCAL {
                local
            } else {
                local.cast::<usize>().write_unaligned(text.len());
                heap::allocate(text.len() + 1).cast::<u8>()
            };
            ptr::copy_nonoverlapping(text.as_ptr(), first, text.len());
            first.add(text.len()).write(0);
            (&raw mut (*place).first).write(first);
            (&raw mut (*place).length).write(text.len());
        }
    }
}

/// The text at a pointer, as bytes.
///
/// # Safety
/// `text` is NULL or ends with a zero byte.
pub(crate) unsafe fn bytes_or_empty<'a>(text: *const c_char) -> &'a [u8] {
    match text.is_null() {
        true => b"",
        // SAFETY: the text is not NULL, so it ends with a zero byte.
        false => unsafe { CStr::from_ptr(text) }.to_bytes(),
    }
}
