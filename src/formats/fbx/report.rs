//! What an FBX file has of its scene.

pub use super::write::FbxReport;
