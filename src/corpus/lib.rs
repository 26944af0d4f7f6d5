//! Many motions: surveys, search and motion matching.

pub mod matching;
pub mod survey;
