//! Tools for collections of motions: surveys, search and motion matching.

// Only tests may call `unwrap` and print.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

#[doc(hidden)]
pub mod internals;
pub mod matching;
pub mod survey;
