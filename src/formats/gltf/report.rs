//! What a glTF file has of its scene.

#[cfg(feature = "gltf")]
pub use super::write::GltfReport;
pub use crate::provenance::Provenance;
pub use crate::report::{Deviation, NodeRename};
