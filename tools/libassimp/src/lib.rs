//! Assimp 5.2.5's binary interface over `mocap`.
//!
//! A program that was compiled against Assimp's headers runs with this library in place of Assimp's. This library reads
//! motion, and passes all other work to the system's own Assimp, if there is one. The exported symbols have the names
//! and the behaviour that the headers document; the README lists the differences.

// The interface matches Debian's library for x86-64, because the stubs are in assembler. On other systems, this crate
// is empty.
#![cfg(all(target_os = "linux", target_arch = "x86_64"))]
#![allow(unsafe_code, reason = "pointers of other languages go in and out")]
// The names come from Assimp and from the C++ compiler.
#![allow(non_snake_case, non_upper_case_globals)]
#![deny(clippy::missing_safety_doc, clippy::undocumented_unsafe_blocks)]
// Tests may unwrap; the library may not.
#![warn(clippy::unwrap_used)]

mod abi;
mod allocation;
mod border;
mod c_files;
mod c_import;
mod contents;
mod cpp_string;
mod destroy;
mod export;
mod exporter;
mod extensions;
mod flags;
mod forward;
mod from_assimp;
mod gltf;
mod heap;
mod import;
mod importer;
mod log;
mod material;
mod math;
mod memory_info;
mod properties;
mod request;
mod scene;
mod system;
mod system_importer;
mod to_assimp;
mod version;
mod virtual_call;
