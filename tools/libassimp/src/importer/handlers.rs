//! The importer's handlers: the program's file system and its progress. The importer owns its handlers; NULL returns a
//! handler to the program.

use std::ffi::c_void;
use std::ptr;

use super::registry;
use super::state::methods;
use crate::system::calls;
use crate::virtual_call::{IoSystem, Progress, delete_object};

methods! {
    /// `void SetIOHandler(IOSystem *io)`
    fn _ZN6Assimp8Importer12SetIOHandlerEPNS_8IOSystemE(state, io: *mut c_void) -> () | () => {
        let before = std::mem::replace(&mut state.handlers.io, IoSystem(io));
        if !io.is_null() && before != IoSystem(io) {
            // SAFETY: the importer owns the handler before.
            unsafe { delete_object(before.0) };
        }
    }

    /// `IOSystem *GetIOHandler() const`: the program's handler, otherwise the handler of the system's Assimp.
    fn _ZNK6Assimp8Importer12GetIOHandlerEv(state) -> *mut c_void | ptr::null_mut() => {
        match state.handlers.io.0.is_null() {
            true => registry::handler(state, calls::io_handler()),
            false => state.handlers.io.0,
        }
    }

    /// `bool IsDefaultIOHandler() const`
    fn _ZNK6Assimp8Importer18IsDefaultIOHandlerEv(state) -> bool | true => state.handlers.io.0.is_null()

    /// `void SetProgressHandler(ProgressHandler *progress)`
    fn _ZN6Assimp8Importer18SetProgressHandlerEPNS_15ProgressHandlerE(
        state, progress: *mut c_void
    ) -> () | () => {
        let before = std::mem::replace(&mut state.handlers.progress, Progress(progress));
        if !progress.is_null() && before.0 != progress {
            // SAFETY: the importer owns the handler before.
            unsafe { delete_object(before.0) };
        }
    }

    /// `ProgressHandler *GetProgressHandler() const`: the program's handler, otherwise the handler of the system's
    /// Assimp.
    fn _ZNK6Assimp8Importer18GetProgressHandlerEv(state) -> *mut c_void | ptr::null_mut() => {
        match state.handlers.progress.0.is_null() {
            true => registry::handler(state, calls::progress_handler()),
            false => state.handlers.progress.0,
        }
    }

    /// `bool IsDefaultProgressHandler() const`
    fn _ZNK6Assimp8Importer24IsDefaultProgressHandlerEv(state) -> bool | true => state.handlers.progress.0.is_null()
}
