//! The report about written files: their deviation from the scene, and necessary changes.

pub use crate::written::{Deviation, NodeRename};
