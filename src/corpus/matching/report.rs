//! The results of searches, and how a figure followed its commands.

pub use super::follow::FollowReport;
pub use super::like::Match;
pub use super::play::PlayReport;
