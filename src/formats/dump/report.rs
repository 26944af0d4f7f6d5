//! What a summary of a scene has.

pub use super::summary::Summary;
