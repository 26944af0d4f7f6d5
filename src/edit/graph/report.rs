//! What a motion graph and a walk over it consist of.

pub use super::parts::{GraphClip, GraphTransition};
pub use super::walk::{Walk, WalkPiece};
