//! What searches find, and how a figure followed what it was asked for.

pub use super::follow::FollowReport;
pub use super::like::Match;
pub use super::play::PlayReport;
