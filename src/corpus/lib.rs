//! Many motions: surveys, search and motion matching.

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

#[doc(hidden)]
pub mod internals;
pub mod matching;
pub mod survey;
