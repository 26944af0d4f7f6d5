//! The types that describe a motion graph and a walk through it.

pub use super::parts::{GraphClip, GraphTransition};
pub use super::walk::{Walk, WalkPiece};
