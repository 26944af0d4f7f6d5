//! The report about a glTF file and its scene.

#[cfg(feature = "gltf")]
pub use super::write::GltfReport;
pub use crate::provenance::Provenance;
pub use crate::report::{Deviation, NodeRename};
