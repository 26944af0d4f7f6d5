//! Assimp 5.2.5's binary interface over `mocap`.
//!
//! A program that was compiled against Assimp's headers and loads motion runs with this library in place of Assimp's.
//! The exported functions have the names and the behaviour that those headers document; the README lists the
//! differences.

#![allow(unsafe_code, reason = "pointers of other languages go in and out")]
// The names are Assimp's.
#![allow(non_snake_case)]
#![deny(clippy::missing_safety_doc, clippy::undocumented_unsafe_blocks)]
// Tests may unwrap; the library may not.
#![warn(clippy::unwrap_used)]

mod abi;
mod arena;
mod border;
mod export;
mod flags;
mod from_assimp;
mod import;
mod importer;
mod log;
mod material;
mod math;
mod node;
mod properties;
mod to_assimp;
mod version;
