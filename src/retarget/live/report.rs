//! What a recording of a network reports.

pub use super::record::VmcCounts;
