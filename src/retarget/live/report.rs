//! The report of a network recording.

pub use super::record::VmcCounts;
