//! Calls virtual functions of the program's objects, by their index in the table of their class.

use std::ffi::{c_char, c_int, c_void};

use crate::cpp_string::bytes_or_empty;

/// The function at an index of the table to which an object's first word points.
///
/// # Safety
/// `object` has such a table, with a function of type `F` at this index.
unsafe fn function<F: Copy>(object: *mut c_void, place: usize) -> F {
    const { assert!(size_of::<F>() == size_of::<*mut c_void>()) };
    // SAFETY: the caller's promise in `# Safety`.
    unsafe { object.cast::<*const F>().read().add(place).read() }
}

/// `delete object`, for an object with a virtual destructor; NULL is allowed.
///
/// # Safety
/// `object` is NULL, or such an object that is not used any more.
pub(crate) unsafe fn delete_object(object: *mut c_void) {
    if !object.is_null() {
        // SAFETY: the second function of such a class destructs an object and frees it.
        unsafe { function::<unsafe extern "C" fn(*mut c_void)>(object, 1)(object) };
    }
}

/// An `Assimp::IOSystem` of the program.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct IoSystem(pub(crate) *mut c_void);

impl IoSystem {
    /// All bytes of a file, or its first `most`; `None` if it cannot be opened.
    ///
    /// # Safety
    /// This is an `IOSystem`, and `path` ends with a zero byte.
    pub(crate) unsafe fn read(self, path: *const c_char, most: usize) -> Option<Vec<u8>> {
        type Open = unsafe extern "C" fn(*mut c_void, *const c_char, *const c_char) -> *mut c_void;
        type Close = unsafe extern "C" fn(*mut c_void, *mut c_void);
        type Read = unsafe extern "C" fn(*mut c_void, *mut c_void, usize, usize) -> usize;
        type Size = unsafe extern "C" fn(*mut c_void) -> usize;
        // SAFETY: these are the places of the functions in the classes `IOSystem` and `IOStream` of the headers.
        unsafe {
            let stream = function::<Open>(self.0, 4)(self.0, path, c"rb".as_ptr());
            if stream.is_null() {
                return None;
            }
            let size = function::<Size>(stream, 6)(stream).min(most);
            let mut bytes = vec![0; size];
            let count = function::<Read>(stream, 2)(stream, bytes.as_mut_ptr().cast(), 1, size);
            bytes.truncate(count);
            function::<Close>(self.0, 5)(self.0, stream);
            Some(bytes)
        }
    }
}

/// An `Assimp::ProgressHandler` of the program; NULL for none.
#[derive(Clone, Copy)]
pub(crate) struct Progress(pub(crate) *mut c_void);

impl Progress {
    /// `UpdateFileRead(done, all)`
    ///
    /// # Safety
    /// This is NULL or a `ProgressHandler`.
    pub(crate) unsafe fn file_read(self, done: c_int, all: c_int) {
        // SAFETY: the caller's promise in `# Safety`.
        unsafe { self.update(3, done, all) };
    }

    /// `UpdatePostProcess(done, all)`
    ///
    /// # Safety
    /// This is NULL or a `ProgressHandler`.
    pub(crate) unsafe fn post_process(self, done: c_int, all: c_int) {
        // SAFETY: the caller's promise in `# Safety`.
        unsafe { self.update(4, done, all) };
    }

    /// # Safety
    /// This is NULL or a `ProgressHandler`.
    unsafe fn update(self, place: usize, done: c_int, all: c_int) {
        if !self.0.is_null() {
            // SAFETY: these are the places of the functions in the class of the headers.
            unsafe { function::<unsafe extern "C" fn(*mut c_void, c_int, c_int)>(self.0, place)(self.0, done, all) };
        }
    }
}

/// Passes a message to the function at an index of an `Assimp::Logger`'s table: 4 debug, 5 verbose debug, 6 info, 7
/// warning, 8 error.
///
/// # Safety
/// `logger` is a `Logger`, and `message` is NULL or ends with a zero byte.
pub(crate) unsafe fn log(logger: *mut c_void, place: usize, message: *const c_char) {
    /// Longer messages are an error in Assimp, too.
    const LONGEST: usize = 1024;
    // SAFETY: the caller's promise in `# Safety`.
    unsafe {
        if bytes_or_empty(message).len() <= LONGEST && !message.is_null() {
            function::<unsafe extern "C" fn(*mut c_void, *const c_char)>(logger, place)(logger, message);
        }
    }
}
