//! The tests of compression with meshopt, in a program of their own: all other tests run without a C++ compiler, and
//! need not be built a second time.

#[path = "it/compressed_characters.rs"]
mod compressed_characters;
#[path = "it/compression.rs"]
mod compression;
#[path = "it/error_bounds.rs"]
mod error_bounds;
#[path = "it/sample.rs"]
mod sample;
