//! What is to be imported, and how.

use std::ffi::CStr;

use crate::abi::aiFileIO;
use crate::properties::Properties;
use crate::system_importer::Handlers;

/// Where a file is.
#[derive(Clone, Copy)]
pub(crate) enum Input<'a> {
    /// On the disk, or in the program's own file system.
    File(&'a CStr),
    /// In a file system that C functions are.
    FileOf(*mut aiFileIO, &'a CStr),
    /// In memory, with its extension.
    Memory(&'a [u8], &'a CStr),
}

/// What is to be imported, and how.
pub(crate) struct Request<'a> {
    pub(crate) input: Input<'a>,
    pub(crate) flags: u32,
    pub(crate) properties: &'a Properties,
    pub(crate) handlers: Handlers,
    /// Whether the system's Assimp is to read it, whatever it is.
    pub(crate) always_forward: bool,
}

pub(crate) fn unable_to_open(path: &CStr) -> String {
    format!("Unable to open file \"{}\".", path.to_string_lossy())
}
