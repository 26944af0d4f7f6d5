//! The report of a survey on each clip.

pub use super::corpus::ClipRecord;
pub use super::row::{ClipRow, Defect, Quality};
