//! What a survey reports of each clip.

pub use super::corpus::ClipRecord;
pub use super::row::{ClipRow, Defect, Quality};
