//! Motion capture scenes: the data, and functions that need only the data.

// Tests may unwrap and print; the library may not.
#![warn(clippy::unwrap_used, clippy::print_stdout, clippy::print_stderr)]

pub mod error;
pub mod files;
#[cfg(feature = "ik")]
pub mod ik;
#[doc(hidden)]
pub mod internals;
pub mod limits;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod options;
pub mod player;
pub mod pose;
pub mod process;
pub mod report;
pub mod scene;

pub use self::error::{Code, Diagnostic, Error, Location, Result};
#[doc(hidden)]
pub use self::error::{visible, visible_json};
pub use self::limits::Limits;
pub use self::player::{LoopMode, Player};
pub use self::pose::{Binding, ChainMatrix, OutOfRange, Pose, Trs, Updater};
pub use self::process::SkeletonMesh;
pub use self::scene::{Format, RootOffset, Scene};
