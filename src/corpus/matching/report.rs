//! The results of searches, and reports of how a figure followed a path or a gamepad.

pub use super::follow::FollowReport;
pub use super::like::Match;
pub use super::play::PlayReport;
