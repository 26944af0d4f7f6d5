//! The report of a scene's violations.

pub use super::validate::{Part, Rule, Violation};
