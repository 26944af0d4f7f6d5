//! Files of motion capture to scenes, and back.

pub mod convert;
pub mod export;
pub mod import;

pub use self::convert::convert;
pub use self::export::Exporter;
pub use self::import::{Clips, Importer, MemoryFile, import};
