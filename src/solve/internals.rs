//! Items for the tests of this package.

pub use crate::biomechanics::events::meaning;
pub use crate::biomechanics::gait::{extended, landings, leavings, turns};
pub use crate::biomechanics::plates::PlateLoads;
pub use crate::biomechanics::series::unique;
pub use crate::markers::landmarks::{Landmark, by_key, keys, set_name};
pub use crate::markers::noise::of as noise;
pub use crate::markers::take::Track;
pub use crate::markers::tree::{Tree, TreeMatrix};
