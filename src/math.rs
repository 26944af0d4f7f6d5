//! The arithmetic that several modules share.

pub(crate) mod rotation;
