//! What the tests of this package need, and nothing else.

pub use crate::import::large::{BEGINNING, BLOCK, LargeFile, Pages};
