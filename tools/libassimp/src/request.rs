//! The file and the settings of an import.

use std::ffi::CStr;

use crate::abi::aiFileIO;
use crate::properties::Properties;
use crate::system_importer::Handlers;

/// The location of a file.
#[derive(Clone, Copy)]
pub(crate) enum Input<'a> {
    /// On the disk, or in the program's file system class.
    File(&'a CStr),
    /// In a file system of C functions.
    FileOf(*mut aiFileIO, &'a CStr),
    /// In memory, with its extension.
    Memory(&'a [u8], &'a CStr),
}

/// The file and the settings of an import.
pub(crate) struct Request<'a> {
    pub(crate) input: Input<'a>,
    pub(crate) flags: u32,
    pub(crate) properties: &'a Properties,
    pub(crate) handlers: Handlers,
    /// Whether the system's Assimp must read the file, whatever its format.
    pub(crate) always_forward: bool,
}

pub(crate) fn unable_to_open(path: &CStr) -> String {
    format!("Unable to open file \"{}\".", path.to_string_lossy())
}
