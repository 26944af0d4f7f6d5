//! The report of the FBX writer.

pub use super::write::FbxReport;
