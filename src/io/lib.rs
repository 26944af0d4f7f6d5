//! Reads motion capture files into scenes, and writes scenes to files.

// Only tests may call `unwrap` and print.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

pub mod convert;
pub mod export;
pub mod import;
#[doc(hidden)]
pub mod internals;

pub use self::convert::convert;
pub use self::export::Exporter;
pub use self::import::{Clips, Importer, MemoryFile, import};
