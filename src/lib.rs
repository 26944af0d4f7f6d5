//! Reads motion capture files into an Assimp-style scene, samples it at a tick, and writes animated glTF.
//!
//! [`import()`] reads a file into a [`Scene`], plain data in Assimp's terms. [`Conversion`] brings it to metres with +Y
//! up. [`Pose`] and [`Updater`] compute its node matrices at a tick, [`Player`] the tick at a time. [`gltf`] writes it,
//! [`verify`] compares the written file with its source, [`dump`] prints it, and [`process`] has the steps that change
//! it. [`ik`] turns limbs to a goal, [`edit`] changes motions. [`Code`] lists every diagnostic.
//!
//! ```
//! let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
//! scene.update_node_matrices(0, 9.0);
//! assert_eq!(scene.nodes[0].transform.w_axis.x, 1.0);
//! # Ok::<(), mocap::Error>(())
//! ```
//!
//! # Vectors and matrices
//!
//! Positions, rotations and matrices are types of [`glam`], which is re-exported: use `mocap::glam`, and the versions
//! agree. A program that has another version of glam, or another library, takes arrays; they need no type of this one.
//! [`Pose::node_to_world_arrays`] has those of a whole pose, without a copy; single values become arrays by themselves:
//!
//! ```
//! let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
//! // Column by column, as other libraries and graphics interfaces take them.
//! let columns: [f32; 16] = scene.nodes[0].transform.to_cols_array();
//! let xyzw: [f32; 4] = scene.animations[0].channels[0].rotation_keys.values[0].to_array();
//! assert_eq!((columns[15], xyzw.len()), (1.0, 4));
//! # Ok::<(), mocap::Error>(())
//! ```

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

pub mod arrays;
pub mod compress;
pub mod convert;
pub mod dump;
pub mod edit;
mod error;
pub mod figure;
pub mod files;
mod format;
pub mod ik;
mod import;
pub mod job;
mod limits;
mod math;
mod player;
mod pose;
pub mod process;
#[cfg(feature = "render")]
pub mod render;
pub mod retarget;
pub mod retargeting;
pub mod robot;
pub mod scene;

pub mod verify;

pub use glam;

pub use crate::convert::Conversion;
pub use crate::error::{Code, Diagnostic, Error, Location, Result, visible, visible_lines};
pub use crate::format::gltf::vrma;
pub use crate::format::{FORMATS, FormatInfo, bvh, fbx, gltf};
pub use crate::import::{Clips, Importer, MemoryFile, import};
pub use crate::limits::Limits;
pub use crate::player::{LoopMode, Player};
pub use crate::pose::{Binding, OutOfRange, Pose, Trs, Updater};
pub use crate::process::SkeletonMesh;
pub use crate::retargeting::Retargeting;
pub use crate::scene::{Format, RootOffset, Scene};

/// The README's example runs with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
