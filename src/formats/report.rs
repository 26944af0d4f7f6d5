//! How far written files are from their scene, and what had to change.

pub use crate::written::{Deviation, NodeRename};
