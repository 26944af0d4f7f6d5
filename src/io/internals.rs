//! Items for the tests of this package.

pub use crate::import::large::{BEGINNING, BLOCK, LargeFile, Pages};
