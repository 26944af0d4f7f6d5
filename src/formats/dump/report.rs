//! The type of a scene's summary.

pub use super::summary::Summary;
