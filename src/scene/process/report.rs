//! What is wrong with a scene.

pub use super::validate::{Part, Rule, Violation};
