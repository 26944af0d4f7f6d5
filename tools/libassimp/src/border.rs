//! The border between Rust and C: errors become strings, and no panic crosses it.

use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::system::calls;

thread_local! {
    /// The error text of the last failed call of this thread.
    static LAST_FAILURE: RefCell<Option<CString>> = const { RefCell::new(None) };
}

/// Runs `call`. If it fails or panics, keeps the error text for the thread and returns `otherwise`.
pub(crate) fn guard<T>(otherwise: T, call: impl FnOnce() -> Result<T, String>) -> T {
    caught(call).unwrap_or_else(|message| {
        LAST_FAILURE.with_borrow_mut(|last| *last = Some(message));
        otherwise
    })
}

/// Runs `call`. If it fails or panics, returns the error text as a string for C.
pub(crate) fn caught<T>(call: impl FnOnce() -> Result<T, String>) -> Result<T, CString> {
    // Only the caller's memory outlives a failed call, and `call` writes it last.
    let result = catch_unwind(AssertUnwindSafe(call)).unwrap_or_else(|panic| Err(describe(&*panic)));
    result.map_err(|message| {
        let before_zero = message.split('\0').next().unwrap_or_default();
        CString::new(before_zero).unwrap_or_default()
    })
}

fn describe(panic: &(dyn Any + Send)) -> String {
    let message = panic.downcast_ref::<&str>().copied();
    let message = message.or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("a defect of the library: {}", message.unwrap_or("of unknown kind"))
}

/// The text of the last failed import or export of this thread; empty if there was none. It is valid until the next
/// failed call.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetErrorString() -> *const c_char {
    LAST_FAILURE.with_borrow(|text| text.as_deref().unwrap_or(c"").as_ptr())
}

/// The text at a pointer.
///
/// # Safety
/// `text` is NULL or ends with a zero byte.
pub(crate) unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a CStr, String> {
    if text.is_null() {
        return Err(format!("{what} is NULL"));
    }
    // SAFETY: the text is not NULL, so it ends with a zero byte.
    Ok(unsafe { CStr::from_ptr(text) })
}

/// The bytes at a pointer; no bytes for NULL.
///
/// # Safety
/// `first` is NULL or points to `size` bytes.
pub(crate) unsafe fn bytes<'a>(first: *const u8, size: usize) -> &'a [u8] {
    match first.is_null() {
        true => &[],
        // SAFETY: there are `size` bytes at a pointer that is not NULL.
        false => unsafe { std::slice::from_raw_parts(first, size) },
    }
}

/// The text of the last error of the system's Assimp; empty if there was none.
pub(crate) fn error_text_of_system() -> String {
    // SAFETY: the function gives a string, which is copied before anything else is called.
    unsafe {
        let text = calls::error_text().map_or(std::ptr::null(), |get| get());
        text_or_empty(text)
    }
}

/// # Safety
/// `text` is NULL or ends with a zero byte.
unsafe fn text_or_empty(text: *const c_char) -> String {
    // SAFETY: the caller's promise in `# Safety`.
    match unsafe { self::text(text, "") } {
        Ok(text) => text.to_string_lossy().into_owned(),
        Err(_) => String::new(),
    }
}

/// The `count` values at a pointer; an empty slice for a count of 0.
///
/// # Safety
/// `count` is 0, or `first` is NULL or points to `count` values.
pub(crate) unsafe fn slice<'a, T>(first: *const T, count: usize, what: &str) -> Result<&'a [T], String> {
    match (count, first.is_null()) {
        (0, _) => Ok(&[]),
        (_, true) => Err(format!("{what} is NULL and should be {count} values")),
        // SAFETY: there are `count` values at a pointer that is not NULL.
        (_, false) => Ok(unsafe { std::slice::from_raw_parts(first, count) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_text() {
        assert_eq!(guard(5, || panic!("gone")), 5);
        // SAFETY: the pointer comes from a `CString`, and no call comes in between.
        let text = unsafe { CStr::from_ptr(aiGetErrorString()) };
        assert_eq!(text.to_str(), Ok("a defect of the library: gone"));
    }
}
