//! Exports that only the tests of this package need.

pub use crate::clean::gaps::middle_of_nine;
pub use crate::graph::bound::{Bound, NUMBERS, Numbers, SLACK};
pub use crate::graph::clouds::{CloudSpace, Clouds};
pub use crate::graph::distance::Window;
pub use crate::graph::near::{Block, LANES, NeighbourIndex};
pub use crate::lock::shift::{complete, envelope, filled};
pub use crate::warp_path::spline::Spline;
