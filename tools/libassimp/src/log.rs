//! Log streams. This library logs nothing, so a stream is accepted and never called.

use std::ffi::c_char;
use std::ptr;

use crate::abi::{AI_SUCCESS, aiLogStream, aiReturn};

unsafe extern "C" fn say_nothing(_message: *const c_char, _user: *mut c_char) {}

/// A stream that goes nowhere.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiGetPredefinedLogStream(_kind: u32, _file: *const c_char) -> aiLogStream {
    aiLogStream {
        callback: Some(say_nothing),
        user: ptr::null_mut(),
    }
}

/// Takes a stream.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiAttachLogStream(_stream: *const aiLogStream) {}

/// Gives a stream back.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiDetachLogStream(_stream: *const aiLogStream) -> aiReturn {
    AI_SUCCESS
}

/// Gives all streams back.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiDetachAllLogStreams() {}

/// Asks for more words.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn aiEnableVerboseLogging(_on: i32) {}
